"""
Inverse kinematics by iteration, to compare closed forms with.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

_POSTURES = 200

_SPREAD = 0.3
"""Angle by which postures differ from the initial one [rad]."""


@dataclass(frozen=True)
class KinematicsComparison:
    """Closed form beside iteration."""

    difference: float
    """Largest difference of joint angles [rad]."""
    closed: float
    """Time of the closed form for four legs, in one call for all postures [s]."""
    numeric: float
    """Time of the iteration for four legs [s]."""


def compare_kinematics(robot: Robot, seed: int) -> KinematicsComparison:
    """
    Solve the same postures in closed form and by iteration.

    Parameters
    ----------
    robot : Robot
        The robot.
    seed : int
        Of the postures.
    """
    rng = np.random.default_rng(seed)
    spread = rng.uniform(-_SPREAD, _SPREAD, (_POSTURES, 4, 3))
    postures = np.clip(robot.initial_joint_angles + spread, robot.lower, robot.upper)
    feet = robot.foot_positions(postures)
    began = time.perf_counter()
    closed = robot.stacked_legs.inverse(feet)
    between = time.perf_counter()
    numeric = np.array([_solved(robot, wanted) for wanted in feet])
    ended = time.perf_counter()
    return KinematicsComparison(
        difference=float(np.abs(closed - numeric).max()),
        closed=(between - began) / _POSTURES,
        numeric=(ended - between) / _POSTURES,
    )


def _solved(robot: Robot, feet: Array) -> Array:
    """Find the joint angles (4, 3) that put the feet (4, 3) [m] where they are wanted."""
    found = np.empty((4, 3))
    for leg in range(4):
        own, wanted = robot.legs[leg], feet[leg]
        solution = least_squares(
            lambda q, own=own, wanted=wanted: own.forward(q) - wanted,
            robot.initial_joint_angles[leg],
            jac=lambda q, own=own: own.jacobian(q),
            xtol=1e-15,
            ftol=1e-15,
            gtol=1e-15,
        )
        found[leg] = solution.x
    return found
