"""
Errors of robots' data files.
"""

from __future__ import annotations

from dataclasses import dataclass
from os import PathLike

from quad_common.errors.base import QuadError
from quad_common.errors.files import FileEntryInvalid, FileUnusable
from quad_common.errors.parameters import OutOfRange, ParameterError
from quad_common.errors.quoting import quoted, shown


class RobotModelError(QuadError):
    """A robot's data file is missing, incomplete or contradicts itself."""


class RobotValueOutOfRange(RobotModelError, OutOfRange):
    """A quantity of a robot's data file is no number of its range."""


class RobotValueInvalid(RobotModelError, ParameterError):
    """An entry of a robot's data file is not of its kind."""


class RobotFileUnusable(RobotModelError, FileUnusable):
    """A robot's data file cannot be read."""


class RobotEntryInvalid(RobotModelError, FileEntryInvalid):
    """An entry of a robot's data file means nothing."""


@dataclass(eq=False, repr=False)
class RobotUnknown(RobotModelError):
    """There is no robot of that name, and no such file."""

    robot: str
    """Name that was given."""
    available: tuple[str, ...]
    """Names of the robots that ship."""

    def sentence(self) -> str:
        """Say which robots there are."""
        return (
            f'there is no robot {quoted(self.robot)}; available: {", ".join(self.available)}, '
            'or the path of a robot data file or a description (URDF, xacro, MJCF)'
        )


@dataclass(eq=False, repr=False)
class RobotFileMissing(RobotUnknown):
    """There is no such file, by a name that can be nothing else."""

    package: str = ''
    """ROS package that the file is to be in; empty if none is named."""
    is_installed: bool = False
    """Whether that package was found."""

    def sentence(self) -> str:
        """Say what is missing, and what a robot may be."""
        if self.package and not self.is_installed:
            return (
                f'there is no robot {quoted(self.robot)}: the package {quoted(self.package)} is '
                f"neither in AMENT_PREFIX_PATH nor in ROS_PACKAGE_PATH; source its workspace's "
                f'setup.bash first'
            )
        where = f' in the package {quoted(self.package)}' if self.package else ''
        return (
            f'there is no robot {quoted(self.robot)}: no such file{where}; it may be a robot data '
            f'file (.yaml), a description (.urdf, .xacro, .xml), or one of the names '
            f'{", ".join(self.available)}'
        )


@dataclass(eq=False, repr=False)
class RobotFileError(RobotModelError):
    """Base of what is wrong with a robot's data file."""

    path: str | PathLike[str]
    """Path of the data file."""


@dataclass(eq=False, repr=False)
class LegTypeUnknown(RobotFileError):
    """There is no such build of legs."""

    leg_type: object
    """Build that was given."""
    available: tuple[str, ...]
    """Builds that there are."""

    def sentence(self) -> str:
        """Say which builds there are."""
        available = ', '.join(f"'{name}'" for name in self.available)
        return f'{self.path}: leg_type is {shown(self.leg_type)}; available: {available}'


@dataclass(eq=False, repr=False)
class RobotNameInvalid(RobotFileError):
    """The name of a robot is no short text."""

    name: object
    """Name that was given."""
    longest: int
    """Number of characters of the longest name."""

    def sentence(self) -> str:
        """Say what a name is."""
        return (
            f'{self.path}: the name is {shown(self.name)}; '
            f'it must be a text of up to {self.longest} printable characters'
        )


@dataclass(eq=False, repr=False)
class RobotNumberMissing(RobotFileError):
    """A robot's data file lacks a number."""

    name: str
    """Dotted name of the number."""

    def sentence(self) -> str:
        """Say which number is missing."""
        return f"{self.path} has no number '{self.name}'"


@dataclass(eq=False, repr=False)
class RobotNumberWithoutSource(RobotFileError):
    """A number of a robot's data file does not say where it comes from."""

    name: str
    """Dotted name of the number."""

    def sentence(self) -> str:
        """Say how numbers are given."""
        return f"{self.path}: '{self.name}' must be given as {{value: ..., source: ...}}"


