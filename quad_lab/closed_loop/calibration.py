"""
Measures in simulation how far a gait goes, and finds what to ask it for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.following.slip_compensation import Calibration
from quad_lab.closed_loop.closed_loop import ClosedLoop, DoesNotWalk
from quad_lab.closed_loop.controllers import controller_for, largest_speed
from quad_sim.engines.registry import AUTO

Array = NDArray[np.float64]

DIRECTIONS = (
    BodyMotion(forward=1.0),
    BodyMotion(forward=-1.0),
    BodyMotion(left=1.0),
    BodyMotion(left=-1.0),
    BodyMotion(turn=1.0),
    BodyMotion(turn=-1.0),
)
"""Calibrated if nothing else is asked for, each at two speeds."""

FRACTIONS = (0.35, 0.7)
"""Of the largest motion in each direction."""

_SKIPPED = 4
"""First cycles that are not measured, until the robot has gathered speed."""


@dataclass(frozen=True)
class MeasuredMotion:
    """What a gait does, cycle by cycle, when left alone."""

    mean: BodyMotion
    """Of one cycle."""
    spread: float
    """Standard deviation of a cycle's end, about the mean [m]; 1 rad counts as 0.2 m."""
    has_fallen: bool
    """Mean and spread are then of the cycles before, or nan."""


def measure_motion(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    cycles: int = 16,
    backend: str = AUTO,
) -> MeasuredMotion:
    """
    Walk open loop, and see how far a cycle goes.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    motion : BodyMotion
        What is asked of each cycle.
    cycles : int
        How many are measured, after the first few.
    backend : str
        The simulator.

    Returns
    -------
    MeasuredMotion
        Mean and spread.
    """
    options = SupervisorOptions(
        least_margin=0.0, settle_time=0.1, hold_course=False, twist_timeout=math.inf
    )
    controller = controller_for(robot, gait, options)
    walk = ClosedLoop(robot, controller, backend)
    try:
        walk.run(0.1)
        controller.set_twist(motion.rate(gait.cycle_period))
        walk.run(
            30.0 + gait.cycle_period,
            until=lambda: controller.cycle is not None or controller.activity.is_disabled,
        )
        ends: list[Pose2D] = []
        while len(ends) < _SKIPPED + cycles + 1 and not walk.record.has_fallen:
            try:
                ends.append(walk.next_cycle_end())
            except DoesNotWalk:
                if not walk.record.has_fallen:
                    raise
    finally:
        walk.close()
    ends = ends[_SKIPPED:]
    if len(ends) < 2:
        lost = BodyMotion(math.nan, math.nan, math.nan)
        return MeasuredMotion(lost, math.nan, walk.record.has_fallen)
    parts = np.array([vector(BodyMotion.reaching(a.inverse() @ b)) for a, b in pairwise(ends)])
    mean = BodyMotion(*parts.mean(axis=0).tolist())
    spread = parts.std(axis=0) * (1.0, 1.0, 0.2)
    return MeasuredMotion(mean, float(np.linalg.norm(spread)), walk.record.has_fallen)


def calibrate_motion(
    robot: Robot, gait: Gait, wanted: BodyMotion, rounds: int = 4, cycles: int = 16
) -> tuple[Calibration, MeasuredMotion, MeasuredMotion]:
    """
    Find what to ask a gait for so that it does what is wanted.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    wanted : BodyMotion
        What one cycle is to do.
    rounds : int
        How often the measured error is taken off what is asked.
    cycles : int
        Measured in each round.

    Returns
    -------
    tuple of Calibration and two MeasuredMotion
        The best that was found, and what the gait did without and with it.
    """
    asked = wanted
    first = best = measure_motion(robot, gait, asked, cycles)
    best_asked = asked
    result = first
    for _ in range(rounds):
        if result.has_fallen:
            break
        error = vector(wanted) - vector(result.mean)
        asked = BodyMotion(*(vector(asked) + error).tolist())
        result = measure_motion(robot, gait, asked, cycles)
        if not result.has_fallen and motion_error(result, wanted) < motion_error(best, wanted):
            best, best_asked = result, asked
    return Calibration(gait.name, gait.cycle_period, wanted, best_asked), first, best


def default_motions(robot: Robot, gait: Gait) -> list[BodyMotion]:
    """Return the six directions at two speeds that the gait, or its turn, is capable of."""
    period = gait.cycle_period
    return [
        _rounded(direction.scaled(fraction * period * largest_speed(robot, gait, direction).scale))
        for direction in DIRECTIONS
        for fraction in FRACTIONS
    ]


def vector(motion: BodyMotion) -> Array:
    """Return forward and left [m] and turn [rad] of a motion, shape (3,)."""
    return np.array([motion.forward, motion.left, motion.turn])


def _rounded(motion: BodyMotion) -> BodyMotion:
    return BodyMotion(*(round(part, 4) for part in vector(motion).tolist()))


def motion_size(motion: BodyMotion) -> float:
    """Return how large a motion is; 1 rad counts as 0.2 m [m]."""
    return math.hypot(motion.forward, motion.left, 0.2 * motion.turn)


def motion_error(measured: MeasuredMotion, wanted: BodyMotion) -> float:
    """Return how far a measured motion is from the one that is wanted [m]."""
    mean = measured.mean
    return math.hypot(
        mean.forward - wanted.forward, mean.left - wanted.left, 0.2 * (mean.turn - wanted.turn)
    )
