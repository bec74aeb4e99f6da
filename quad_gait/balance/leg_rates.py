"""
What joints need for a swing, and how feet roll on the ground, in the initial posture.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.robot.robot import Robot
from quad_gait.cycle.gait import Gait


def swing_use(robot: Robot, gait: Gait) -> float:
    """
    Return how much of their largest speeds the joints need for a swing.

    At its fastest a foot goes 1.5 L / T forward in the largest stride L, along a cubic, and
    pi H / T up to its height H, in its time T; in the initial posture.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        Its trot.

    Returns
    -------
    float
        Of the joint that needs most, as a fraction of its largest speed; for both together.
    """
    duration = min(swing.touchdown - swing.liftoff for swing in gait.swings)
    per_speed = np.linalg.inv(robot.foot_jacobians(robot.initial_joint_angles))
    per_speed = np.abs(per_speed / np.broadcast_to(robot.velocity, per_speed.shape[:2])[..., None])
    ahead = 1.5 * robot.largest_stride * per_speed[..., 0].max()
    up = math.pi * gait.swing_height * per_speed[..., 2].max()
    return float(ahead + up) / duration


def rolling_factors(robot: Robot) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """
    Return what the ground's velocity beside the body is multiplied by for the feet's centers.

    With a body at v the center of a foot that stands moves beside it by u, and rolls on its ball
    of the radius r as the calf turns, by w = C J^-1 u: from u + v = r w x z follows
    u = -(I - r [. x z] C J^-1)^-1 v; in the plane, and in the initial posture.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    list of tuple
        A matrix of 2 rows for each foot.
    """
    joints = robot.initial_joint_angles
    jacobians = robot.foot_jacobians(joints)
    factors = []
    for leg in range(len(joints)):
        columns = []
        for axis in range(2):
            moves = np.zeros((len(joints), 3))
            moves[leg, axis] = 1.0
            solved = np.linalg.solve(jacobians, moves[..., None])
            speeds = np.asarray(solved[..., 0], dtype=np.float64)
            calf = robot.calf_angular_velocities(joints, speeds)[leg]
            columns.append([robot.foot_radius * calf[1], -robot.foot_radius * calf[0]])
        (a, b), (c, d) = np.linalg.inv(np.eye(2) - np.array(columns).T).tolist()
        factors.append(((a, b), (c, d)))
    return factors
