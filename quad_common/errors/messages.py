"""
Errors of what is received: messages and transforms.
"""

from __future__ import annotations

from dataclasses import dataclass

from quad_common.errors.base import QuadError
from quad_common.errors.quoting import quoted


@dataclass(eq=False, repr=False)
class InvalidMessage(QuadError):
    """A message contradicts itself or holds numbers that are not finite."""

    what: str
    """Name of the message, for example ``joint state``."""
    reason: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say what is wrong with the message."""
        return f'the {self.what} cannot be used: {self.reason}'


@dataclass(eq=False, repr=False)
class InvalidTransform(QuadError):
    """A transform between two frames is none in the plane, or not to be believed."""

    parent: str
    """Name of the frame in which it is given."""
    child: str
    """Name of the frame that it places."""
    reason: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say what is wrong with the transform."""
        return (
            f"the transform from '{self.parent[:60]}' to '{self.child[:60]}' is not used: "
            f'{self.reason}'
        )


@dataclass(eq=False, repr=False)
class RobotLeftOut(QuadError):
    """Another robot is one more than can be reckoned with."""

    name: str
    """Name of the robot."""
    most: int
    """Largest number of other robots."""

    def sentence(self) -> str:
        """Say how many are reckoned with."""
        return (
            f'robot {quoted(self.name)} is ignored: {self.most} other robots are tracked already, '
            'which is the limit'
        )


@dataclass(eq=False, repr=False)
class ClockLeapt(QuadError):
    """A clock that is followed went back, or far forward at once."""

    before: float
    """Time that it told before [s]."""
    after: float
    """Time that it told next [s]."""

    def sentence(self) -> str:
        """Say how far, and what becomes of a recording."""
        span = f'by {abs(self.after - self.before):.6g} s, from {self.before:.6g} s'
        if self.after < self.before:
            return f'the clock went back {span}; the recording goes on'
        return f'the clock leapt forward {span}, and so does the recording'


@dataclass(eq=False, repr=False)
class ClockDisbelieved(QuadError):
    """A clock fits neither the one before it nor the next one."""

    before: float
    """Time that was told before [s]."""
    told: float
    """Time that is not believed [s]."""

    def sentence(self) -> str:
        """Say which times do not fit."""
        return (
            f'a clock of {self.told:.6g} s after one of {self.before:.6g} s is not believed: the '
            'next one does not come from there; does anybody else publish clock?'
        )


@dataclass(eq=False, repr=False)
class MessagesLeftOut(QuadError):
    """Messages of a recording's topic cannot be used."""

    topic: str
    """Name of the topic, relative to the robot's namespace."""
    count: int
    """Number of them."""
    first: float
    """Time of the first one, from the beginning of the recording on [s]."""
    problem: QuadError
    """What is wrong with that one."""

    def sentence(self) -> str:
        """Say how many there are, and what is wrong with the first."""
        many = 'a message' if self.count == 1 else f'{self.count} messages'
        said = f'{many} of {self.topic} left out, the first at {self.first:.3f} s'
        return f'{said}: {self.problem}'
