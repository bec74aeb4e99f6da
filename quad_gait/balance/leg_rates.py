"""
What joints need for a swing, and how feet roll on the ground, in the initial posture.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_gait.cycle.gait import Gait


def lift_height(robot: Robot, gait: Gait, easing: float, fraction: float) -> float:
    """
    Return how high feet are lifted at most, with as much of the joints' speeds as is for that.

    Half an ellipse of the height H is at its fastest as the foot lifts and lands: pi H / T in its
    time T, and faster by what easing takes of it.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        Its trot.
    easing : float
        Fraction of a swing in which a foot gathers that speed, and again loses it.
    fraction : float
        Fraction of the joints' largest speeds that lifting may need; the rest is for going ahead.

    Returns
    -------
    float
        Height [m].
    """
    fastest = fraction / float(_use_per_speed(robot)[..., 2].max())
    return fastest * (1.0 - easing) * _shortest_swing(gait) / math.pi


def swing_use(robot: Robot, gait: Gait, height: float) -> float:
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
    height : float
        Height H to which feet are lifted [m].

    Returns
    -------
    float
        Of the joint that needs most, as a fraction of its largest speed; for both together.
    """
    use = _use_per_speed(robot)
    ahead = 1.5 * robot.largest_stride * use[..., 0].max()
    up = math.pi * height * use[..., 2].max()
    return float(ahead + up) / _shortest_swing(gait)


def _use_per_speed(robot: Robot) -> NDArray[np.float64]:
    """Return which fraction of its largest speed each joint needs for a foot's, (4, 3, 3) [s/m]."""
    per_speed = np.linalg.inv(robot.foot_jacobians(robot.initial_joint_angles))
    limits = np.broadcast_to(robot.velocity, per_speed.shape[:2])
    use: NDArray[np.float64] = np.abs(per_speed / limits[..., None])
    return use


def _shortest_swing(gait: Gait) -> float:
    """Return the duration of a gait's shortest swing [s]."""
    return min(swing.touchdown - swing.liftoff for swing in gait.swings)


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
