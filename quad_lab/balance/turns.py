"""
Turns on the spot, as fast as limits allow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from quad_common.planar_pose import Twist2D
from quad_gait.cycle.body_motion import BodyMotion
from quad_lab.balance.balance_case import BalanceCase, BalanceWalk

_GATHERING = 2.0
"""Time in which a robot gathers its rate [s]."""


@dataclass(frozen=True)
class SteadyTurn:
    """A turn on the spot that nothing disturbed."""

    case: BalanceCase
    """Who."""
    asked: float
    """Rate that was asked for, counter-clockwise [rad/s]."""
    rate: float
    """Rate of the body [rad/s]."""
    shift: float
    """Distance by which it left its place [m]."""
    tilt_rms: float
    """Root mean square of the body's tilt [rad]."""
    has_fallen: bool
    """Whether it fell, or stopped."""

    @property
    def error(self) -> float:
        """Error of the rate as a fraction of what was asked for."""
        return self.rate / self.asked - 1.0


def steady_turn(case: BalanceCase, side: int, duration: float, seed: int = 0) -> SteadyTurn:
    """
    Turn on the spot for a time [s], after the robot has gathered its rate.

    Parameters
    ----------
    case : BalanceCase
        Who, in place.
    side : int
        1 to the left, -1 to the right.
    duration : float
        [s]
    seed : int
        Seed of the sensors' errors.

    Returns
    -------
    SteadyTurn
    """
    walk = BalanceWalk(case, seed)
    loop, record = walk.loop, walk.loop.record
    try:
        gear = loop.controller.gait_pair.of_twist(Twist2D(turn=float(side)))
        asked = side * gear.largest_scale(BodyMotion(turn=float(side))) / gear.period
        loop.controller.set_twist(Twist2D(turn=asked))
        loop.run(_GATHERING)
        first = len(record.times)
        loop.run(duration, until=lambda: record.has_fallen)
        poses = record.poses[first:]
        turned = np.unwrap([pose.yaw for pose in poses])
        return SteadyTurn(
            case,
            asked,
            float(turned[-1] - turned[0]) / (record.times[-1] - record.times[first]),
            poses[0].distance_to(poses[-1]),
            float(np.sqrt(np.mean(np.square(record.tilts[first:])))),
            walk.is_lost,
        )
    finally:
        walk.close()
