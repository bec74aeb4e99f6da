"""
The errors of quadwalk.

Every error takes facts and makes its own sentence: what was wrong, with the
numbers, and what would be valid. Nodes catch :class:`QuadError` at their
callbacks and turn it into a log line and a ``diagnostics`` entry.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from os import PathLike
from typing import TypeVar

from quad_common.quoting import clipped, escaped, quoted, shown

AnyError = TypeVar('AnyError', bound=BaseException)

_LISTED = 40
"""Names that a sentence lists."""

_LONGEST_NAME = 60
"""Characters of each of them."""


def _listed(names: Iterable[str]) -> str:
    known = list(names)
    # What is listed may come from a message: neither its length nor its names are bounded.
    text = ', '.join(sorted(escaped(name[:_LONGEST_NAME]) for name in known[:_LISTED])) or 'none'
    return text if len(known) <= _LISTED else f'{text} and {len(known) - _LISTED} more'


class QuadError(Exception):
    """Base of every error that quadwalk raises on purpose."""


def without_frames(error: AnyError) -> AnyError:
    """
    Let go of the frames that an exception came through; return it.

    An exception that is kept keeps what was being worked on: a picture, or a request of a
    hundred thousand parameters. Where a frame holds the exception too, both stay until the
    garbage collector looks through old objects, which may be minutes.

    Parameters
    ----------
    error : BaseException
        What was caught, and is not raised again.

    Returns
    -------
    BaseException
        The same, with no traceback; likewise what it came from.
    """
    known: set[int] = set()
    waiting: list[BaseException | None] = [error]
    while waiting:
        here = waiting.pop()
        if here is not None and id(here) not in known:
            known.add(id(here))
            here.__traceback__ = None
            waiting += [here.__cause__, here.__context__]
    return error


class ParameterError(QuadError, ValueError):
    """
    A parameter or an argument is outside what is valid.

    Parameters
    ----------
    name : str
        Name of the parameter.
    value : object
        The value that was refused.
    valid : str
        What would be valid, as the end of the sentence "it must be ...".
    where : str
        Beginning of the sentence that says where it stands, for example ``gait file x.yaml: ``.
    """

    def __init__(self, name: str, value: object, valid: str, where: str = '') -> None:
        self.name = name
        self.value = value
        self.valid = valid
        super().__init__(f"{where}'{name}' is {shown(value)}; it must be {valid}")

    def at(self, where: str) -> ParameterError:
        """Return the same error with a beginning that says where the value stands."""
        return ParameterError(self.name, self.value, self.valid, where)


class OutOfRange(ParameterError):
    """
    A quantity is no number of its range.

    Parameters
    ----------
    name : str
        Name of the quantity; dotted where it is a part of another, for example ``origin.x``.
    value : object
        The value that was refused.
    lower, upper : float
        Least and largest valid value.
    unit : str
        Unit of the value and its range; empty for a plain number.
    where : str
        Beginning of the sentence that says where it stands.
    """

    def __init__(
        self,
        name: str,
        value: object,
        lower: float,
        upper: float,
        unit: str = '',
        where: str = '',
    ) -> None:
        self.lower = lower
        self.upper = upper
        self.unit = unit
        of_unit = f' {unit}' if unit else ''
        valid = f'a finite number from {lower:g} to {upper:g}{of_unit}'
        super().__init__(name, value, valid, where)

    def at(self, where: str, kind: type[OutOfRange] | None = None) -> OutOfRange:
        """Return the error as one of another kind, with a beginning that says where it stands."""
        kind = kind or type(self)
        return kind(self.name, self.value, self.lower, self.upper, self.unit, where)


class UnknownKey(ParameterError):
    """
    A file has a key that means nothing.

    Parameters
    ----------
    section : str
        Name of the part of the file that has it; empty for the whole.
    key : str
        The key.
    known : iterable of str
        The keys that would mean something.
    where : str
        Beginning of the sentence that says where it stands.
    """

    def __init__(self, section: str, key: str, known: Iterable[str], where: str = '') -> None:
        self.section = section
        self.key = key
        self.known = tuple(known)
        dotted = f'{section}.{key}' if section else key
        super().__init__(dotted, key, f'one of {", ".join(self.known)}')
        self.args = (
            f'{where}the key {shown(dotted)} means nothing; valid keys'
            f'{f" of {section!r}" if section else ""} are {", ".join(self.known)}',
        )

    def at(self, where: str) -> UnknownKey:
        """Return the same error with a beginning that says where the key stands."""
        return UnknownKey(self.section, self.key, self.known, where)


class FileUnusable(QuadError):
    """
    A file cannot be read, or cannot be written.

    Parameters
    ----------
    what : str
        What the file is, for example ``map file``.
    path : str or path-like
        The file.
    reason : str
        What is wrong with it, as the end of the sentence "the file ...".
    """

    def __init__(self, what: str, path: str | PathLike[str], reason: str) -> None:
        self.what = what
        self.path = path
        self.reason = clipped(reason)
        super().__init__(f'{what} {clipped(str(path))} {self.reason}')


class RobotModelError(QuadError):
    """A robot's data file is missing, incomplete or contradicts itself."""


