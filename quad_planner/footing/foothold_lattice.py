"""
The footholds nearest to the places of a lattice, for all legs and some headings.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.footing.foothold_criterion import (
    FootholdCriterion,
    FootholdImages,
    standing_shin,
)
from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_planner.footing.nearest_footholds import find_free, find_nearest, sample_heights
from quad_planner.footing.stances import Footholds

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BINS = 12
"""Number of headings for which shins are looked at, of 30 degrees each; with four legs each they
are the bits of a word."""

_SIDE = 0.03
"""Distance between the places of the lattice, unless cells are larger [m, of TITAN-VIII]."""


def lattice_side(robot: Robot, heights: HeightMap) -> float:
    """Return the distance between places: a whole number of cells of the height map [m]."""
    side = robot.relative_size * _SIDE
    every = max(1, math.floor(side / heights.resolution + 1e-9))
    # Not larger than the map, which has one place at least.
    return min(every, heights.rows, heights.columns) * heights.resolution


def lattice_shape(robot: Robot, heights: HeightMap) -> tuple[int, int]:
    """Return the number of rows and of columns of places on a height map."""
    every = round(lattice_side(robot, heights) / heights.resolution)
    return heights.rows // every, heights.columns // every


def shins_of(robot: Robot) -> list[list[Array]]:
    """Return points of each leg's foot and shin, (n, 3) each, for each bin of headings [m]."""
    headings = 2.0 * math.pi / BINS * np.arange(BINS)
    return [[standing_shin(robot, leg, yaw) for leg in range(4)] for yaw in headings]


def footholds(
    robot: Robot, criterion: FootholdCriterion, heights: HeightMap, shins: list[list[Array]]
) -> Footholds:
    """
    Find the nearest foothold to each place.

    Parameters
    ----------
    robot : Robot
        The robot.
    criterion : FootholdCriterion
        Conditions of a foothold.
    heights : HeightMap
        Of the ground.
    shins : list of list of ndarray
        The robot's shins, from :func:`shins_of`.

    Returns
    -------
    Footholds
        On a lattice over all of the map; a cell at its upper border that does not fill a place is
        left out.
    """
    side = lattice_side(robot, heights)
    rows, columns = lattice_shape(robot, heights)
    x0, y0 = heights.origin
    # Of the places, as the height map has it for points.
    x, y = (
        (c + (np.arange(n, dtype=np.float64) + 0.5) * side - c) / heights.resolution
        for c, n in ((x0, columns), (y0, rows))
    )
    height = np.empty((rows, columns))
    sample_heights(heights.heights, x, y, height)
    unknown = np.isnan(height)
    images = FootholdImages(robot, criterion, heights)
    is_even, highest, lowest = _by_any_shin(images, shins, heights, (x, y))
    certain = unknown | (is_even & (highest <= lowest))
    others = np.flatnonzero(~certain)
    doubtful = np.flatnonzero(is_even & ~certain)
    free = np.empty(len(doubtful), dtype=np.uint64)
    cells = np.column_stack((x[doubtful % columns], y[doubtful // columns]))
    points = _sorted(shins, heights.resolution)
    find_free(cells, highest.ravel()[doubtful], images.images, points, free)
    # All legs and headings of a place in the bits of a word.
    fit = np.where(certain, ~np.uint64(0), np.uint64(0))
    fit.ravel()[doubtful] = free
    offsets = _offsets(robot.relative_size * criterion.reach / side)
    nearest = np.empty((len(points), rows, columns), dtype=np.int32)
    nearest[:] = np.arange(rows * columns, dtype=np.int32).reshape(rows, columns)
    find_nearest(fit, others, offsets, nearest)
    by_bins = nearest.reshape(BINS, len(robot.legs), rows, columns)
    return Footholds(by_bins, height, x0, y0, side)


def _by_any_shin(
    images: FootholdImages,
    shins: list[list[Array]],
    heights: HeightMap,
    places: tuple[Array, Array],
) -> tuple[Mask, Array, Array]:
    """
    Look at places in columns and rows [cells] for all shins together.

    Return where the ground is even, the highest ground that any shin could touch, and the lowest
    point of all shins there, shape (rows, columns) each.
    """
    # Imported late, as only a height map needs it: it takes a good part of a node's start.
    import cv2

    points = np.vstack([shin for leg_shins in shins for shin in leg_shins])
    far = float(np.hypot(*points[:, :2].T).max()) + images.room
    lowest_point = float(points[:, 2].min())
    at = np.ix_(*(np.floor(k).astype(int) for k in reversed(places)))
    own, step, _, lowest = images.images
    here = own[at]
    is_even = (step[at] <= images.largest_step) & (here - lowest[at] <= lowest_point)
    size = 2 * math.ceil(far / heights.resolution) + 1
    highest = cv2.dilate(np.nan_to_num(own, nan=-np.inf), np.ones((size, size), dtype=np.uint8))
    return is_even, highest[at], here + lowest_point


def _sorted(shins: list[list[Array]], resolution: float) -> Array:
    """Return points of all shins, the lowest first, shape (bins times legs, n, 3) [cells, m]."""
    every = [shin / (resolution, resolution, 1.0) for of_bin in shins for shin in of_bin]
    points = np.full((len(every), max(map(len, every)), 3), np.inf)
    for k, shin in enumerate(every):
        points[k, : len(shin)] = shin[np.argsort(shin[:, 2], kind='stable')]
    return points


def _offsets(reach: float) -> NDArray[np.int64]:
    """Return rows and columns of the places within reach [places], the nearest first, (m, 2)."""
    # Half a place: what is within reach is not missed by the lattice.
    side = np.arange(-math.ceil(reach + 0.5), math.ceil(reach + 0.5) + 1)
    around = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    away = np.hypot(*around.T)
    order = np.argsort(away, kind='stable')
    return np.ascontiguousarray(around[order][away[order] <= reach + 0.5]).astype(np.int64)
