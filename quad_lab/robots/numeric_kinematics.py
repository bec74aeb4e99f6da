"""
Inverse kinematics by iteration beside closed forms, on the same legs.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_kinematics import Leg, stack_legs
from quad_common.robot.robot import Robot
from quad_common.serial_legs.serial_leg import AxesAtZero, SerialLeg, serial_leg

Array = NDArray[np.float64]

_POSTURES = 200

_REPEATS = 7

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
    """The same of the iteration [s]."""


def iterated_legs(robot: Robot) -> SerialLeg:
    """Return a robot's four legs, stacked, as ones that no closed formulas are known of."""
    legs = stack_legs(
        [
            serial_leg(
                str(leg.name),
                _axes_at_zero(leg),
                robot.lower[k],
                robot.upper[k],
                robot.initial_joint_angles[k],
            )
            for k, leg in enumerate(robot.legs)
        ]
    )
    assert isinstance(legs, SerialLeg)
    return legs


def _axes_at_zero(leg: Leg) -> AxesAtZero:
    """Take axes and points of a leg in closed form, with all joint angles at 0."""
    at_zero = np.zeros(3)
    chain = leg.chain(at_zero)
    _, (_, across, along) = leg.part_frames(at_zero, chain)[0]
    axes = np.array([along, across, across]) * np.reshape(leg.signs, (3, 1))
    return AxesAtZero(axes, np.array([leg.hip, *chain[:2]]), chain[2])


def compare_kinematics(robot: Robot, seed: int) -> KinematicsComparison:
    """
    Solve the same postures in closed form and by iteration.

    Parameters
    ----------
    robot : Robot
        The robot, whose legs have closed formulas.
    seed : int
        Of the postures.
    """
    rng = np.random.default_rng(seed)
    spread = rng.uniform(-_SPREAD, _SPREAD, (_POSTURES, 4, 3))
    postures = np.clip(robot.initial_joint_angles + spread, robot.lower, robot.upper)
    feet = robot.foot_positions(postures)
    iterated = iterated_legs(robot)
    # Compiles the loop, and finds the aspects.
    iterated.inverse(feet[:1])
    closed, numeric = robot.stacked_legs.inverse(feet), iterated.inverse(feet)
    return KinematicsComparison(
        difference=float(np.abs(closed - numeric).max()),
        closed=_shortest(robot.stacked_legs, feet) / _POSTURES,
        numeric=_shortest(iterated, feet) / _POSTURES,
    )


def _shortest(legs: Leg, feet: Array) -> float:
    """Return the shortest of a few times that inverse kinematics take [s]."""
    times = []
    for _ in range(_REPEATS):
        began = time.perf_counter()
        legs.inverse(feet)
        times.append(time.perf_counter() - began)
    return min(times)