class RobotValueOutOfRange(RobotModelError, OutOfRange):
    """A quantity of a robot's data file is no number of its range."""


class MapError(QuadError):
    """A map file or an occupancy grid cannot be used."""


class MapValueOutOfRange(MapError, OutOfRange):
    """A quantity of a map or a height map is no number of its range."""


class PlannerError(QuadError):
    """
    A plan could not be made.

    Attributes
    ----------
    code : int
        The error code of Nav2's ComputePathToPose action (Jazzy) for this failure.
    """

    code = 200


class InvalidPlanner(PlannerError):
    """There is no planning method of that name."""

    code = 201

    def __init__(self, method: str, available: Iterable[str]) -> None:
        super().__init__(
            f'there is no planning method {quoted(method)}; available: {_listed(available)}'
        )


class WrongFrame(PlannerError):
    """A pose came in a frame that cannot be related to the map's."""

    code = 202

    def __init__(self, what: str, frame: str, expected: str) -> None:
        super().__init__(
            f'the {what} is in frame {quoted(frame)}, which cannot be related to '
            f'{quoted(expected)}; give it in {quoted(expected)}'
        )


class InvalidTransform(QuadError):
    """A transform between two frames is none in the plane, or not to be believed."""

    def __init__(self, parent: str, child: str, reason: str) -> None:
        self.parent = parent
        self.child = child
        self.reason = reason
        super().__init__(
            f"the transform from '{parent[:60]}' to '{child[:60]}' is not used: {reason}"
        )


class InvalidPose(PlannerError):
    """A pose holds a number that is not finite, or no rotation at all."""

    def __init__(self, what: str, reason: str) -> None:
        super().__init__(f'the {what} is not a pose: {reason}')


