"""
Feet at a knot, beside the level body, and what is to be done with them until the next.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from quad_gait.balance.foot_laws import Pace, tilted_back
from quad_gait.balance.ground_slope import LEVEL, Slope


class Foot(NamedTuple):
    """A foot at a knot, beside the level body."""

    x: float
    """Place of its center along x [m]."""
    y: float
    """The same along y [m]."""
    z: float
    """The same along z [m]."""
    vx: float = 0.0
    """Velocity along x while it swings [m/s]."""
    vy: float = 0.0
    """The same along y [m/s]."""
    rise: float = 0.0
    """Height above the plane of the ground of what it stands on, or left [m]."""
    roll: float = 0.0
    """Roll of the body that the leg makes up for [rad]."""
    pitch: float = 0.0
    """Pitch of the body that the leg makes up for [rad]."""
    swings: bool = False
    """Whether it swings."""
    target: tuple[float, float] = (0.0, 0.0)
    """Place where it lands, or has landed [m]."""
    lift: float = 0.0
    """Height to which it is lifted in this swing, or was in the last one [m]."""
    has_landed: bool = False
    """Whether it met the ground before its time, and stands since."""

    @property
    def in_body(self) -> tuple[float, float, float]:
        """Place in the body's axes [m]."""
        return tilted_back(self.x, self.y, self.z, self.roll, self.pitch)


class FootPlan(NamedTuple):
    """The feet at a knot, and how fast the body is to be."""

    feet: tuple[Foot, ...]
    """Feet in the order of ``LEGS``."""
    pace: Pace
    """Velocity that is planned by now."""
    slope: Slope = LEVEL
    """The ground on which they are planned."""


@dataclass(frozen=True)
class Demand:
    """What is to be done from one knot to the next."""

    pace: Pace
    """Velocity that is wanted."""
    measured: Pace
    """Velocity of the body."""
    roll: float = 0.0
    """Roll of the body, over that which it is to have [rad]."""
    pitch: float = 0.0
    """Pitch of the body, over that which it is to have [rad]."""
    slope: Slope = LEVEL
    """The ground."""
    trim: tuple[float, float] = (0.0, 0.0)
    """Velocity by which less is asked for than is wanted [m/s]."""
    roughness: float = 0.0
    """Height by which feet that stood were off the plane of the ground lately [m]."""
