"""
``quadwalk robot``: check a robot data file, say what follows from it, print its URDF.
"""

from __future__ import annotations

import argparse
import json

from quad_common.robot.robot_figures import derived_figures
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.robot.urdf import published_urdf

EXAMPLES = f"""examples:
  quadwalk robot check titan_viii
  quadwalk robot urdf titan_viii > titan_viii.urdf

robots that ship: {', '.join(available_robots())}
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('action', choices=('check', 'urdf'))
    parser.add_argument('robot', help='name of a robot, or path of a data file')
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    robot = load_robot(arguments.robot)
    if arguments.action == 'urdf':
        print(published_urdf(robot))
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
