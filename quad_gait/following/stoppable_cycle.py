"""
A cycle that can be brought to rest, and the cycle that does it.

A body that keeps its speed must not be given a cycle from which it could not come to rest: with
each cycle the one that would follow it as a stop is planned too.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle, CycleEnds
from quad_gait.cycle.foot_tracking import track_feet
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.gait_generator import CycleOptions, generate_cycle, generate_largest_cycle

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StoppableCycle:
    """A cycle, and what would follow if nothing more came."""

    cycle: Cycle
    """Cycle that was wanted, or as much of it as is possible."""
    stop: Cycle | None
    """Cycle that brings the body to rest after it; None if it is at rest anyway."""


@dataclass(frozen=True)
class CycleRules:
    """How cycles are computed that begin at any joint angles, and what they must keep."""

    sample_period: float
    """Longest time between samples [s]."""
    least_margin: float
    """Stability margin below which a cycle is refused [m]."""
    tracking_gain: float | None
    """Gain of S1's backstepping law [1/s]; None for closed-form inverse kinematics."""

    def starting_at(self, joints: Array) -> CycleOptions:
        """Return the options of a cycle that begins at joint angles, shape (4, 3) [rad]."""
        gain = self.tracking_gain
        if gain is None:
            return CycleOptions(self.sample_period, self.least_margin)
        return CycleOptions(
            self.sample_period,
            self.least_margin,
            lambda robot, times, feet, velocities: track_feet(
                robot, times, feet, velocities, joints, gain
            ),
        )


def generate_stoppable_cycle(
    robot: Robot, gait: Gait, motion: BodyMotion, ends: CycleEnds, rules: CycleRules, joints: Array
) -> StoppableCycle:
    """
    Plan a cycle, shortening its motion as far as legs and margin require, and the stop after it.

    Parameters
    ----------
    robot, gait, motion, ends
        As for :func:`generate_largest_cycle`.
    rules : CycleRules
        Samples, least margin, and how foot paths become joint motion; of both cycles.
    joints : ndarray, shape (4, 3)
        Joint angles at the start [rad].

    Returns
    -------
    StoppableCycle

    Raises
    ------
    GaitError
        If no part of the motion is possible, or the body could not come to rest after any.
    """
    stop: Cycle | None = None

    def find_stop(cycle: Cycle) -> None:
        nonlocal stop
        stop = _stop_after(robot, cycle, rules)

    options = rules.starting_at(joints)
    cycle = generate_largest_cycle(robot, gait, motion, ends, options, accept=find_stop)
    return StoppableCycle(cycle, stop)


def _stop_after(robot: Robot, cycle: Cycle, rules: CycleRules) -> Cycle | None:
    """Plan the cycle that brings the body to rest; None if it is at rest anyway."""
    if not cycle.exit:
        return None
    return generate_cycle(
        robot,
        cycle.gait,
        BodyMotion.during(cycle.exit, (1.0 - cycle.gait.acceleration_fraction) * cycle.period),
        CycleEnds(cycle.end_feet, entry=cycle.exit),
        rules.starting_at(cycle.joint_positions[-1]),
    )
