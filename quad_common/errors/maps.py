"""
Errors of maps and height maps, their files and images.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from os import PathLike

import numpy as np

from quad_common.errors.base import QuadError
from quad_common.errors.files import FileEntryInvalid, FileUnusable
from quad_common.errors.parameters import OutOfRange
from quad_common.errors.quoting import clipped, shown


class MapError(QuadError):
    """A map file or an occupancy grid cannot be used."""


class MapValueOutOfRange(MapError, OutOfRange):
    """A quantity of a map or a height map is no number of its range."""


class MapFileUnusable(MapError, FileUnusable):
    """A map's file or image cannot be read or written."""


class MapEntryInvalid(MapError, FileEntryInvalid):
    """An entry of a map's file is not valid."""


@dataclass(eq=False, repr=False)
class MapArrayInvalid(MapError):
    """The cells of a map, or the heights of a height map, are no such array."""

    what: str
    """Name of the array."""
    kind: str
    """Kind of numbers that it must hold."""
    found: str
    """Description of what was given."""

    def sentence(self) -> str:
        """Say which array is needed."""
        return f'{self.what} must be a two-dimensional array of {self.kind}, not {self.found}'

    @classmethod
    def of(cls, what: str, kind: str, values: object) -> MapArrayInvalid:
        """Return the error of what was given in the array's place."""
        if isinstance(values, np.ndarray):
            return cls(what, kind, f'{values.ndim}-dimensional of {values.dtype}')
        return cls(what, kind, f'a {type(values).__name__}')


@dataclass(eq=False, repr=False)
class CellCountOutOfRange(MapError):
    """A map has no cells, or too many."""

    what: str
    """Kind of the map, with its article."""
    columns: int
    """Number of columns."""
    rows: int
    """Number of rows."""
    most: int
    """Largest number of cells."""

    def sentence(self) -> str:
        """Say how many cells are valid."""
        return (
            f'{self.what} has {self.columns} x {self.rows} cells; '
            f'it must have between 1 and {self.most}'
        )


@dataclass(eq=False, repr=False)
class CellValuesOutOfRange(MapError):
    """Cells of a map hold values that mean nothing."""

    lowest: int
    """Least value of the cells."""
    highest: int
    """Largest value of the cells."""

    def sentence(self) -> str:
        """Say which values are valid."""
        return (
            f'the cells of the map hold values from {self.lowest} to {self.highest}; '
            'they must be 0 to 100, or -1 for unknown'
        )


@dataclass(eq=False, repr=False)
class MapOriginInvalid(MapError):
    """The origin of a height map is no point of the plane."""

    origin: object
    """Origin that was given."""

    def sentence(self) -> str:
        """Say what an origin is."""
        return f'the origin of the height map is {shown(self.origin)}; give x and y'


@dataclass(eq=False, repr=False)
class MapBoundsUnusable(MapError):
    """Bounds and resolution make no map, or one that is too large."""

    what: str
    """Kind of the map, with its article."""
    bounds: tuple[float, float, float, float]
    """Bounds x_min, y_min, x_max, y_max [m]."""
    resolution: float
    """Side of a cell [m]."""
    most: int
    """Largest number of cells."""
    reason: str = 'has no cells'
    """Reason, as the end of the sentence "the map ..."."""

    def sentence(self) -> str:
        """Say how many cells there must be."""
        x_min, y_min, x_max, y_max = self.bounds
        return (
            f'{self.what} from ({x_min}, {y_min}) to ({x_max}, {y_max}) m with cells of '
            f'{self.resolution} m {self.reason}; it must have between 1 and {self.most} cells'
        )


@dataclass(eq=False, repr=False)
class MapSizesDisagree(MapError):
    """The size of a map is not that of its cells."""

    columns: int
    """Number of columns that the map says."""
    rows: int
    """Number of rows that the map says."""
    count: int
    """Number of cells that are given."""

    def sentence(self) -> str:
        """Say how many cells are needed."""
        return (
            f'the map has {self.count} cells; {self.columns} x {self.rows} needs '
            f'{self.columns * self.rows}'
        )


