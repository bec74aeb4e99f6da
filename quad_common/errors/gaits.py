"""
Errors of gaits: what legs, joints and balance do not allow, and plans that cannot be followed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from quad_common.errors.base import QuadError


class GaitError(QuadError):
    """A gait cycle cannot be generated, or the gait cannot do what it is asked to."""


@dataclass(eq=False, repr=False)
class FootTargetUnreachable(GaitError):
    """A foot was asked to go where its leg does not reach."""

    foot: str
    """Name of the leg, for example ``lf``."""
    distance: float
    """Distance from the leg's axis to the wanted foot [m]."""
    reach: tuple[float, float]
    """Least and largest distance that the leg reaches [m]."""
    axis: str = 'pitch axis'
    """Axis of the leg from which the distances are."""

    def sentence(self) -> str:
        """Say how far the leg reaches."""
        return (
            f'foot {self.foot} would have to be {self.distance:.3f} m from its {self.axis}; '
            f'the leg reaches {self.reach[0]:.3f} to {self.reach[1]:.3f} m'
        )


@dataclass(eq=False, repr=False)
class FootOutsideWorkspace(FootTargetUnreachable):
    """A foot was asked to go where the three joints of its leg do not take it."""

    short: float = 0.0
    """Distance from the wanted foot to the nearest that was found; infinite if none was [m]."""

    def sentence(self) -> str:
        """Say how far the leg is short of it."""
        short = (
            f'; the nearest reachable point is {1e3 * self.short:.0f} mm away'
            if self.short < 1e3
            else ''
        )
        return (
            f'foot {self.foot} would have to be {self.distance:.3f} m from its {self.axis}, '
            f'outside the workspace of its leg{short}'
        )


@dataclass(eq=False, repr=False)
class SingularPosture(GaitError):
    """A leg stands so that its joints cannot move its foot in every direction."""

    leg: str
    """Name of the leg, for example ``lf``."""
    why: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say what is singular."""
        return f'leg {self.leg} cannot move its foot in every direction: {self.why}'


@dataclass(eq=False, repr=False)
class JointLimitExceeded(GaitError):
    """A joint would leave its range."""

    joint: str
    """Name of the joint."""
    value: float
    """Value that it would have."""
    lower: float
    """Lower limit."""
    upper: float
    """Upper limit."""
    unit: str = 'rad'
    """Unit of value and limits."""

    def sentence(self) -> str:
        """Say what the joint's range is."""
        return (
            f'joint {self.joint} would go to {self.value:.3f} {self.unit}; '
            f'its range is {self.lower:.3f} to {self.upper:.3f} {self.unit}'
        )


@dataclass(eq=False, repr=False)
class UnstableCycle(GaitError):
    """The static stability margin of a planned cycle is too small."""

    margin: float
    """Least margin of the cycle [m]."""
    least: float
    """Margin that it must keep [m]."""

    def sentence(self) -> str:
        """Say what the margin must be."""
        return (
            f'the planned cycle has a least stability margin of {1e3 * self.margin:.1f} mm; '
            f'it must be at least {1e3 * self.least:.1f} mm'
        )


@dataclass(eq=False, repr=False)
class PartsTooNear(GaitError):
    """Parts of the robot would come too near to one another, or to the ground."""

    first: str
    """Link of the robot, for example ``rf_thigh``."""
    second: str
    """Another link, or ``ground``."""
    clearance: float
    """Distance between their surfaces, negative if they would reach into each other [m]."""
    least: float
    """Distance that they must keep [m]."""
    time: float
    """Time in the motion at which they are nearest [s]."""
    duration: float
    """Duration of the motion [s]."""

    def sentence(self) -> str:
        """Say how near they come, and when."""
        near = f'come within {1e3 * self.clearance:.2f} mm' if self.clearance > 0.0 else 'touch'
        return (
            f'{self.first} and {self.second} would {near}, {self.time:.2f} s into a motion of '
            f'{self.duration:.2f} s; they must stay {1e3 * self.least:.2f} mm apart'
        )


@dataclass(eq=False, repr=False)
class ShinTooNear(GaitError):
    """The shin of a leg that stands would come too near to the ground."""

    leg: str
    """Name of the leg, for example ``lf``."""

    def sentence(self) -> str:
        """Say of which leg."""
        return f'the shin of {self.leg} would come too near to the ground'