@dataclass(eq=False, repr=False)
class JointRangeEmpty(RobotFileError):
    """The lower limit of a joint is not below its upper one."""

    joint: str
    """Kind of the joint."""
    lower: float
    """Lower limit [rad]."""
    upper: float
    """Upper limit [rad]."""

    def sentence(self) -> str:
        """Say which limits are in the wrong order."""
        return (
            f'{self.path}: joint {self.joint} has lower {self.lower} not below upper {self.upper}'
        )


@dataclass(eq=False, repr=False)
class LinkTooThick(RobotFileError):
    """The radius of a link is more than any leg of its length has."""

    name: str
    """Dotted name of the radius."""
    radius: float
    """Radius that was given [m]."""
    length: float
    """Length of the straight legs, thigh and calf [m]."""
    most: float
    """Largest radius of a link of such legs [m]."""

    def sentence(self) -> str:
        """Say how thick links may be."""
        return (
            f'{self.path}: {self.name} is {self.radius:.3g} m; links of legs that are '
            f'{self.length:.3g} m long (thigh and calf) may have a radius of {self.most:.3g} m at '
            'most'
        )


@dataclass(eq=False, repr=False)
class AxisNotAUnitVector(RobotFileError):
    """An axis of a leg is not of length 1."""

    name: str
    """Dotted name of the axis."""
    axis: tuple[float, ...]
    """Vector that was given."""

    def sentence(self) -> str:
        """Say what an axis is."""
        return f'{self.path}: {self.name} is {list(self.axis)}; it must have the length 1'


@dataclass(eq=False, repr=False)
class InitialPostureOutOfRange(RobotFileError):
    """The initial posture of a robot is beyond a joint's range."""

    problem: QuadError
    """Error of the joint."""

    def sentence(self) -> str:
        """Say which joint is out of its range."""
        return f'{self.path}: the initial posture is out of range: {self.problem}'


@dataclass(eq=False, repr=False)
class CenterOfMassBelowGround(RobotFileError):
    """The center of mass of a robot that stands is below its feet."""

    height: float
    """Height of the center of mass over the ground [m]."""

    def sentence(self) -> str:
        """Say how high the center of mass is."""
        return (
            f'{self.path}: the center of mass in the initial posture is {self.height:.3g} m over '
            'the ground on which the feet stand; it must be above it'
        )


@dataclass(eq=False, repr=False)
class InitialPostureSingular(RobotFileError):
    """A leg of a robot cannot move its foot in every direction in the initial posture."""

    name: str
    """Dotted name of the posture."""
    problem: QuadError
    """Error of the leg."""

    def sentence(self) -> str:
        """Say which posture it is, and of which leg."""
        return f'{self.path}: {self.name} is singular: {self.problem}'


@dataclass(eq=False, repr=False)
class LegTooShort(RobotModelError):
    """A leg does not reach down or out as far as its posture needs."""

    leg: str
    """Name of the leg."""
    length: float
    """Length of the straight leg [m]."""
    distance: float
    """Distance that it must reach [m]."""
    direction: str
    """Direction of that distance, for example ``down``."""

    def sentence(self) -> str:
        """Say how far the leg reaches."""
        return (
            f'leg {self.leg} is {self.length:.3f} m long and cannot reach {self.distance:.3f} m '
            f'{self.direction}; lower the body or the roughness'
        )


@dataclass(eq=False, repr=False)
class StretchTooShort(RobotModelError):
    """The largest stretch of the legs is less than the initial posture needs."""

    stretch: float
    """Largest stretch [m]."""
    needed: float
    """Distance from yaw axis to foot in the initial posture [m]."""

    def sentence(self) -> str:
        """Say how far the legs must stretch."""
        return (
            f'the largest stretch {self.stretch:.3f} m is less than the initial posture needs, '
            f'{self.needed:.3f} m'
        )