class _OutsideMap(PlannerError):
    _what = 'pose'

    def __init__(self, x: float, y: float, bounds: Sequence[float]) -> None:
        x_min, y_min, x_max, y_max = bounds
        super().__init__(
            f'the {self._what} ({x:.2f}, {y:.2f}) m is outside the map, which spans '
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


class _Occupied(PlannerError):
    _what = 'pose'

    def __init__(self, x: float, y: float, clearance: float, required: float) -> None:
        self.clearance = clearance
        self.required = required
        super().__init__(
            f'the {self._what} ({x:.2f}, {y:.2f}) m is {clearance:.2f} m from the nearest '
            f'occupied or unknown cell; the robot needs {required:.2f} m'
        )


class StartOccupied(_Occupied):
    """The start is too near to an obstacle for the robot to stand there."""

    code = 205
    _what = 'start'


class GoalOccupied(_Occupied):
    """The goal is too near to an obstacle for the robot to stand there."""

    code = 206
    _what = 'goal'


class PlannerTimedOut(PlannerError):
    """The search ran out of its time."""

    code = 207

    def __init__(self, limit: float) -> None:
        super().__init__(f'no plan was found within the limit of {limit:.2f} s')


class PlanSuperseded(PlannerError):
    """A newer request took the place of a search that was still running."""

    def __init__(self) -> None:
        super().__init__('the search was given up for a newer request')


class NoPathFound(PlannerError):
    """Start and goal are both valid, but nothing connects them."""

    code = 208

    def __init__(self, start: Sequence[float], goal: Sequence[float], why: str) -> None:
        super().__init__(
            f'no path from ({start[0]:.2f}, {start[1]:.2f}) m to '
            f'({goal[0]:.2f}, {goal[1]:.2f}) m: {why}'
        )


class DescentStuck(NoPathFound):
    """
    The descent of a potential came to rest elsewhere than at the goal.

    Parameters
    ----------
    start, goal, place : sequence of float
        Where the descent began, should have ended and came to rest: x and y [m].
    kind : str
        What kind of critical point this is, with its article.
    eigenvalues : sequence of float
        Of the potential's Hessian there, the smaller one first [1/m^2].
    """

    def __init__(
        self,
        start: Sequence[float],
        goal: Sequence[float],
        place: Sequence[float],
        kind: str,
        eigenvalues: Sequence[float],
    ) -> None:
        self.place = (float(place[0]), float(place[1]))
        self.kind = kind
        self.eigenvalues = (float(eigenvalues[0]), float(eigenvalues[1]))
        low, high = self.eigenvalues
        super().__init__(
            start,
            goal,
            f'the descent of the potential comes to rest at ({place[0]:.2f}, {place[1]:.2f}) m, '
            f'{kind}: attraction and repulsion are equal there '
            f"(the Hessian's eigenvalues are {low:.3g} and {high:.3g})",
        )


class CameraError(QuadError):
    """A camera's file cannot be used, or a camera cannot be calibrated from what is given."""


class CameraValueOutOfRange(CameraError, OutOfRange):
    """A quantity of a camera's file is no number of its range."""


class PerceptionError(QuadError):
    """Something cannot be made out in a picture."""


class PictureUnusable(PerceptionError):
    """
    A picture shows nothing.

    Parameters
    ----------
    reason : str
        What is wrong with it, as the end of the sentence "the picture ...".
    """

    def __init__(self, reason: str) -> None:
        super().__init__(f'the picture {reason}')


class MarkerNotSeen(PerceptionError):
    """
    There is nothing of a marker in the picture.

    Parameters
    ----------
    what : str
        What carries the marker, for example ``robot``.
    colors : iterable of str
        Names of the ranges of colors that were looked for.
    """

    def __init__(self, what: str, colors: Iterable[str]) -> None:
        super().__init__(
            f'the {what} is not seen: there is no disc of the colors {_listed(colors)} '
            'in the picture'
        )


class MarkerHidden(PerceptionError):
    """
    A part of a marker is seen, and not enough of it for a pose.

    Parameters
    ----------
    what : str
        What carries the marker.
    color : str
        Name of the range of colors of the disc that lacks.
    seen : float
        Share of the disc that is seen, 0 to 1.
    why : str
        What hides it, or that it is not known.
    """

    def __init__(self, what: str, color: str, seen: float, why: str) -> None:
        self.seen = seen
        super().__init__(
            f"of the {what}'s disc '{color}' only {100.0 * seen:.0f} % is seen, which is too "
            f'little for a pose: {why}'
        )


class SeveralMarkers(PerceptionError):
    """
    A marker is seen more than once.

    Parameters
    ----------
    what : str
        What carries the marker.
    places : sequence of sequence of float
        Where they are: x and y [m].
    """

    def __init__(self, what: str, places: Sequence[Sequence[float]]) -> None:
        self.places = [(float(place[0]), float(place[1])) for place in places]
        where = ' and '.join(f'({x:.2f}, {y:.2f}) m' for x, y in self.places)
        super().__init__(f'the {what} is seen {len(self.places)} times, at {where}: leave one')


class GaitError(QuadError):
    """A gait cycle cannot be generated."""


class FootTargetUnreachable(GaitError):
    """
    A foot was asked to go where its leg does not reach.

    Parameters
    ----------
    foot : str
        Name of the leg, for example ``lf``.
    distance : float
        Distance from the leg's axis to the wanted foot [m].
    reach : tuple of float
        Least and largest distance that the leg reaches [m].
    axis : str
        Which axis of the leg the distances are from.
    """

    def __init__(
        self, foot: str, distance: float, reach: tuple[float, float], axis: str = 'pitch axis'
    ) -> None:
        self.foot = foot
        self.distance = distance
        self.reach = reach
        super().__init__(
            f'foot {foot} would have to be {distance:.3f} m from its {axis}; '
            f'the leg reaches {reach[0]:.3f} to {reach[1]:.3f} m'
        )


class SingularPosture(GaitError):
    """
    A leg stands so that its joints cannot move its foot in every direction.

    Parameters
    ----------
    leg : str
        Name of the leg, for example ``lf``.
    why : str
        What is singular, as a clause.
    """

    def __init__(self, leg: str, why: str) -> None:
        self.leg = leg
        super().__init__(f'leg {leg} cannot move its foot in every direction: {why}')


class JointLimitExceeded(GaitError):
    """A joint would leave its range."""

    def __init__(
        self, joint: str, value: float, lower: float, upper: float, quantity: str = 'rad'
    ) -> None:
        self.joint = joint
        super().__init__(
            f'joint {joint} would go to {value:.3f} {quantity}; '
            f'its range is {lower:.3f} to {upper:.3f} {quantity}'
        )


class UnstableCycle(GaitError):
    """The static stability margin of a planned cycle is too small."""

    def __init__(self, margin: float, least: float) -> None:
        super().__init__(
            f'the planned cycle has a least stability margin of {1e3 * margin:.1f} mm; '
            f'it must be at least {1e3 * least:.1f} mm'
        )


class PartsTooNear(GaitError):
    """
    Parts of the robot would come too near to one another, or to the ground.

    Parameters
    ----------
    first, second : str
        Links of the robot, for example ``rf_thigh``; the second may be ``ground``.
    clearance : float
        Distance between their surfaces, negative if they would reach into each other [m].
    least : float
        Distance that they must keep [m].
    time : float
        When in the motion they are nearest [s].
    duration : float
        How long the motion takes [s].
    """

    def __init__(
        self,
        first: str,
        second: str,
        clearance: float,
        least: float,
        time: float,
        duration: float,
    ) -> None:
        self.first = first
        self.second = second
        self.clearance = clearance
        self.least = least
        self.time = time
        self.duration = duration
        near = f'come within {1e3 * clearance:.2f} mm' if clearance > 0.0 else 'touch'
        super().__init__(
            f'{first} and {second} would {near}, {time:.2f} s into a motion of '
            f'{duration:.2f} s; they must stay {1e3 * least:.2f} mm apart'
        )


class FootholdNotFound(GaitError):
    """A foot was lowered as far as it goes and met no ground."""

    def __init__(self, leg: str, depth: float) -> None:
        self.leg = leg
        super().__init__(
            f'foot {leg} met no ground, not even {1e3 * depth:.0f} mm below where it was '
            f'expected, nor back where it had stood'
        )


class LeftPath(GaitError):
    """
    The robot is too far from its plan to follow it.

    Parameters
    ----------
    distance : float
        Distance between the robot and its path [m].
    tolerance : float
        Distance within which it follows [m].
    """

    def __init__(self, distance: float, tolerance: float) -> None:
        self.distance = distance
        self.tolerance = tolerance
        super().__init__(
            f'the robot is {distance:.2f} m from its path; it follows within {tolerance:.2f} m: '
            f'waiting for a new plan'
        )


class CannotFollow(GaitError):
    """
    The gait can do nothing at all of what the path asks for.

    Parameters
    ----------
    what : str
        What the path asks for, as the end of the sentence "the gait cannot ...".
    reason : str
        What forbids it.
    """

    def __init__(self, what: str, reason: str) -> None:
        self.what = what
        self.reason = reason
        super().__init__(
            f'the gait cannot {what} on this robot, not even a little at a time: {reason}'
        )


class GoalNotReached(GaitError):
    """
    The robot is at the goal, but its cycles do not bring it within the tolerances.

    Parameters
    ----------
    distance : float
        Distance that is left [m].
    angle : float
        Angle that is left [rad].
    cycles : int
        Number of cycles that were tried.
    """

    def __init__(self, distance: float, angle: float, cycles: int) -> None:
        self.distance = distance
        self.angle = angle
        self.cycles = cycles
        super().__init__(
            f'after {cycles} cycles at the goal the robot is still {distance:.3f} m and '
            f'{math.degrees(angle):.1f} degrees off'
        )


class ActivePairError(QuadError):
    """A planar pair of legs cannot stand as it was asked to."""


class PairCannotClose(ActivePairError):
    """
    No posture of a pair of legs has what is given: its links are too short, or too long.

    Parameters
    ----------
    index : int or tuple of int or None
        Which of several postures, the first one that fails; None where there is one only.
    ends : str
        Between which two points links are to reach, as the beginning of "... are 1 m apart".
    links : str
        What is to reach, with its plural verb, as the beginning of "... 1 to 2 m".
    distance : float
        How far the ends are apart, which is what is needed [m].
    reach : tuple of float
        Least and largest distance that the links reach [m].
    """

    def __init__(
        self,
        index: int | tuple[int, ...] | None,
        ends: str,
        links: str,
        distance: float,
        reach: tuple[float, float],
    ) -> None:
        self.index = index
        self.distance = distance
        self.reach = reach
        low, high = reach
        # Where rounding would hide by how much, more is shown.
        off = max(low - distance, distance - high)
        digits = 3 if not 0.0 < off < 2e-3 else 9
        between = f'{low:.{digits}f} to {high:.{digits}f}' if low < high else f'{low:.{digits}f}'
        super().__init__(
            f'{_posture(index)}{ends} are {distance:.{digits}f} m apart; {links} {between} m'
        )


class PairUndetermined(ActivePairError):
    """
    What is given of a pair of legs leaves it free to turn about a point.

    Parameters
    ----------
    index : int or tuple of int or None
        Which of several postures, the first one that fails; None where there is one only.
    why : str
        What coincides, as a clause.
    """

    def __init__(self, index: int | tuple[int, ...] | None, why: str) -> None:
        self.index = index
        super().__init__(f'{_posture(index)}the pair may still turn: {why}')


class BodyOutOfReach(ActivePairError):
    """
    Legs of given lengths do not carry the body to its place over the feet.

    Parameters
    ----------
    index : int or tuple of int or None
        Which of several postures, the first one that fails; None where there is one only.
    x : float
        Where the point midway between the hips was to be, along x [m].
    reach : tuple of float
        Between which places the legs carry it, along x [m].
    """

    def __init__(
        self, index: int | tuple[int, ...] | None, x: float, reach: tuple[float, float]
    ) -> None:
        self.index = index
        self.reach = reach
        super().__init__(
            f'{_posture(index)}the middle of the body would be at x = {x:.3f} m; the legs carry '
            f'it from {reach[0]:.3f} to {reach[1]:.3f} m'
        )


def _posture(index: int | tuple[int, ...] | None) -> str:
    return '' if index is None else f'posture {index}: '


class TrajectoryError(QuadError):
    """A joint trajectory is malformed or comes too late."""


class CommandOutsideLimits(TrajectoryError):
    """
    A command asks for what a joint cannot do.

    Parameters
    ----------
    joint : str
        Name of the joint.
    quantity : str
        What is outside its range: ``position`` or ``velocity``.
    value : float
        What it would be.
    limits : tuple of float
        Least and largest value.
    unit : str
        Of value and limits.
    """

    def __init__(
        self, joint: str, quantity: str, value: float, limits: tuple[float, float], unit: str
    ) -> None:
        self.joint = joint
        self.quantity = quantity
        self.value = value
        self.limits = limits
        super().__init__(
            f'joint {joint} would be commanded a {quantity} of {value:.4g} {unit}; '
            f'its limits are {limits[0]:.4g} to {limits[1]:.4g} {unit}'
        )


class InvalidMessage(QuadError):
    """A message contradicts itself or holds numbers that are not finite."""

    def __init__(self, what: str, reason: str) -> None:
        super().__init__(f'the {what} cannot be used: {reason}')


class CommandJumps(TrajectoryError):
    """
    A trajectory would make a command jump.

    Parameters
    ----------
    joint : str
        Name of the joint.
    step : float
        How far it would jump [rad].
    period : float
        Time in which it would have to get there [s].
    """

    def __init__(self, joint: str, step: float, period: float) -> None:
        self.joint = joint
        self.step = step
        self.period = period
        super().__init__(
            f'the command of joint {joint} would jump by {step:.3f} rad, '
            f'farther than it turns in {period:g} s'
        )


class EmergencyStopped(TrajectoryError):
    """The emergency stop is on: no trajectory is executed."""

    def __init__(self) -> None:
        super().__init__('the trajectory is not executed: the emergency stop is on')


class SimulatorError(QuadError):
    """The simulator cannot do what it was asked to."""


class NotSimulated(SimulatorError):
    """
    The simulator's backend leaves out what is asked for.

    Parameters
    ----------
    what : str
        What is asked for, with its article.
    backend : str
        The backend that has it.
    """

    def __init__(self, what: str, backend: str) -> None:
        super().__init__(
            f"{what} cannot be had: this simulator has nothing to see but the robot's numbers; "
            f"set 'backend' to '{backend}'"
        )


class ObstacleOnRobot(SimulatorError):
    """
    An obstacle would stand where the robot is.

    Parameters
    ----------
    name : str
        Of the obstacle.
    distance, required : float
        From base_link to the obstacle, and what the robot needs [m].
    """

    def __init__(self, name: str, distance: float, required: float) -> None:
        super().__init__(
            f'obstacle {name} would stand {distance:.2f} m from the middle of the robot; '
            f'it must be at least {required:.2f} m away'
        )


class TooManyObstacles(SimulatorError):
    """
    More obstacles would stand in the world than it may hold.

    Parameters
    ----------
    count : int
        Number that there would be.
    most : int
        Number that there may be.
    """

    def __init__(self, count: int, most: int) -> None:
        self.count = count
        self.most = most
        super().__init__(f'there would be {count} obstacles; {most} are the most')


class JointNotFound(SimulatorError):
    """A joint of that name does not exist."""

    def __init__(self, name: str, available: Iterable[str]) -> None:
        super().__init__(f'there is no joint {quoted(name)}; available: {_listed(available)}')


class MissingOptionalDependency(SimulatorError):
    """A capability needs a package that is not installed."""

    def __init__(self, package: str, command: str) -> None:
        super().__init__(f"this needs the package '{package}'; install it with: {command}")