@dataclass(eq=False, repr=False)
class MapTooLarge(MapError):
    """A map that was received has more cells than are accepted."""

    columns: int
    """Number of columns that the map says."""
    rows: int
    """Number of rows that the map says."""
    count: int
    """Number of cells that are given."""
    most: int
    """Largest number of cells that is accepted."""

    def sentence(self) -> str:
        """Say how many cells are accepted."""
        return (
            f'the map has {self.columns} x {self.rows} cells, and {self.count} are given; '
            f'{self.most} are the most'
        )


@dataclass(eq=False, repr=False)
class CellsTooSmall(MapError):
    """A map has cells that are too small to plan on it by a robot's outline."""

    resolution: float
    """Side of a cell [m]."""
    count: int
    """Number of cells, in a row, over which the robot reaches from its center."""
    most: int
    """Largest number of cells over which it may reach."""

    def sentence(self) -> str:
        """Say what to do about it."""
        # One more than reach goes over, whatever the cells: rounded up to two digits.
        least = self.resolution * (self.count - 1) / (self.most - 1)
        digit = 10.0 ** (math.floor(math.log10(least)) - 1)
        least = math.ceil(least / digit) * digit
        return (
            f"the map's cells of {self.resolution:g} m are too small for footprint 'outline': the "
            f'robot and its distance to obstacles reach over {self.count} of them, and {self.most} '
            f"are the most. Use cells of {least:.2g} m, or footprint 'circle'"
        )


@dataclass(eq=False, repr=False)
class ImageUnreadable(MapError):
    """An image of a map is damaged, or of another format."""

    path: str | PathLike[str]
    """Path of the image."""
    kinds: str
    """Formats that it may have."""
    reason: str
    """Reason why it cannot be read."""

    def sentence(self) -> str:
        """Say why the image cannot be read."""
        return (
            f"the image '{clipped(str(self.path))}' cannot be read as {self.kinds}: {self.reason}"
        )


@dataclass(eq=False, repr=False)
class ImageTooLarge(MapError):
    """An image of a map has no pixels, or too many."""

    path: str | PathLike[str]
    """Path of the image."""
    width: int
    """Number of columns."""
    height: int
    """Number of rows."""
    mode: str
    """Pillow's name of the kind of pixels."""
    most: int
    """Largest number of gray pixels."""

    def sentence(self) -> str:
        """Say how many pixels are valid."""
        return (
            f"the image '{clipped(str(self.path))}' has {self.width} x {self.height} pixels of "
            f'mode {self.mode}; it must have between 1 and {self.most}, {self.most // 2} in color'
        )


@dataclass(eq=False, repr=False)
class HeightImageNotGray(MapError):
    """The image of a height map is not gray with 16 bits."""

    mode: str
    """Pillow's name of the kind of its pixels."""

    def sentence(self) -> str:
        """Say which kind of image is needed."""
        return f'the image is of mode {self.mode}; it must be gray with 16 bits'


@dataclass(eq=False, repr=False)
class HeightImageTooLarge(MapError):
    """The image of a height map has more pixels than a height map has cells."""

    width: int
    """Number of columns."""
    height: int
    """Number of rows."""
    most: int
    """Largest number of pixels."""

    def sentence(self) -> str:
        """Say how many pixels are valid."""
        return (
            f'the image has {self.width} x {self.height} pixels; '
            f'it must have between 1 and {self.most}'
        )


@dataclass(eq=False, repr=False)
class GroundUnknown(MapError):
    """The ground of a simulated world is not known everywhere."""

    unknown: int
    """Number of cells that are not known."""
    cells: int
    """Number of cells."""

    def sentence(self) -> str:
        """Say how much is not known."""
        return (
            f'the ground is unknown in {self.unknown} of {self.cells} cells; '
            'a simulated one must be known everywhere'
        )
