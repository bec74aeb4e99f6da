"""
Which ground a robot cannot walk on: steps that are too high for it, and slopes too steep.

The height map says where; on the occupancy grid such ground becomes obstacles like any other,
so that every planning method walks around it, and walks over what is lower.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from quad_common.errors import ParameterError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import FREE, OCCUPIED, OCCUPIED_THRESHOLD, OccupancyGrid
from quad_common.robot.robot import Robot
from quad_planner.grid.inflation import Mask, Points

Floats = NDArray[np.float64]

LARGEST_SLOPE = 0.26
"""Of the ground, by default: 15 degrees [rad]."""

STEEPEST = 1.2
"""The largest limit that may be set [rad]."""

_STRIDES = 3.0
"""A step is climbed with a stride that is so many times shorter than the largest."""

_STANCES = 1.5
"""A step's height over this many stances is fitted by a plane as steep as height per stance."""

_DIRECTIONS = ((1, 0), (0, 1), (1, 1), (1, -1))
"""In which heights are compared: columns and rows."""

_PARTS = 8
"""The length over which slopes are averaged has so many parts at least, if cells allow it."""

_LEAST_KNOWN = 0.75
"""Part of a slope's surroundings that must be known."""

_AROUND = np.ones((3, 3), dtype=bool)
"""A cell and its eight neighbours."""

_AT_ONCE = 2**18
"""So many cells are laid on the grid at a time."""

_EPSILON = 1e-6
"""Squares that overlap by less only touch [cells]."""


@dataclass(frozen=True)
class GroundLimits:
    """
    What ground a robot can walk on.

    Raises
    ------
    ParameterError
        If a limit is not what its description says.
    """

    step_height: float
    """Highest step that it climbs, > 0 [m]."""
    step_length: float
    """A rise within this length is a step, > 0 [m]."""
    largest_slope: float
    """Of the ground, averaged over `slope_length`; from 0 to :data:`STEEPEST`, not 0 [rad]."""
    slope_length: float
    """Side of the square over which slopes are averaged, > 0 [m]."""

    def __post_init__(self) -> None:
        """Check the limits."""
        for name in ('step_height', 'step_length', 'slope_length'):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, 'a finite length above 0 m')
        if not 0.0 < self.largest_slope <= STEEPEST:
            raise ParameterError('largest_slope', self.largest_slope, f'above 0, to {STEEPEST} rad')

    @classmethod
    def of(
        cls, robot: Robot, step_height: float = 0.0, largest_slope: float = LARGEST_SLOPE
    ) -> GroundLimits:
        """
        Derive the limits of a robot.

        Parameters
        ----------
        robot : Robot
            The robot.
        step_height : float
            0 for the robot's own [m].
        largest_slope : float
            [rad]

        Returns
        -------
        GroundLimits
            A step is what rises within a third of the largest stride. Slopes are averaged over
            one and a half times the stance, the lesser of its length and its width: the plane
            that fits a step there is as steep as the line from foot to foot across it.
        """
        stance = float(np.ptp(robot.neutral_feet[:, :2], axis=0).min())
        return cls(
            step_height or robot.step_height,
            robot.largest_stride / _STRIDES,
            largest_slope,
            _STANCES * stance,
        )


