"""
Errors of cameras, their calibration, and of what is to be seen in pictures.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from os import PathLike

from quad_common.errors.base import QuadError, listed
from quad_common.errors.files import FileEntryInvalid, FileUnusable
from quad_common.errors.parameters import OutOfRange
from quad_common.errors.quoting import quoted


class CameraError(QuadError):
    """A camera's file cannot be used, or a camera cannot be calibrated from what is given."""


class CameraValueOutOfRange(CameraError, OutOfRange):
    """A quantity of a camera's file is no number of its range."""


class CameraFileUnusable(CameraError, FileUnusable):
    """A file of a camera, of points, colors or a picture cannot be read or written."""


class CameraEntryInvalid(CameraError, FileEntryInvalid):
    """An entry of a camera's file, or of one of colors, is not valid."""


@dataclass(eq=False, repr=False)
class PointCountsDiffer(CameraError):
    """A calibration has not one pixel for each point."""

    points: int
    """Number of points."""
    pixels: int
    """Number of pixels."""

    def sentence(self) -> str:
        """Say how many there are of each."""
        return f'there are {self.points} points and {self.pixels} pixels'


@dataclass(eq=False, repr=False)
class TooFewPoints(CameraError):
    """A calibration has too few points."""

    count: int
    """Number of points."""
    least: int
    """Number that is needed."""

    def sentence(self) -> str:
        """Say how many are needed."""
        return f'there are {self.count} points; {self.least} are needed at least'


@dataclass(eq=False, repr=False)
class PointsNotNumbers(CameraError):
    """The points or pixels of a calibration are not numbers."""

    what: str
    """Name of the values: ``points`` or ``pixels``."""

    def sentence(self) -> str:
        """Say what is wrong."""
        return f'the {self.what} are not numbers'


@dataclass(eq=False, repr=False)
class PointsMalformed(CameraError):
    """The points or pixels of a calibration are not rows of finite numbers."""

    what: str
    """Name of the values: ``points`` or ``pixels``."""
    columns: tuple[int, ...]
    """Numbers of columns that would be valid."""

    def sentence(self) -> str:
        """Say what rows are needed."""
        wanted = ' or '.join(str(count) for count in self.columns)
        return f'the {self.what} must be rows of {wanted} finite numbers'


@dataclass(eq=False, repr=False)
class PointsInLine(CameraError):
    """The points or pixels of a calibration are in a line, or the same."""

    what: str
    """Name of the values: ``points`` or ``pixels``."""

    def sentence(self) -> str:
        """Say which points to take."""
        return (
            f'the {self.what} are in a line, or the same: a camera can turn around it; '
            'take points in the corners of the room'
        )


@dataclass(eq=False, repr=False)
class NoPoseAbovePoints(CameraError):
    """No pose of a camera above the points fits."""

    def sentence(self) -> str:
        """Say what to check."""
        return (
            'no pose of a camera above the points fits; check their order, and that x is right '
            'and y is left of it, seen from above'
        )


@dataclass(eq=False, repr=False)
class CameraPoseDoesNotFit(CameraError):
    """The pose of a camera that fits best does not fit well."""

    mean_error: float
    """Mean distance of the points from their projections [pixels]."""
    worst: int
    """Number of the point that is farthest off, from 1."""
    pixel: tuple[float, float]
    """Column and row of that point in the picture."""

    def sentence(self) -> str:
        """Say which point is farthest off."""
        return (
            f'no pose of the camera fits: the points are {self.mean_error:.1f} pixels '
            f'from their projections on the average, the worst is number {self.worst} at '
            f'({self.pixel[0]:g}, {self.pixel[1]:g}); check their order and places'
        )


@dataclass(eq=False, repr=False)
class PointLineMalformed(CameraError):
    """A line of a file of points is no point."""

    what: str
    """Kind of the file."""
    path: str | PathLike[str]
    """Path of the file."""
    line: int
    """Number of the line, from 1."""

    def sentence(self) -> str:
        """Say what a line must hold."""
        return f'{self.what} {self.path}, line {self.line}: it must hold x, y, column and row'


@dataclass(eq=False, repr=False)
class TooManyPointsInFile(CameraError):
    """A file of points holds more of them than are accepted."""

    what: str
    """Kind of the file."""
    path: str | PathLike[str]
    """Path of the file."""
    most: int
    """Largest number of points."""

    def sentence(self) -> str:
        """Say how many are accepted."""
        return f'{self.what} {self.path} holds more than {self.most} points'


@dataclass(eq=False, repr=False)
class PictureFileError(CameraError):
    """Base of what is wrong with a picture's file."""

    path: str | PathLike[str]
    """Path of the file."""


@dataclass(eq=False, repr=False)
class NotAPicture(PictureFileError):
    """A file is neither a picture nor a video."""

    def sentence(self) -> str:
        """Say what the file is not."""
        return f'{quoted(str(self.path))} is neither a picture nor a video that OpenCV reads'


@dataclass(eq=False, repr=False)
class PictureTooLarge(PictureFileError):
    """A picture has more pixels than are accepted."""

    most: int
    """Largest number of pixels."""

    def sentence(self) -> str:
        """Say how many are accepted."""
        return f'{quoted(str(self.path))} cannot be used: pictures have at most {self.most} pixels'


@dataclass(eq=False, repr=False)
class PictureNotWritten(PictureFileError):
    """A picture cannot be written to a file of that name."""

    def sentence(self) -> str:
        """Say which name would do."""
        return f'{quoted(str(self.path))} cannot be written as a picture; try a name with .png'


class PerceptionError(QuadError):
    """Something cannot be made out in a picture."""


@dataclass(eq=False, repr=False)
class PictureUnusable(PerceptionError):
    """A picture shows nothing."""

    reason: str
    """Reason, as the end of the sentence "the picture ..."."""

    def sentence(self) -> str:
        """Say what is wrong with the picture."""
        return f'the picture {self.reason}'


@dataclass(eq=False, repr=False)
class MarkerNotSeen(PerceptionError):
    """There is nothing of a marker in the picture."""

    what: str
    """Carrier of the marker, for example ``robot``."""
    colors: Iterable[str]
    """Names of the ranges of colors that were looked for."""

    def sentence(self) -> str:
        """Say which colors were looked for."""
        return (
            f'the {self.what} is not seen: there is no disc of the colors {listed(self.colors)} '
            'in the picture'
        )


@dataclass(eq=False, repr=False)
class MarkerHidden(PerceptionError):
    """A part of a marker is seen, and not enough of it for a pose."""

    what: str
    """Carrier of the marker."""
    color: str
    """Name of the range of colors of the disc that lacks."""
    seen: float
    """Fraction of the disc that is seen, 0 to 1."""
    why: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say how much of the disc is seen."""
        return (
            f"of the {self.what}'s disc '{self.color}' only {100.0 * self.seen:.0f} % is seen, "
            f'which is too little for a pose: {self.why}'
        )


@dataclass(eq=False, repr=False)
class SeveralMarkers(PerceptionError):
    """A marker is seen more than once."""

    what: str
    """Carrier of the marker."""
    places: Sequence[Sequence[float]]
    """Coordinates x and y of each [m]."""

    def __post_init__(self) -> None:
        """Keep plain numbers."""
        self.places = [(float(place[0]), float(place[1])) for place in self.places]

    def sentence(self) -> str:
        """Say where they are."""
        where = ' and '.join(f'({x:.2f}, {y:.2f}) m' for x, y in self.places)
        return f'the {self.what} is seen {len(self.places)} times, at {where}: leave one'
