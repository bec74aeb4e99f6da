"""
Steps that are too high, and slopes that are too steep, found in a height map.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_planner.grid.array_types import Mask
from quad_planner.grid.cell_overlap import EPSILON
from quad_planner.grid.ground_limits import GroundLimits

Floats = NDArray[np.float64]


_DIRECTIONS = ((1, 0), (0, 1), (1, 1), (1, -1))
"""Directions in which heights are compared: columns and rows."""


_PARTS = 8
"""The length over which slopes are averaged has so many parts at least, if cells allow it."""


_LEAST_KNOWN = 0.75
"""Part of a slope's surroundings that must be known."""


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
        Limits of the robot.

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
        farthest = max(1, math.floor(limits.step_length / (length * side) + EPSILON))
        for count in range(1, farthest + 1):
            dx, dy = count * along_x, count * along_y
            if abs(dx) >= heights.columns or abs(dy) >= heights.rows:
                break
            here, there = _shifted(z, dx, dy)
            most = limits.step_height + rise * (count * length - 1.0)
            # Heights were rounded when they were sent.
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
        Limits of the robot.

    Returns
    -------
    ndarray of bool, shape (rows, columns)
        True where the plane rises by more than the largest slope.
    """
    return steep_slopes_beside(heights, limits, high_steps(heights, limits))


def steep_slopes_beside(heights: HeightMap, limits: GroundLimits, steps: Mask) -> Mask:
    """Find ground that is too steep, apart from steps, shape (rows, columns)."""
    # Imported late, as only a height map needs it: it takes a good part of a node's start.
    from scipy import ndimage

    blocks = _blocks(heights, limits.slope_length)
    gradient = _planes(blocks).rise
    steep = gradient > math.tan(limits.largest_slope) + 1e-9
    if steep.any() and steps.any():
        beside = _block_sums(steps.astype(float), blocks.factor) > 0.0
        steep &= ~ndimage.maximum_filter(beside, size=2 * blocks.reach + 1, mode='constant')
    return np.asarray(_spread(steep, blocks.factor, heights) & ~np.isnan(heights.heights))


def fitted_planes(heights: HeightMap, length: float) -> tuple[Floats, Floats]:
    """
    Fit planes to the ground, as :func:`steep_slopes` does.

    Parameters
    ----------
    heights : HeightMap
        The ground.
    length : float
        Side of the square to which a plane is fitted [m].

    Returns
    -------
    tuple of ndarray, shape (rows, columns)
        Rise per distance up the plane, and how far the heights are off it, root mean square [m];
        NaN where too little is known.
    """
    blocks = _blocks(heights, length)
    planes = _planes(blocks)
    # Imported late, as only a height map needs it: it takes a good part of a node's start.
    from scipy import ndimage

    # Of the squares of heights the plane leaves what it does not explain.
    around = np.ones(2 * blocks.reach + 1)
    total = blocks.weight * blocks.square
    for axis in (0, 1):
        total = ndimage.correlate1d(total, around, axis=axis, mode='constant')
    # A plane also rises within blocks: so do squares of n by n points.
    inside = planes.rise**2 * (blocks.side**2 - heights.resolution**2) / 12.0
    left = total / planes.number - planes.mean**2 - planes.explained - inside
    rise, off = (
        _spread(np.where(planes.is_known, found, np.nan), blocks.factor, heights)
        for found in (planes.rise, np.sqrt(np.maximum(left, 0.0)))
    )
    return rise, off


class _Blocks(NamedTuple):
    """Heights of a map by blocks of cells, shape (rows, columns) each."""

    weight: Floats
    """Weights from 0 (unknown) to 1."""
    value: Floats
    """Mean heights, about that of the map [m]."""
    square: Floats
    """Mean squares of those heights [m^2]."""
    side: float
    """Side of a block [m]."""
    reach: int
    """A plane is fitted to so many blocks to each side."""
    factor: int
    """Cells along the side of a block."""


class _Planes(NamedTuple):
    """Planes around blocks, shape (rows, columns) each."""

    is_known: Mask
    """Where enough is known."""
    number: Floats
    """Number of blocks that are known, 1 where too few are."""
    mean: Floats
    """Mean heights [m]."""
    rise: Floats
    """Rise per distance up the plane; 0 where too little is known."""
    explained: Floats
    """Variance of the plane's own heights [m^2]."""


def _spread(values: NDArray[Any], factor: int, heights: HeightMap) -> NDArray[Any]:
    """Give the values of blocks to their cells."""
    rows, columns = heights.heights.shape
    return np.repeat(np.repeat(values, factor, axis=0), factor, axis=1)[:rows, :columns]


def _blocks(heights: HeightMap, length: float) -> _Blocks:
    """Average heights over blocks that are a small part of a length [m]."""
    z = heights.heights
    # Slopes over a length look the same on cells that are a small part of it.
    factor = max(1, math.floor(length / _PARTS / heights.resolution + EPSILON))
    known = ~np.isnan(z)
    count = _block_sums(known.astype(float), factor)
    # About a height of the map itself, so that squares of large numbers are not subtracted.
    level = float(z[known].mean()) if known.any() else 0.0
    about = np.where(known, z - level, 0.0)
    total, squares = _block_sums(about, factor), _block_sums(about**2, factor)
    value, square = (
        np.where(count > 0.0, sums / np.maximum(count, 1.0), 0.0) for sums in (total, squares)
    )
    side = factor * heights.resolution
    reach = max(1, math.ceil((length / side - 1.0) / 2.0 - EPSILON))
    return _Blocks(count / factor**2, value, square, side, reach, factor)


def _planes(blocks: _Blocks) -> _Planes:
    """Fit planes to the squares around blocks."""
    weight, value, _, side, reach, _ = blocks
    u = np.arange(-reach, reach + 1) * side
    powers = (np.ones_like(u), u, u**2)

    from scipy import ndimage

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
    along_x, along_y = yy * xz - xy * yz, xx * yz - xy * xz
    slopes = np.hypot(along_x, along_y) / area
    explained = (along_x * xz + along_y * yz) / area
    return _Planes(is_enough, n, z, np.where(is_enough, slopes, 0.0), explained)


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
