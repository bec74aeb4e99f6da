"""
What follows from a robot's data, for people.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.robot.robot import Robot


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
        'center_of_mass_height_mm': round(1e3 * robot.center_height, 2),
        'own_parts_clearance_mm': round(1e3 * nearest.clearance, 2),
        'kinematics_error_mm': round(1e3 * float(np.abs(feet - robot.neutral_feet).max()), 9),
    }