@dataclass(eq=False, repr=False)
class FootholdNotFound(GaitError):
    """A foot was lowered as far as it goes and met no ground."""

    leg: str
    """Name of the leg, for example ``lf``."""
    depth: float
    """Depth below the expected ground down to which it was lowered [m]."""

    def sentence(self) -> str:
        """Say how deep the foot was lowered."""
        return (
            f'foot {self.leg} met no ground, not even {1e3 * self.depth:.0f} mm below where it was '
            f'expected, nor back where it had stood'
        )


@dataclass(eq=False, repr=False)
class SupportTooNarrow(GaitError):
    """The three feet that would stand are nearly in line."""

    leg: str
    """Name of the leg that was to swing, for example ``lf``."""
    room: float
    """Distance of a point inside the edges between the other feet, at most [m]."""

    def sentence(self) -> str:
        """Say how little room there is."""
        return (
            f'leg {self.leg} cannot swing: the other feet are nearly in line, with room for the '
            f'center of mass {1e3 * self.room:.0f} mm inside them at most'
        )


@dataclass(eq=False, repr=False)
class FootstepsNotFound(GaitError):
    """No sequence of footholds leads on."""

    distance: float
    """Distance to where they were to lead [m]."""
    expansions: int
    """Number of stances from which steps were looked for."""

    def sentence(self) -> str:
        """Say how far they were to lead."""
        return (
            f'no sequence of footholds leads {self.distance:.2f} m ahead: the search expanded '
            f'{self.expansions} stances, and none has a foothold within reach that gets there'
        )


@dataclass(eq=False, repr=False)
class LeftPath(GaitError):
    """The robot is too far from its plan to follow it."""

    distance: float
    """Distance between the robot and its path [m]."""
    tolerance: float
    """Distance within which it follows [m]."""

    def sentence(self) -> str:
        """Say how far the robot is from its path."""
        return (
            f'the robot is {self.distance:.2f} m from its path; it follows within '
            f'{self.tolerance:.2f} m: waiting for a new plan'
        )


@dataclass(eq=False, repr=False)
class CannotFollow(GaitError):
    """The gait can do nothing at all of what the path asks for."""

    what: str
    """Motion that the path asks for, as the end of the sentence "the gait cannot ..."."""
    reason: str
    """Reason."""

    def sentence(self) -> str:
        """Say what the gait cannot do, and why."""
        return (
            f'the gait cannot {self.what} on this robot, not even a little at a time: {self.reason}'
        )


@dataclass(eq=False, repr=False)
class GoalNotReached(GaitError):
    """The robot is at the goal, but its cycles do not bring it within the tolerances."""

    distance: float
    """Distance that is left [m]."""
    angle: float
    """Angle that is left [rad]."""
    cycles: int
    """Number of cycles that were tried."""

    def sentence(self) -> str:
        """Say what is left."""
        return (
            f'after {self.cycles} cycles at the goal that brought it no nearer the robot is still '
            f'{self.distance:.3f} m and {math.degrees(self.angle):.1f} degrees off'
        )


@dataclass(eq=False, repr=False)
class CyclePeriodsDiffer(GaitError):
    """The cycles of walking and of turning are not equally long."""

    walking: float
    """Duration of a cycle of walking [s]."""
    turning: float
    """Duration of a cycle of turning [s]."""

    def sentence(self) -> str:
        """Say how long both are."""
        return (
            f'the walking gait has a cycle of {self.walking:g} s and the turning gait one of '
            f'{self.turning:g} s; walking times can be estimated only if both are equally long'
        )


@dataclass(eq=False, repr=False)
class EmergencyStopOn(GaitError):
    """The emergency stop is on: the robot does not move."""

    def sentence(self) -> str:
        """Say what ends it."""
        return 'the emergency stop is on: release it first'


@dataclass(eq=False, repr=False)
class RobotStaysStill(GaitError):
    """The robot does not move by itself any more."""

    reason: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say why it stays as it is."""
        return f'the robot stays as it is: {self.reason}'


@dataclass(eq=False, repr=False)
class RobotIsLame(GaitError):
    """A joint does not answer, so that the robot stays as it is."""

    fault: str
    """Fault of the joint."""

    def sentence(self) -> str:
        """Say which joint it is."""
        return f'the robot is lame, and stays as it is: {self.fault}'
