"""
What a person at the page may ask for; each is sent as anybody's message or request.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.planar_pose import Pose2D, Twist2D

OPTIONS = {'gait_node': ('gait', 'turning'), 'planner_node': ('method',)}
"""Parameters that can be chosen at the page, by nodes."""


@dataclass(frozen=True)
class Command:
    """A wish for one robot."""

    robot: str
    """Namespace of the robot; empty for none."""


@dataclass(frozen=True)
class GiveGoal(Command):
    """Walk to a pose on the map."""

    goal: Pose2D
    """Pose of base_link."""


@dataclass(frozen=True)
class Steer(Command):
    """Walk with a velocity for a moment."""

    twist: Twist2D
    """Velocity along the body's own axes."""
    duration: float
    """Time for which it counts [s]."""


@dataclass(frozen=True)
class Request(Command):
    """Call a service without arguments."""

    service: str
    """``stand``, ``sit``, ``stop``, ``reset``, ``pause`` or ``unpause``."""


@dataclass(frozen=True)
class EmergencyStop(Command):
    """Freeze all joints, or release them."""

    is_on: bool
    """Whether to freeze."""


@dataclass(frozen=True)
class SetOption(Command):
    """Set a text parameter of a node."""

    node: str
    """Name of the node."""
    name: str
    """Name of the parameter."""
    value: str
    """Value that it gets."""


@dataclass(frozen=True)
class PutObstacle(Command):
    """Put a box on the floor of the simulation."""

    place: Pose2D
    """Pose of its middle on the map."""
    size: tuple[float, float, float]
    """Length, width and height [m]."""


@dataclass(frozen=True)
class ClearObstacles(Command):
    """Take all obstacles away."""


@dataclass(frozen=True)
class ShowPicture(Command):
    """Show the camera's picture, or show it no more."""

    is_shown: bool
    """Whether it is shown."""