def high_steps(heights: HeightMap, limits: GroundLimits) -> Mask:
    """
    Find steps that are too high.

    Two cells are the sides of such a step if, along a row, a column or a diagonal and within
    the step length (neighbours always), they differ by more than

        step_height + tan(largest_slope) (d - resolution)

    with d between their centers: ground that rises no more than the slope allows is no step, and
    an upright face between two cells is one exactly where it is higher than the step height.

    Parameters
    ----------
    heights : HeightMap
        The ground; unknown cells are compared with nothing.
    limits : GroundLimits
        What the robot can do.

    Returns
    -------
    ndarray of bool, shape (rows, columns)
        The cells on both sides, and those between; of pairs within each other, the nearer.
    """
    z, side = heights.heights, heights.resolution
    rise = math.tan(limits.largest_slope) * side
    found = np.zeros(z.shape, dtype=bool)
    for along_x, along_y in _DIRECTIONS:
        length = math.hypot(along_x, along_y)
        nearer = np.zeros(z.shape, dtype=bool)
        farthest = max(1, math.floor(limits.step_length / (length * side) + _EPSILON))
        for count in range(1, farthest + 1):
            dx, dy = count * along_x, count * along_y
            if abs(dx) >= heights.columns or abs(dy) >= heights.rows:
                break
            here, there = _shifted(z, dx, dy)
            most = limits.step_height + rise * (count * length - 1.0)
            # Heights were rounded on their way.
            too_high = np.abs(there - here) > most + 1e-6
            if not too_high.any():
                continue
            between = [
                _window(dx, dy, part * along_x, part * along_y, z.shape)
                for part in range(count + 1)
            ]
            for window in between:
                too_high &= ~nearer[window]
            for window in between:
                nearer[window] |= too_high
        found |= nearer
    return found


def steep_slopes(heights: HeightMap, limits: GroundLimits) -> Mask:
    """
    Find ground that is too steep on the average.

    A plane is fitted by least squares to the known heights in a square around each place. It is
    not judged where less than three quarters of the square are known, nor where a step that is too
    high lies in it: the robot's clearance covers that anyway, and the plane would be that of the
    step.

    Parameters
    ----------
    heights : HeightMap
        The ground.
    limits : GroundLimits
        What the robot can do.

    Returns
    -------
    ndarray of bool, shape (rows, columns)
        Where the plane rises by more than the largest slope.
    """
    return _steep_slopes(heights, limits, high_steps(heights, limits))


def _steep_slopes(heights: HeightMap, limits: GroundLimits, steps: Mask) -> Mask:
    """Find ground that is too steep, apart from steps, shape (rows, columns)."""
    length, z = limits.slope_length, heights.heights
    # Slopes over a length look the same on cells that are a small part of it.
    factor = max(1, math.floor(length / _PARTS / heights.resolution + _EPSILON))
    known = ~np.isnan(z)
    count = _block_sums(known.astype(float), factor)
    # About a height of the map itself, so that squares of large numbers are not subtracted.
    level = float(z[known].mean()) if known.any() else 0.0
    total = _block_sums(np.where(known, z - level, 0.0), factor)
    weight = count / factor**2
    value = np.where(count > 0.0, total / np.maximum(count, 1.0), 0.0)
    side = factor * heights.resolution
    reach = max(1, math.ceil((length / side - 1.0) / 2.0 - _EPSILON))
    gradient = _plane_slopes(weight, value, side, reach)
    steep = gradient > math.tan(limits.largest_slope) + 1e-9
    if steep.any() and steps.any():
        beside = _block_sums(steps.astype(float), factor) > 0.0
        steep &= ~ndimage.maximum_filter(beside, size=2 * reach + 1, mode='constant')
    rows, columns = z.shape
    fine = np.repeat(np.repeat(steep, factor, axis=0), factor, axis=1)[:rows, :columns]
    return np.asarray(fine & known)


