"""
Steady trots, and what becomes of a robot that hears nothing more.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from functools import partial

import numpy as np

from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.state.robot_state import RobotState
from quad_lab.balance.balance_case import BalanceCase, BalanceWalk
from quad_lab.balance.pushes import apart

_TO_REST = 3.0
"""Time in which a robot that receives nothing more comes to rest [s]."""

_BEARS = 0.02
"""Fraction of the weight from which on a foot bears."""


@dataclass(frozen=True)
class SteadyTrot:
    """A trot that nothing disturbed."""

    case: BalanceCase
    """Who, and how fast."""
    asked: float
    """Velocity that was asked for [m/s]."""
    speed: float
    """Velocity of the body [m/s]."""
    drift: float
    """Distance sideways of the heading in which it stood, per distance walked; 0 in place."""
    odometry_error: float
    """Distance by which it is elsewhere than its legs tell, per distance walked; 0 in place."""
    tilt_rms: float
    """Root mean square of the body's tilt [rad]."""
    update_time: float
    """Processor time of a decision, median [s]."""
    longest_update: float
    """The same, 99 of 100 [s]."""
    has_fallen: bool
    """Whether it fell, or stopped."""

    @property
    def error(self) -> float:
        """Error of the velocity as a fraction of what was asked for; nan in place."""
        return self.speed / self.asked - 1.0 if self.asked else math.nan


def steady_trot(case: BalanceCase, duration: float, seed: int = 0) -> SteadyTrot:
    """
    Trot straight on for a time [s], after the robot has gathered its speed.

    Parameters
    ----------
    case : BalanceCase
        Who, and how fast.
    duration : float
        [s]
    seed : int
        Seed of the sensors' errors.

    Returns
    -------
    SteadyTrot
    """
    walk = BalanceWalk(case, seed)
    loop, times = walk.loop, []
    decide = loop.controller.update

    def timed(state: RobotState) -> JointTrajectory | None:
        began = time.process_time()
        trajectory = decide(state)
        times.append(time.process_time() - began)
        return trajectory

    try:
        loop.controller.update = timed  # type: ignore[method-assign]
        first = len(loop.record.times)
        begin, begin_by_legs = loop.record.poses[-1], loop.pose_by_legs
        loop.run(duration, until=lambda: loop.record.has_fallen)
        poses = loop.record.poses[first:]
        way = begin.inverse() @ poses[-1]
        error = way.distance_to(begin_by_legs.inverse() @ loop.pose_by_legs)
        elapsed = loop.record.times[-1] - loop.record.times[first]
        distance = poses[0].distance_to(poses[-1])
        return SteadyTrot(
            case,
            walk.speed,
            distance / elapsed if elapsed else math.nan,
            abs(poses[-1].y - poses[0].y) / distance if walk.speed else 0.0,
            error / distance if walk.speed else 0.0,
            float(np.sqrt(np.mean(np.square(loop.record.tilts[first:])))),
            float(np.median(times)),
            float(np.percentile(times, 99.0)),
            walk.is_lost,
        )
    finally:
        walk.close()


def silences(case: BalanceCase, count: int, seed: int = 0) -> int:
    """
    Let a robot receive nothing more, at random instants, and count how often it then stands.

    Parameters
    ----------
    case : BalanceCase
        Who, and how fast.
    count : int
        Number of instants.
    seed : int
        Seed of the instants.

    Returns
    -------
    int
        How often it stood on four feet in the end, and had not fallen.
    """
    walk = BalanceWalk(case, seed)
    instants = np.random.default_rng(seed).uniform(0.0, 2.0 * walk.period, count)
    try:
        return sum(apart(partial(_comes_to_stand, walk, after)) for after in instants)
    finally:
        walk.close()


def _comes_to_stand(walk: BalanceWalk, after: float) -> bool:
    loop = walk.loop
    loop.run(after)
    loop.is_deaf = True
    loop.run(_TO_REST)
    weight = walk.robot.mass * 9.81
    bears = loop.simulation.foot_forces() > _BEARS * weight
    return not loop.record.has_fallen and bool(bears.all())
