"""
Maps for several robots: a warehouse with shelves and aisles, and a corridor between two rooms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import OCCUPIED, OCCUPIED_THRESHOLD, OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.grid.inflated_map import InflatedMap

RESOLUTION = 0.05
"""Side of a cell [m]."""

_WALL = 0.1
"""Thickness of the walls [m]."""

_SHELF, _AISLE, _AROUND = 0.6, 1.6, 2.2
"""Width of a shelf, of the aisle between two, and of the free floor around them [m]."""

_SHELVES, _LENGTH, _GAP = 3, 2.4, 1.6
"""Rows of shelves, the length of each of the two shelves in a row, and the gap between them [m]."""


def warehouse() -> tuple[OccupancyGrid, tuple[Pose2D, ...]]:
    """
    Make a warehouse: rows of two shelves each, aisles between them, and floor around.

    Returns
    -------
    grid : OccupancyGrid
        The map.
    corners : tuple of Pose2D
        A place in each corner, counter-clockwise from the lower left one.
    """
    width = 2.0 * _AROUND + 2.0 * _LENGTH + _GAP
    height = 2.0 * _AROUND + _SHELVES * _SHELF + (_SHELVES - 1) * _AISLE
    cells = _room(width, height)
    for row in range(_SHELVES):
        bottom = _AROUND + row * (_SHELF + _AISLE)
        for left in (_AROUND, _AROUND + _LENGTH + _GAP):
            _fill(cells, left, bottom, left + _LENGTH, bottom + _SHELF)
    near = _AROUND / 2.0
    places = (
        (near, near),
        (width - near, near),
        (width - near, height - near),
        (near, height - near),
    )
    corners = tuple(Pose2D(x, y, 0.0) for x, y in places)
    return OccupancyGrid(cells, RESOLUTION, Pose2D(0.0, 0.0, 0.0)), corners


def corridor(length: float = 4.0, width: float = 1.2) -> tuple[OccupancyGrid, Pose2D, Pose2D]:
    """
    Make two rooms that a corridor joins, too narrow for two robots to pass each other.

    Parameters
    ----------
    length, width : float
        Of the corridor [m].

    Returns
    -------
    grid : OccupancyGrid
        The map.
    left, right : Pose2D
        A place in each room, before the corridor.
    """
    room = 3.0
    height, whole = 3.2, 2.0 * room + length
    cells = _room(whole, height)
    for bottom, top in ((0.0, (height - width) / 2.0), ((height + width) / 2.0, height)):
        _fill(cells, room, bottom, room + length, top)
    middle = height / 2.0
    left, right = Pose2D(room / 2.0, middle, 0.0), Pose2D(whole - room / 2.0, middle, np.pi)
    return OccupancyGrid(cells, RESOLUTION, Pose2D(0.0, 0.0, 0.0)), left, right


def _room(width: float, height: float) -> NDArray[np.int8]:
    cells = np.zeros((round(height / RESOLUTION), round(width / RESOLUTION)), dtype=np.int8)
    wall = round(_WALL / RESOLUTION)
    cells[:wall], cells[-wall:], cells[:, :wall], cells[:, -wall:] = (OCCUPIED,) * 4
    return cells


def _fill(cells: NDArray[np.int8], left: float, bottom: float, right: float, top: float) -> None:
    first, last = round(bottom / RESOLUTION), round(top / RESOLUTION)
    cells[first:last, round(left / RESOLUTION) : round(right / RESOLUTION)] = OCCUPIED


def spread_places(grid: OccupancyGrid, clearance: float, count: int) -> list[Pose2D]:
    """
    Choose places on a map that are far from one another.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.
    clearance : float
        Distance of each place from every obstacle [m].
    count : int
        Number of places.

    Returns
    -------
    list of Pose2D
        The free place nearest to the map's lower left corner, and then again and again the one that
        is farthest from those before.

    Raises
    ------
    ParameterError
        If there is no room for so many.
    """
    prepared = InflatedMap.of(grid, clearance, OCCUPIED_THRESHOLD, unknown_is_free=False)
    rows, columns = np.nonzero(prepared.allowed)
    centers = grid.map_to_world(np.column_stack([columns, rows]).astype(float) + 0.5)
    places: list[NDArray[np.float64]] = []
    apart = -np.linalg.norm(centers - grid.map_to_world(np.zeros(2)), axis=1)
    for _ in range(count):
        if not apart.size or (places and apart.max() < 2.0 * clearance):
            raise ParameterError('robots', count, f'at most {len(places)} on this map')
        places.append(centers[int(np.argmax(apart))])
        away = np.linalg.norm(centers - places[-1], axis=1)
        apart = away if len(places) == 1 else np.minimum(apart, away)
    return [Pose2D(round(x, 3), round(y, 3), 0.0) for x, y in np.array(places).tolist()]