def _plane_slopes(weight: Floats, value: Floats, side: float, reach: int) -> Floats:
    """
    Fit planes to the squares around cells.

    Parameters
    ----------
    weight : ndarray, shape (rows, columns)
        From 0 (unknown) to 1.
    value : ndarray, shape (rows, columns)
        [m]
    side : float
        Of a cell [m].
    reach : int
        The square goes so many cells to each side.

    Returns
    -------
    ndarray, shape (rows, columns)
        Rise per way up the plane; 0 where too little is known.
    """
    u = np.arange(-reach, reach + 1) * side
    powers = (np.ones_like(u), u, u**2)

    def moment(image: Floats, x: int, y: int) -> Floats:
        by_rows = ndimage.correlate1d(image, powers[y], axis=0, mode='constant')
        summed: Floats = ndimage.correlate1d(by_rows, powers[x], axis=1, mode='constant')
        return summed

    n = moment(weight, 0, 0)
    is_enough = n >= _LEAST_KNOWN * len(u) ** 2
    n = np.where(is_enough, n, 1.0)
    weighted = weight * value
    x, y, z = (m / n for m in (moment(weight, 1, 0), moment(weight, 0, 1), moment(weighted, 0, 0)))
    xx = moment(weight, 2, 0) / n - x**2
    xy = moment(weight, 1, 1) / n - x * y
    yy = moment(weight, 0, 2) / n - y**2
    xz = moment(weighted, 1, 0) / n - x * z
    yz = moment(weighted, 0, 1) / n - y * z
    area = np.where(is_enough, xx * yy - xy**2, 1.0)
    slopes = np.hypot(yy * xz - xy * yz, xx * yz - xy * xz) / area
    return np.where(is_enough, slopes, 0.0)


