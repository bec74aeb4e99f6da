"""
What somebody may want of the robot, each wish a value.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Twist2D
from quad_gait.cycle.gait import Gait
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.reference_path import Piece


@dataclass(frozen=True)
class FollowPlan:
    """Follow a plan from the next cycle on, or none."""

    plan: Plan | None
    """Turning points; None takes back the plan that was wanted."""
    pieces: list[Piece] | None = None
    """Path to the plan's last pose, if it is not made of its turning points."""
    is_asked: bool = False
    """Whether somebody asks for it just now; else it is none after a stop on the same path."""


@dataclass(frozen=True)
class HoldPlan:
    """Let the plan wait from the next cycle on."""

    reason: str
    """Reason for which it waits, as a sentence; empty to go on with it."""


@dataclass(frozen=True)
class Steer:
    """Walk with a velocity until it times out."""

    twist: Twist2D
    """Velocity in the body's axes."""


@dataclass(frozen=True)
class Stop:
    """Stop at the end of the cycle, until a plan to another goal or steering comes."""

    answer: ClassVar[str] = 'the robot stops at the end of its gait cycle, on four feet'


@dataclass(frozen=True)
class Stand:
    """Stop and regain the initial posture, also after sitting, a fall or an emergency stop."""

    answer: ClassVar[str] = (
        'the robot stops at the end of its gait cycle and stands in its initial posture'
    )


@dataclass(frozen=True)
class Sit:
    """Stop and lower the body, until :class:`Stand`."""

    answer: ClassVar[str] = (
        'the robot stops at the end of its gait cycle and sits down, until stand is called'
    )


@dataclass(frozen=True)
class Freeze:
    """Stop all joints at once: the emergency stop."""


@dataclass(frozen=True)
class Release:
    """End the emergency stop; the robot stays as it is until :class:`Stand`."""


@dataclass(frozen=True)
class ChangeGaits:
    """Use other gaits, and follow plans otherwise, once the robot is at rest."""

    gait: Gait
    """Gait for walking; fitted to the robot."""
    turning_gait: Gait
    """Gait for turning on the spot; may be the same."""
    follower: FollowerOptions
    """Options for following plans."""


@dataclass(frozen=True)
class UseHeightMap:
    """Walk by a map of the ground, in the plan's frame."""

    height_map: HeightMap | None
    """Heights; None: feet feel for the ground."""


Wish = (
    FollowPlan
    | HoldPlan
    | Steer
    | Stop
    | Stand
    | Sit
    | Freeze
    | Release
    | ChangeGaits
    | UseHeightMap
)
"""Any of them."""
