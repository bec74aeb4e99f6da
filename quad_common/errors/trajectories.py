"""
Errors of joint trajectories and commands.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors.base import QuadError

_LONGEST_DELAY = 10.0
"""Time by which a busy machine may delay a trajectory; more is another clock [s]."""


class TrajectoryError(QuadError):
    """A joint trajectory is malformed or comes too late."""


@dataclass(eq=False, repr=False)
class EmptyTrajectory(TrajectoryError):
    """A trajectory has no points, or no joints."""

    points: int
    """Number of points."""
    joints: int
    """Number of joints."""

    def sentence(self) -> str:
        """Say what it needs."""
        return (
            f'the trajectory has {self.points} points for {self.joints} joints; '
            'it needs at least one'
        )


@dataclass(eq=False, repr=False)
class JointRepeated(TrajectoryError):
    """A trajectory names a joint twice."""

    joint: str
    """Name of the first such joint."""

    def sentence(self) -> str:
        """Say what is wrong."""
        return 'the trajectory names a joint twice'


@dataclass(eq=False, repr=False)
class TrajectoryShapeWrong(TrajectoryError):
    """Positions or velocities of a trajectory are not those of its points and joints."""

    what: str
    """Name of the numbers: ``positions`` or ``velocities``."""
    shape: tuple[int, ...]
    """Shape that they have."""
    expected: tuple[int, int]
    """Number of points and number of joints."""

    def sentence(self) -> str:
        """Say which shape is needed."""
        points, joints = self.expected
        return (
            f'the trajectory has {self.what} of shape {self.shape}; '
            f'{points} points of {joints} joints need {self.expected}'
        )


@dataclass(eq=False, repr=False)
class TrajectoryNotFinite(TrajectoryError):
    """A trajectory holds numbers that are not finite."""

    what: str
    """Name of the numbers: ``positions``, ``velocities`` or ``times``."""

    def sentence(self) -> str:
        """Say which numbers are not finite."""
        return f'the trajectory has {self.what} that are not finite'


@dataclass(eq=False, repr=False)
class TimesDoNotRise(TrajectoryError):
    """The times of a trajectory's points do not rise from zero or later."""

    def sentence(self) -> str:
        """Say how times must be."""
        return 'the times of a trajectory must rise, from zero or later'


@dataclass(eq=False, repr=False)
class JointsLeftOut(TrajectoryError):
    """A trajectory does not move every joint."""

    missing: tuple[str, ...]
    """Names of the joints that it leaves out."""

    def sentence(self) -> str:
        """Say which joints are missing."""
        return f'the trajectory leaves out {", ".join(self.missing)}'


@dataclass(eq=False, repr=False)
class TrajectoryOver(TrajectoryError):
    """A trajectory has ended already."""

    end: float
    """Time of its last point [s]."""
    now: float
    """Time at which it came [s]."""

    @property
    def is_delayed(self) -> bool:
        """Whether a machine that is slow explains it, and not a clock that is another."""
        return self.now - self.end < _LONGEST_DELAY

    def sentence(self) -> str:
        """Say since when it is over."""
        return f'the trajectory ended at {self.end:.3f} s, {self.now - self.end:.3f} s ago'


@dataclass(eq=False, repr=False)
class NoJointsNamed(TrajectoryError):
    """A trajectory that was received names no joints."""

    def sentence(self) -> str:
        """Say what it needs."""
        return 'the trajectory names no joints; it needs at least one'


@dataclass(eq=False, repr=False)
class TooManyJoints(TrajectoryError):
    """A trajectory that was received names more joints than are accepted."""

    count: int
    """Number of joints."""
    most: int
    """Largest number that is accepted."""

    def sentence(self) -> str:
        """Say how many are accepted."""
        return f'the trajectory names {self.count} joints; {self.most} are the most'


@dataclass(eq=False, repr=False)
class TooManyPoints(TrajectoryError):
    """A trajectory that was received has more points than are accepted."""

    count: int
    """Number of points."""
    most: int
    """Largest number that is accepted."""

    def sentence(self) -> str:
        """Say how many are accepted."""
        return f'the trajectory has {self.count} points; {self.most} are the most'


@dataclass(eq=False, repr=False)
class PointMalformed(TrajectoryError):
    """A point of a trajectory has not one number for each joint."""

    index: int
    """Index of the point."""
    positions: int
    """Number of its positions."""
    velocities: int
    """Number of its velocities."""
    joints: int
    """Number of joints."""

    def sentence(self) -> str:
        """Say how many numbers the point has."""
        return (
            f'point {self.index} has {self.positions} positions and {self.velocities} velocities '
            f'for {self.joints} joints'
        )


@dataclass(eq=False, repr=False)
class CommandOutsideLimits(TrajectoryError):
    """A command asks for what a joint cannot do."""

    joint: str
    """Name of the joint."""
    quantity: str
    """Quantity that is outside its range: ``position`` or ``velocity``."""
    value: float
    """Value that it would have."""
    limits: tuple[float, float]
    """Least and largest value."""
    unit: str
    """Unit of value and limits."""

    def sentence(self) -> str:
        """Say what the joint's limits are."""
        low, high = self.limits
        return (
            f'joint {self.joint} would be commanded a {self.quantity} of {self.value:.4g} '
            f'{self.unit}; its limits are {low:.4g} to {high:.4g} {self.unit}'
        )


@dataclass(eq=False, repr=False)
class CommandJumps(TrajectoryError):
    """A trajectory would make a command jump."""

    joint: str
    """Name of the joint."""
    step: float
    """Angle by which it would jump [rad]."""
    period: float
    """Time in which it would have to get there [s]."""

    def sentence(self) -> str:
        """Say how far the command would jump."""
        return (
            f'the command of joint {self.joint} would jump by {self.step:.3f} rad, '
            f'farther than it turns in {self.period:g} s'
        )


@dataclass(eq=False, repr=False)
class EmergencyStopped(TrajectoryError):
    """The emergency stop is on: no trajectory is executed."""

    def sentence(self) -> str:
        """Say why the trajectory is not executed."""
        return 'the trajectory is not executed: the emergency stop is on'
