"""
Which feet bear load, as fractions of a robot's weight.
"""

from __future__ import annotations

from quad_common.robot.leg_moments import GRAVITY
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.state.stance import Stance
from quad_gait.uneven.uneven_options import UnevenOptions

_LITTLE = 0.2
"""Fraction of the load that counts as contact, below which a foot bears next to nothing."""


def load_fraction(robot: Robot, now: Stance, leg: int) -> float:
    """Return what a foot bears, as a fraction of the robot's weight; 0 where motors do not tell."""
    if now.loads is None:
        return 0.0
    return float(now.loads[leg]) / (robot.mass * GRAVITY)


def unloaded_legs(robot: Robot, now: Stance, options: UnevenOptions) -> list[int]:
    """Return the legs whose feet bear next to nothing; none where motors do not tell."""
    if now.loads is None:
        return []
    little = _LITTLE * options.contact_fraction * robot.mass * GRAVITY
    return [leg for leg in range(len(LEGS)) if now.loads[leg] < little]
