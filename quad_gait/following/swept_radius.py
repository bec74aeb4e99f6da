"""
How far the robot's parts reach around its place while it goes through a cycle.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait_generator import generate_largest_cycle
from quad_gait.cycle.motion_limits import MotionLimits

_FRACTIONS = (0.1, 0.25, 0.5, 0.75, 1.0)
"""Fractions of the largest turn that are looked at: in small ones knees may reach farther."""


def swept_radius(robot: Robot, cycle: Cycle) -> float:
    """
    Work out the radius of the circle that holds the robot throughout a cycle.

    The robot's footprint holds it while it stands; in a cycle of a static gait the body sways,
    and the knees reach out with it.

    Parameters
    ----------
    robot : Robot
        The robot.
    cycle : Cycle
        Cycle that begins with the body at the origin of the ground frame.

    Returns
    -------
    float
        Largest horizontal distance from the origin of the ground frame to any part [m].
    """
    shape = robot.own_parts.shape
    ends, radii = shape.part_ends(cycle.joint_positions)
    corners = shape.body_corners()
    box = np.broadcast_to(corners, (len(ends), *corners.shape))
    points = np.concatenate((ends, box), axis=1)
    cos, sin = np.cos(cycle.body[:, 2, None]), np.sin(cycle.body[:, 2, None])
    x = cycle.body[:, 0, None] + cos * points[..., 0] - sin * points[..., 1]
    y = cycle.body[:, 1, None] + sin * points[..., 0] + cos * points[..., 1]
    return float(np.max(np.hypot(x, y) + np.append(radii, np.zeros(len(corners)))))


def sweep_of_turns(robot: Robot, limits: MotionLimits) -> float:
    """
    Work out how far the robot's parts leave its circle when it turns on the spot.

    Parameters
    ----------
    robot : Robot
        The robot.
    limits : MotionLimits
        What the gait for turning can do.

    Returns
    -------
    float
        Distance beyond `Robot.standing_radius`, of turns of any size to both sides; 0 if
        everything stays within it [m].
    """
    radii = []
    for side, fraction in product((1.0, -1.0), _FRACTIONS):
        largest = limits.largest_scale(BodyMotion(turn=side))
        turn = BodyMotion(turn=side * fraction * largest)
        cycle = generate_largest_cycle(robot, limits.gait_for(turn), turn)
        radii.append(swept_radius(robot, cycle))
    return max(0.0, max(radii) - robot.standing_radius)
