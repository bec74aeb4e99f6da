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
from quad_planner.footing.stances import Footholds, find_nearest

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

BINS = 12
"""Number of headings for which shins are looked at, of 30 degrees each."""

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
    x, y = (c + (np.arange(n) + 0.5) * side for c, n in ((x0, columns), (y0, rows)))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    height = heights.height_at(points)
    unknown = np.isnan(height)
    images = FootholdImages(robot, criterion, heights)
    is_even, is_free = _by_any_shin(images, shins[0], heights, points)
    doubtful = np.flatnonzero(is_even & ~is_free & ~unknown)
    offsets = _offsets(robot.relative_size * criterion.reach / side)
    nearest = np.empty((BINS, len(robot.legs), rows, columns), dtype=np.int32)
    fit = unknown | (is_even & is_free)
    for bin_ in range(BINS):
        for leg in range(len(robot.legs)):
            if not len(doubtful) and (bin_, leg) != (0, 0):
                nearest[bin_, leg] = nearest[0, 0]
                continue
            if len(doubtful):
                fit[doubtful] = images.is_fit_beside(shins[bin_][leg], points[doubtful])
            find_nearest(fit.reshape(rows, columns), offsets, nearest[bin_, leg])
    return Footholds(nearest, height.reshape(rows, columns), x0, y0, side)


def _by_any_shin(
    images: FootholdImages, shins: list[Array], heights: HeightMap, points: Array
) -> tuple[Mask, Mask]:
    """Tell where the ground is even, and where no shin can be in anything's way, (n,) each."""
    # Imported late, as only a height map needs it: it takes a good part of a node's start.
    import cv2

    far = max(float(np.hypot(*shin[:, :2].T).max()) for shin in shins) + images.room
    lowest_point = min(float(shin[:, 2].min()) for shin in shins)
    column, row = np.floor((points - heights.origin) / heights.resolution).astype(int).T
    own, step, _, lowest = images.images
    here = own[row, column]
    is_even = (step[row, column] <= images.largest_step) & (
        here - lowest[row, column] <= lowest_point
    )
    size = 2 * math.ceil(far / heights.resolution) + 1
    known = np.nan_to_num(own, nan=-1e9).astype(np.float32)
    highest = cv2.dilate(known, np.ones((size, size), dtype=np.uint8))
    is_free = highest[row, column] < here + lowest_point - 1e-4
    return is_even, is_free


def _offsets(reach: float) -> NDArray[np.int64]:
    """Return rows and columns of the places within reach [places], the nearest first, (m, 2)."""
    # Half a place: what is within reach is not missed by the lattice.
    side = np.arange(-math.ceil(reach + 0.5), math.ceil(reach + 0.5) + 1)
    around = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
    away = np.hypot(*around.T)
    order = np.argsort(away, kind='stable')
    return np.ascontiguousarray(around[order][away[order] <= reach + 0.5]).astype(np.int64)
