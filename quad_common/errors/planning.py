"""
Errors of planners, with the error codes of Nav2's ComputePathToPose action.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

from quad_common.errors.base import QuadError, listed
from quad_common.errors.quoting import quoted


class PlannerError(QuadError):
    """
    A plan could not be made.

    Attributes
    ----------
    code : int
        The error code of Nav2's ComputePathToPose action (Jazzy) for this failure.
    """

    code = 200


@dataclass(eq=False, repr=False)
class InvalidPlanner(PlannerError):
    """There is no planning method of that name."""

    code = 201

    method: str
    """Name that was given."""
    available: Iterable[str]
    """Names of the methods."""

    def sentence(self) -> str:
        """Say which methods there are."""
        return (
            f'there is no planning method {quoted(self.method)}; '
            f'available: {listed(self.available)}'
        )


@dataclass(eq=False, repr=False)
class WrongFrame(PlannerError):
    """A pose came in a frame that cannot be related to the map's."""

    code = 202

    what: str
    """Name of the pose, for example ``goal``."""
    frame: str
    """Frame in which it was given."""
    expected: str
    """Frame of the map."""

    def sentence(self) -> str:
        """Say in which frame the pose is wanted."""
        return (
            f'the {self.what} is in frame {quoted(self.frame)}, which cannot be related to '
            f'{quoted(self.expected)}; give it in {quoted(self.expected)}'
        )


@dataclass(eq=False, repr=False)
class InvalidPose(PlannerError):
    """A pose holds a number that is not finite, or no rotation at all."""

    what: str
    """Name of the pose, for example ``goal``."""
    reason: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say what is wrong with the pose."""
        return f'the {self.what} is not a pose: {self.reason}'


@dataclass(eq=False, repr=False)
class NoMap(PlannerError):
    """A plan is requested before there is a map."""

    def sentence(self) -> str:
        """Say what is missing."""
        return 'there is no map to plan on yet; a map must be set first'


@dataclass(eq=False, repr=False)
class NoRobotPose(PlannerError):
    """A plan is to begin where the robot is, and that is not known."""

    code = 202

    def sentence(self) -> str:
        """Say what is missing."""
        return "the robot's pose is not known: no odometry has been received, or none recently"


@dataclass(eq=False, repr=False)
class NoGoals(PlannerError):
    """A plan through poses is requested, and there are none."""

    code = 209

    def sentence(self) -> str:
        """Say what is missing."""
        return 'there is no pose to go to; give one at least'


@dataclass(eq=False, repr=False)
class _OutsideMap(PlannerError):
    _what = 'pose'

    x: float
    """Coordinate of the pose [m]."""
    y: float
    """Coordinate of the pose [m]."""
    bounds: Sequence[float]
    """Bounds of the map x_min, y_min, x_max, y_max [m]."""

    def sentence(self) -> str:
        """Say where the map is."""
        x_min, y_min, x_max, y_max = self.bounds
        return (
            f'the {self._what} ({self.x:.2f}, {self.y:.2f}) m is outside the map, which spans '
            f'x {x_min:.2f} to {x_max:.2f} m and y {y_min:.2f} to {y_max:.2f} m'
        )


class StartOutsideMap(_OutsideMap):
    """The start lies outside the map."""

    code = 203
    _what = 'start'


class GoalOutsideMap(_OutsideMap):
    """The goal lies outside the map."""

    code = 204
    _what = 'goal'


@dataclass(eq=False, repr=False)
class _Occupied(PlannerError):
    _what = 'pose'

    x: float
    """Coordinate of the pose [m]."""
    y: float
    """Coordinate of the pose [m]."""
    clearance: float
    """Distance to the nearest occupied or unknown cell [m]."""
    required: float
    """Distance that the robot needs [m]."""

    def sentence(self) -> str:
        """Say how much room there is and how much is needed."""
        return (
            f'the {self._what} ({self.x:.2f}, {self.y:.2f}) m is {self.clearance:.2f} m from the '
            f'nearest occupied or unknown cell; the robot needs {self.required:.2f} m'
        )


class StartOccupied(_Occupied):
    """The start is too near to an obstacle for the robot to stand there."""

    code = 205
    _what = 'start'


class GoalOccupied(_Occupied):
    """The goal is too near to an obstacle for the robot to stand there."""

    code = 206
    _what = 'goal'


@dataclass(eq=False, repr=False)
class GoalWithoutFooting(PlannerError):
    """The ground at the goal has no footholds on which the robot could stand."""

    code = 206

    x: float
    """Coordinate of the goal [m]."""
    y: float
    """Coordinate of the goal [m]."""
    heading: float
    """Heading of the goal [rad]."""
    distance: float
    """Distance from it within which it was looked for footholds, too [m]."""
    turn: float
    """Difference from its heading within which it was looked for footholds, too [rad]."""

    def sentence(self) -> str:
        """Say where, and how near to it was looked."""
        return (
            f'the robot cannot stand at the goal ({self.x:.2f}, {self.y:.2f}) m at a heading of '
            f'{math.degrees(self.heading):.0f} degrees: by the height map its feet find no '
            f'footholds in reach there, nor within {self.distance:.2f} m and '
            f'{math.degrees(self.turn):.0f} degrees'
        )


@dataclass(eq=False, repr=False)
class PlannerTimedOut(PlannerError):
    """The search ran out of its time."""

    code = 207

    limit: float
    """Time that the search had [s]."""

    def sentence(self) -> str:
        """Say how long was searched."""
        return f'no plan was found within the limit of {self.limit:.2f} s'


@dataclass(eq=False, repr=False)
class PlanSuperseded(PlannerError):
    """A newer request took the place of a search that was still running."""

    def sentence(self) -> str:
        """Say why the search ended."""
        return 'the search was given up for a newer request'


@dataclass(eq=False, repr=False)
class TooManyRequests(PlannerError):
    """So many searches wait for their turn that no more are taken."""

    most: int
    """Number that may wait."""

    def sentence(self) -> str:
        """Say how many wait."""
        return f'{self.most} requests for plans wait already: ask again when they are answered'


@dataclass(eq=False, repr=False)
class NoPathFound(PlannerError):
    """Start and goal are both valid, but nothing connects them."""

    code = 208

    start: Sequence[float]
    """Coordinates x and y of the start [m]."""
    goal: Sequence[float]
    """Coordinates x and y of the goal [m]."""
    why: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say what is not connected, and why."""
        return (
            f'no path from ({self.start[0]:.2f}, {self.start[1]:.2f}) m to '
            f'({self.goal[0]:.2f}, {self.goal[1]:.2f}) m: {self.why}'
        )