def _block_sums(image: Floats, factor: int) -> Floats:
    """Add up blocks of factor x factor cells; what is beyond the image is 0."""
    rows, columns = image.shape
    padded = np.pad(image, ((0, -rows % factor), (0, -columns % factor)))
    shape = (padded.shape[0] // factor, factor, padded.shape[1] // factor, factor)
    sums: Floats = padded.reshape(shape).sum(axis=(1, 3))
    return sums


def _shifted(image: Floats, dx: int, dy: int) -> tuple[Floats, Floats]:
    """Return the parts of an image that lie (dx, dy) cells apart, of equal shape."""
    here = _window(dx, dy, 0, 0, image.shape)
    there = _window(dx, dy, dx, dy, image.shape)
    return image[here], image[there]


def _window(dx: int, dy: int, x: int, y: int, shape: tuple[int, ...]) -> tuple[slice, slice]:
    """Return where pairs of cells (dx, dy) apart have what lies (x, y) from their first one."""
    rows, columns = shape
    top, left = max(-dy, 0), max(-dx, 0)
    return (
        slice(top + y, top + y + rows - abs(dy)),
        slice(left + x, left + x + columns - abs(dx)),
    )


def cells_touched(heights: HeightMap, marked: Mask, grid: OccupancyGrid) -> Mask:
    """
    Lay cells of a height map on an occupancy grid, which may lie in any way.

    Parameters
    ----------
    heights : HeightMap
        Says where its cells are.
    marked : ndarray of bool, shape (rows, columns)
        Which cells are meant.
    grid : OccupancyGrid
        The grid.

    Returns
    -------
    ndarray of bool, shape (height, width)
        True in the cells of the grid that share some area with a marked one, exactly.
    """
    touched = np.zeros(grid.cells.shape, dtype=bool)
    rows, columns = np.nonzero(marked)
    for first in range(0, len(rows), _AT_ONCE):
        part = slice(first, first + _AT_ONCE)
        cells = np.column_stack((columns[part], rows[part])).astype(np.float64) + 0.5
        centers = grid.world_to_map(cells * heights.resolution + heights.origin)
        _touch(touched, centers, heights.resolution / grid.resolution, grid.origin.yaw)
    return touched


def _touch(touched: Mask, centers: Points, side: float, yaw: float) -> None:
    """
    Mark the cells that squares share an area with.

    Two squares are apart if they are along one of the axes of either.

    Parameters
    ----------
    touched : ndarray of bool, shape (height, width)
        Where they are marked.
    centers : ndarray, shape (n, 2)
        Of the squares [cells].
    side : float
        Of the squares [cells].
    yaw : float
        By which the cells are turned from the squares [rad].
    """
    cosine, sine = math.cos(yaw), math.sin(yaw)
    spread = abs(cosine) + abs(sine)
    reach = side * spread / 2.0
    apart = 0.5 + reach - _EPSILON
    apart_in_world = side / 2.0 + spread / 2.0 - _EPSILON
    size = np.array([touched.shape[1], touched.shape[0]])
    centers = centers[np.all((centers > -reach) & (centers < size + reach), axis=1)]
    low = np.floor(centers - reach).astype(np.int64)
    count = math.ceil(2.0 * reach) + 1
    for row in range(count):
        for column in range(count):
            cells = low + (column, row)
            x, y = (cells + 0.5 - centers).T
            is_shared = (np.abs(x) < apart) & (np.abs(y) < apart)
            is_shared &= np.abs(cosine * x - sine * y) < apart_in_world
            is_shared &= np.abs(sine * x + cosine * y) < apart_in_world
            is_shared &= np.all((cells >= 0) & (cells < size), axis=1)
            shared = cells[is_shared]
            touched[shared[:, 1], shared[:, 0]] = True


@dataclass(frozen=True, eq=False)
class Ground:
    """The ground, and what of it a robot cannot walk on."""

    heights: HeightMap
    """How high it is."""
    limits: GroundLimits
    """What the robot can do."""
    obstacles: Mask = field(init=False)
    """Cells of the height map with steps that are too high, or slopes too steep."""

    def __post_init__(self) -> None:
        """Find the obstacles."""
        steps = high_steps(self.heights, self.limits)
        obstacles = steps | _steep_slopes(self.heights, self.limits, steps)
        object.__setattr__(self, 'obstacles', obstacles)

    def is_like(self, heights: HeightMap) -> bool:
        """Return whether another height map says the same."""
        mine = self.heights
        return (
            mine.origin == heights.origin
            and mine.resolution == heights.resolution
            and np.array_equal(mine.heights, heights.heights, equal_nan=True)
        )

    def added_to(
        self,
        grid: OccupancyGrid,
        occupied_threshold: int = OCCUPIED_THRESHOLD,
        steps_over_low: bool = False,
    ) -> OccupancyGrid:
        """
        Add the obstacles of the ground to a map.

        Parameters
        ----------
        grid : OccupancyGrid
            The map.
        occupied_threshold : int
            Its cells of at least this value are obstacles.
        steps_over_low : bool
            Whether obstacles of the map vanish where the heights show that they are low: all of
            their connected cells, and the cells around them, are known and without an obstacle.
            Only for height maps that show everything that stands on the ground.

        Returns
        -------
        OccupancyGrid
            Occupied where a cell shares some area with an obstacle of the ground, else as the
            map says; the map itself if that changes nothing.
        """
        high = cells_touched(self.heights, self.obstacles, grid)
        low = self._low(grid, occupied_threshold, high) if steps_over_low else None
        if not high.any() and (low is None or not low.any()):
            return grid
        cells = np.where(high, np.int8(OCCUPIED), grid.cells)
        if low is not None:
            cells[low] = FREE
        return OccupancyGrid(cells, grid.resolution, grid.origin)

    def _low(self, grid: OccupancyGrid, occupied_threshold: int, high: Mask) -> Mask:
        """Find obstacles of the map that are low."""
        occupied = grid.occupied(occupied_threshold)
        doubtful = high | cells_touched(self.heights, np.isnan(self.heights.heights), grid)
        rows, columns = np.nonzero(occupied)
        centers = np.column_stack((columns, rows)).astype(np.float64) + 0.5
        x, y = grid.map_to_world(centers).T
        # The box around a cell and the cells around it.
        yaw = grid.origin.yaw
        reach = (1.5 - _EPSILON) * grid.resolution * (abs(math.cos(yaw)) + abs(math.sin(yaw)))
        x_min, y_min, x_max, y_max = self.heights.bounds
        beyond = (x - reach < x_min) | (x + reach > x_max)
        beyond |= (y - reach < y_min) | (y + reach > y_max)
        doubtful = np.asarray(ndimage.binary_dilation(doubtful, _AROUND))
        doubtful[rows[beyond], columns[beyond]] = True
        labels, count = ndimage.label(occupied, _AROUND)
        is_low = np.ones(count + 1, dtype=bool)
        is_low[0] = False
        is_low[labels[doubtful]] = False
        return np.asarray(is_low[labels])
