"""
``quadwalk robot``: check a robot data file, say what follows from it, print its URDF.
"""

from __future__ import annotations

import argparse
import json
import math

import numpy as np

from quad_common.robot import Robot, available_robots, load_robot
from quad_common.urdf import urdf_from_robot

EXAMPLES = f"""examples:
  quadwalk robot check titan_viii
  quadwalk robot urdf titan_viii > titan_viii.urdf

robots that ship: {', '.join(available_robots())}
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('action', choices=('check', 'urdf'))
    parser.add_argument('robot', help='name or data file')
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    robot = load_robot(arguments.robot)
    if arguments.action == 'urdf':
        print(urdf_from_robot(robot))
        return 0
    figures = derived_figures(robot)
    overlapping = [str(pair) for pair in robot.own_parts.ignored]
    if arguments.json:
        print(json.dumps({**figures, 'parts_not_watched': overlapping}))
        return 0
    print(f'{robot.name}: {len(robot.sources)} numbers, each with its source')
    for name, value in figures.items():
        print(f'  {name.replace("_", " "):28} {value}')
    if overlapping:
        print(
            f'  nearer than {1e3 * robot.own_parts.least:.1f} mm in the initial posture, and so '
            f'not kept apart: {", ".join(overlapping)}'
        )
    return 0


def derived_figures(robot: Robot) -> dict[str, float]:
    """Work out what follows from a robot's data, rounded for people."""
    angles = robot.initial_joint_angles
    nearest = robot.own_parts.nearest(angles[None])
    feet = robot.foot_positions(robot.joint_angles(robot.neutral_feet))
    return {
        'mass_kg': round(robot.mass, 3),
        'hip_height_mm': round(1e3 * robot.hip_height, 2),
        'stance_reach_mm': round(1e3 * robot.stance_reach, 2),
        'largest_stride_mm': round(1e3 * robot.largest_stride, 2),
        'largest_turn_deg': round(math.degrees(robot.largest_turn), 2),
        'step_height_mm': round(1e3 * robot.step_height, 2),
        'mesh_size_mm': round(1e3 * robot.mesh_size, 2),
        'footprint_radius_mm': round(1e3 * robot.footprint_radius, 2),
        'center_of_mass_height_mm': round(
            1e3 * (robot.standing_height + float(robot.center_of_mass(angles)[2])), 2
        ),
        'own_parts_clearance_mm': round(1e3 * nearest.clearance, 2),
        'kinematics_error_mm': round(1e3 * float(np.abs(feet - robot.neutral_feet).max()), 9),
    }
