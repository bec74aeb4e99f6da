"""
What a follower decides on, a step, and what it needs to know of a gait for that.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_gait.cycle.body_motion import BodyMotion

AT_ONCE = 0.3
"""Fraction of a stride that a robot which comes to rest may walk more in its last cycle."""


class Gear(Protocol):
    """What a follower needs to know of a gait on a robot."""

    @property
    def period(self) -> float:
        """Duration of a cycle [s]."""

    @property
    def is_steady(self) -> bool:
        """Whether the body may keep its speed from cycle to cycle."""

    @property
    def acceleration_fraction(self) -> float:
        """Fraction of a cycle's length at speed in which it gathers that speed."""

    def possible_part(self, motion: BodyMotion) -> float:
        """Return which part of a motion fits into a step, at most 1."""

    def largest_scale(self, motion: BodyMotion) -> float:
        """Return how many times a motion fits into one cycle."""

    def reason(self, motion: BodyMotion) -> str:
        """Say what forbids more of a motion."""


@dataclass(frozen=True)
class LongGear:
    """
    Several cycles of a gait as one, for a robot that decides within them too.

    It gathers and loses its speed over all of them.
    """

    gear: Gear
    """Gear of one cycle."""
    cycles: int
    """Number of cycles."""

    @property
    def period(self) -> float:
        """Duration of all cycles [s]."""
        return self.cycles * self.gear.period

    @property
    def is_steady(self) -> bool:
        """Whether the body may keep its speed."""
        return self.gear.is_steady

    @property
    def acceleration_fraction(self) -> float:
        """Fraction of their length at speed in which it gathers that speed: evenly."""
        return 0.5

    def largest_scale(self, motion: BodyMotion) -> float:
        """Return how many times a motion fits into all cycles."""
        return self.cycles * self.gear.largest_scale(motion)

    def possible_part(self, motion: BodyMotion) -> float:
        """Return which part of a motion fits into all cycles, at most 1."""
        return self.gear.possible_part(motion.scaled(1.0 / self.cycles))

    def reason(self, motion: BodyMotion) -> str:
        """Say what forbids more of a motion."""
        return self.gear.reason(motion)


@dataclass(frozen=True)
class Departure:
    """Where a step begins, and how."""

    pose: Pose2D
    """Pose of the robot then, in the plan's frame."""
    odometry: Pose2D
    """The same by odometry alone."""
    entry: Twist2D = STILL
    """Velocity with which the step begins."""
    gear: Gear | None = None
    """Gait of the cycle before; None at rest."""


@dataclass(frozen=True)
class Step:
    """What the next cycle is to do."""

    is_turn: bool
    """Whether it is a turn on the spot."""
    motion: BodyMotion
    """Motion of the body in the cycle."""
    exit: Twist2D = STILL
    """Velocity at which the cycle should end."""


def advance(remaining: float, entry: float, largest: float, gear: Gear) -> tuple[float, float]:
    """
    Divide what is left before a stop into cycles.

    Parameters
    ----------
    remaining : float
        Length or angle, 0 or more.
    entry : float
        Speed at the start of the cycle, per cycle.
    largest : float
        Most that one cycle does.
    gear : Gear
        What cycles it has.

    Returns
    -------
    tuple of float
        What the next cycle does, and the speed at its end, per cycle.
    """
    if not gear.is_steady:
        return remaining / max(1, math.ceil(remaining / largest - 1e-9)), 0.0
    part = gear.acceleration_fraction
    if remaining <= (1.0 - part) * entry + AT_ONCE * largest:
        return remaining, 0.0
    # In two cycles: from the entry to a speed, and from that to rest.
    exit_speed = min(remaining - (1.0 - part) * entry, largest)
    return (1.0 - part) * entry + part * exit_speed, exit_speed
