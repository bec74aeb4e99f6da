"""
Errors of simulators.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from quad_common.errors.base import QuadError, listed
from quad_common.errors.quoting import quoted


class SimulatorError(QuadError):
    """The simulator cannot do what it was asked to."""


@dataclass(eq=False, repr=False)
class NotSimulated(SimulatorError):
    """The simulator's backend lacks what is requested."""

    what: str
    """Capability that is requested, with its article."""
    backends: tuple[str, ...]
    """Backends that have it."""

    def sentence(self) -> str:
        """Say which backends have it."""
        names = ' or '.join(repr(backend) for backend in self.backends)
        return f"this simulator does not support {self.what}; set 'backend' to {names}"


@dataclass(eq=False, repr=False)
class RobotNotLoaded(SimulatorError):
    """A physics engine refuses a robot's own URDF."""

    robot: str
    """Name of the robot."""
    engine: str
    """Name of the engine."""
    reason: str
    """What the engine says."""

    def sentence(self) -> str:
        """Say which engine refuses it, and why."""
        reason = ' '.join(self.reason.split())
        return f'{self.engine} cannot load the URDF of {quoted(self.robot)}: {quoted(reason)}'


@dataclass(eq=False, repr=False)
class ObstacleOnRobot(SimulatorError):
    """An obstacle would stand where the robot is."""

    name: str
    """Name of the obstacle."""
    distance: float
    """Distance from base_link to the obstacle [m]."""
    required: float
    """Distance that the robot needs [m]."""

    def sentence(self) -> str:
        """Say how far away the obstacle must be."""
        return (
            f'obstacle {self.name} would stand {self.distance:.2f} m from the middle of the robot; '
            f'it must be at least {self.required:.2f} m away'
        )


@dataclass(eq=False, repr=False)
class TooManyObstacles(SimulatorError):
    """More obstacles would stand in the world than it may hold."""

    count: int
    """Number that there would be."""
    most: int
    """Number that there may be."""

    def sentence(self) -> str:
        """Say how many there may be."""
        return f'there would be {self.count} obstacles; {self.most} are the most'


@dataclass(eq=False, repr=False)
class JointNotFound(SimulatorError):
    """A joint of that name does not exist."""

    name: str
    """Name that was given."""
    available: Iterable[str]
    """Names of the joints."""

    def sentence(self) -> str:
        """Say which joints there are."""
        return f'there is no joint {quoted(self.name)}; available: {listed(self.available)}'


@dataclass(eq=False, repr=False)
class RobotNameTaken(SimulatorError):
    """A robot of that name is in the world already."""

    name: str
    """Name that was given."""

    def sentence(self) -> str:
        """Say which name."""
        return f'there is a robot {quoted(self.name)} in the world already'


@dataclass(eq=False, repr=False)
class RobotNotFound(SimulatorError):
    """A robot of that name is not in the world."""

    name: str
    """Name that was given."""
    available: Iterable[str]
    """Names of the robots."""

    def sentence(self) -> str:
        """Say which robots there are."""
        return f'there is no robot {quoted(self.name)}; there are: {listed(self.available)}'


@dataclass(eq=False, repr=False)
class TooManyRobots(SimulatorError):
    """More robots would be in the world than may be."""

    most: int
    """Number that there may be."""

    def sentence(self) -> str:
        """Say how many there may be."""
        return f'{self.most} robots are the most in one world'


@dataclass(eq=False, repr=False)
class PlaceTaken(SimulatorError):
    """A robot would stand where another one is, or too near."""

    name: str
    """Name of the robot that would come."""
    other: str
    """Name of the one that stands there."""
    distance: float
    """Distance between the two [m]."""
    needed: float
    """Least distance [m]."""

    def sentence(self) -> str:
        """Say how near they would be."""
        return (
            f'{quoted(self.name)} would stand {self.distance:.2f} m from {quoted(self.other)}; '
            f'the two need {self.needed:.2f} m'
        )


@dataclass(eq=False, repr=False)
class NoDisplay(SimulatorError):
    """A window is wanted, and there is no screen to show it on."""

    reason: str
    """What the window system says."""

    def sentence(self) -> str:
        """Say what was tried."""
        return f'there is no screen for a window ({self.reason}); run it without gui'


@dataclass(eq=False, repr=False)
class NoRenderer(SimulatorError):
    """Nothing is there that draws pictures without a screen."""

    reason: str
    """What was tried, and why it failed."""

    def sentence(self) -> str:
        """Say what to install."""
        return (
            'pictures of this backend need EGL or OSMesa, and neither works here; install libegl1 '
            f'and libgl1-mesa-dri (Debian, Ubuntu), or take another backend ({self.reason})'
        )


@dataclass(eq=False, repr=False)
class MissingOptionalDependency(SimulatorError):
    """A capability needs a package that is not installed."""

    package: str
    """Name of the package."""
    command: str
    """Command that installs it."""

    def sentence(self) -> str:
        """Say how to install the package."""
        return f"this needs the package '{self.package}'; install it with: {self.command}"
