"""
Steps that are too high, and slopes that are too steep, found in a height map.
"""

from __future__ import annotations

import math

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

    length, z = limits.slope_length, heights.heights
    # Slopes over a length look the same on cells that are a small part of it.
    factor = max(1, math.floor(length / _PARTS / heights.resolution + EPSILON))
    known = ~np.isnan(z)
    count = _block_sums(known.astype(float), factor)
    # About a height of the map itself, so that squares of large numbers are not subtracted.
    level = float(z[known].mean()) if known.any() else 0.0
    total = _block_sums(np.where(known, z - level, 0.0), factor)
    weight = count / factor**2
    value = np.where(count > 0.0, total / np.maximum(count, 1.0), 0.0)
    side = factor * heights.resolution
    reach = max(1, math.ceil((length / side - 1.0) / 2.0 - EPSILON))
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
        Weights from 0 (unknown) to 1.
    value : ndarray, shape (rows, columns)
        Heights [m].
    side : float
        Side of a cell [m].
    reach : int
        The square goes so many cells to each side.

    Returns
    -------
    ndarray, shape (rows, columns)
        Rise per distance up the plane; 0 where too little is known.
    """
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
