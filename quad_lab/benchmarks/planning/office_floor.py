"""
A large floor of offices for benchmarks, drawn from a seed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.planar_pose import Pose2D

Mask = NDArray[np.bool_]

_RESOLUTION = 0.05
"""[m]"""
_WALL = 3
"""Thickness of a wall [cells]."""


def office_floor(rooms: int = 20, pitch: int = 100, seed: int = 0) -> OccupancyGrid:
    """
    Draw rooms along corridors, with doors and furniture.

    Each pair of rows of rooms has a corridor between, and two more join these at both sides.
    Every room has a door to its corridor, every third another to the room beside it, and two in
    three have desks and a pillar.

    Parameters
    ----------
    rooms : int
        Number of rows of rooms, and of rooms to a row, an even number.
    pitch : int
        Distance from row to row [cells].
    seed : int
        Seed of doors and furniture.

    Returns
    -------
    OccupancyGrid
        A map of rooms x rooms rooms.
    """
    rng = np.random.default_rng(seed)
    size = rooms * pitch
    corridor = 2 * (pitch // 5)
    depth, width = pitch - corridor // 2, (size - 2 * corridor) // rooms
    occupied = np.zeros((size, size), dtype=np.bool_)
    for row in range(rooms):
        # The corridor is above the even rows and below the odd ones.
        bottom = row * pitch + (corridor // 2 if row % 2 else 0)
        for column in range(rooms):
            left = corridor + column * width
            room = occupied[bottom : bottom + depth, left : left + width]
            room[:_WALL] = room[-_WALL:] = room[:, :_WALL] = room[:, -_WALL:] = True
            if rng.random() < 2.0 / 3.0:
                _furnish(room, rng)
            door, at = int(rng.integers(22, 34)), int(rng.integers(_WALL, width - 34 - _WALL))
            rows = slice(0, _WALL) if row % 2 else slice(-_WALL, None)
            room[rows, at : at + door] = False
            if column and rng.random() < 1.0 / 3.0:
                y = bottom + int(rng.integers(10, pitch // 2))
                occupied[y : y + 24, left - _WALL : left + _WALL] = False
    for edge in (occupied, occupied.T):
        edge[:_WALL] = edge[-_WALL:] = True
    cells = np.where(occupied, OCCUPIED, 0).astype(np.int8)
    return OccupancyGrid(cells, _RESOLUTION, Pose2D(0.0, 0.0, 0.0))


def _furnish(room: Mask, rng: np.random.Generator) -> None:
    """Put desks along the walls of a room, and a round pillar."""
    height, width = room.shape
    for _ in range(int(rng.integers(1, 4))):
        x, y = (int(rng.integers(_WALL, side - 24)) for side in (width, height))
        room[y : y + 8, x : x + 16] = True
    rows, columns = np.ogrid[:height, :width]
    center_x, center_y = (float(rng.uniform(20.0, side - 20.0)) for side in (width, height))
    room |= (columns - center_x) ** 2 + (rows - center_y) ** 2 <= float(rng.uniform(3.0, 7.0)) ** 2