@dataclass(eq=False, repr=False)
class RobotsInTheWay(PlannerError):
    """Other robots that stay where they are leave no path to the goal."""

    code = 208

    names: Sequence[str]
    """Names of the robots."""
    waited: float
    """Time for which they were waited for [s]."""

    def sentence(self) -> str:
        """Say who blocks the robot."""
        return (
            f'blocked by {listed(self.names)} for {self.waited:.0f} s, and no path leads around: '
            f'the goal is given up'
        )


@dataclass(eq=False, repr=False)
class DescentStuck(NoPathFound):
    """The descent of a potential came to rest elsewhere than at the goal."""

    why: str = field(init=False)
    """Reason, as a clause."""
    place: Sequence[float]
    """Coordinates x and y of the place where it came to rest [m]."""
    kind: str
    """Kind of critical point there, with its article."""
    eigenvalues: Sequence[float]
    """Eigenvalues of the potential's Hessian there, the smaller one first [1/m^2]."""

    def __post_init__(self) -> None:
        """Keep plain numbers, and say why there is no path."""
        x, y = self.place = (float(self.place[0]), float(self.place[1]))
        low, high = self.eigenvalues = (float(self.eigenvalues[0]), float(self.eigenvalues[1]))
        self.why = (
            f'the descent of the potential comes to rest at ({x:.2f}, {y:.2f}) m, {self.kind}: '
            'attraction and repulsion are equal there '
            f"(the Hessian's eigenvalues are {low:.3g} and {high:.3g})"
        )
