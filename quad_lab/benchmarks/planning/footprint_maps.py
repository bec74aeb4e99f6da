"""
Offices with doors of all widths, and everything that brute force reaches on them.
"""

from __future__ import annotations

from itertools import pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, compiled_part
from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.outline.heading_kernels import CLASSES, Kernels
from quad_planner.outline.heading_moves import Moves

Mask = NDArray[np.bool_]
Integers = NDArray[np.int64]

_ROOM_SIZES = (2.2, 4.5)
"""Least and largest side of a room [m]."""
_DOORS = (0.5, 1.2)
"""Least and largest width of a door [m]."""
_WITHOUT_DOOR = 0.25
"""Fraction of walls between two rooms that have no door."""
_WALL = 0.1
"""Thickness of a wall [m]."""
_PASSAGE = 0.65
"""Width of a passage in whose corner A1 fits along either part, and cannot turn between [m]."""


def office(size: int, resolution: float, rng: np.random.Generator) -> OccupancyGrid:
    """
    Draw rooms with doors between them, and a table in some.

    Parameters
    ----------
    size : int
        Cells along each side.
    resolution : float
        Side of a cell [m].
    rng : Generator
        Source of what is drawn at random.

    Returns
    -------
    OccupancyGrid
        The office, in a wall.
    """
    wall = max(1, round(_WALL / resolution))
    lines = []
    for _ in range(2):
        edges = [0]
        while size - edges[-1] > 2.0 * _ROOM_SIZES[0] / resolution:
            edges.append(edges[-1] + round(rng.uniform(*_ROOM_SIZES) / resolution))
            if size - edges[-1] < _ROOM_SIZES[0] / resolution:
                edges.pop()
                break
        lines.append([*edges, size - wall])
    cells = np.zeros((size, size), dtype=np.int8)
    for at, edges in enumerate(lines):
        rows = cells if at == 0 else cells.T
        for edge in edges:
            rows[edge : edge + wall] = OCCUPIED
    for at, (edges, others) in enumerate((lines, lines[::-1])):
        rows = cells if at == 0 else cells.T
        for edge in edges[1:-1]:
            for low, high in pairwise(others):
                width = round(rng.uniform(*_DOORS) / resolution)
                first = int(rng.integers(low + 2 * wall, max(high - width - wall, low + 3 * wall)))
                if rng.random() > _WITHOUT_DOOR:
                    rows[edge : edge + wall, first : min(first + width, high)] = 0
    for low, high in pairwise(lines[0]):
        for left, right in pairwise(lines[1]):
            if rng.random() < 0.4:
                y, x = rng.integers((low, left), (high, right))
                table = rng.integers(6, 20, 2) * 0.05 / resolution
                cells[y : y + int(table[0]), x : x + int(table[1])] = OCCUPIED
    return OccupancyGrid(cells, resolution, Pose2D(0.0, 0.0, 0.0))


def free_classes(blocked: Mask, circle_free: Mask, kernels: Kernels) -> NDArray[np.uint8]:
    """
    Lay each class's kernel on every cell.

    Parameters
    ----------
    blocked : ndarray of bool, shape (height, width)
        Cells of obstacles.
    circle_free : ndarray of bool, shape (height, width)
        Where the circle fits.
    kernels : Kernels
        Cells that the outline reaches.

    Returns
    -------
    ndarray of uint8, shape (72, height, width)
        1 where the robot fits.
    """
    side = 2 * kernels.rows + 1
    columns = np.arange(side) - kernels.rows
    image = blocked.astype(np.uint8)
    free = np.empty((CLASSES, *blocked.shape), dtype=np.uint8)
    for k in range(CLASSES):
        reach = (columns >= kernels.low[k][:, None]) & (columns <= kernels.high[k][:, None])
        hit = cv2.dilate(
            image, reach.astype(np.uint8), borderType=cv2.BORDER_CONSTANT, borderValue=0
        )
        free[k] = (hit == 0) | circle_free
    return free


def reachable(
    free: NDArray[np.uint8], moves: Moves, start: tuple[int, int, int]
) -> NDArray[np.uint8]:
    """
    Reach all cells and headings from one.

    Parameters
    ----------
    free : ndarray of uint8, shape (72, height, width)
        1 where the robot fits.
    moves : Moves
        Straight moves of each heading.
    start : tuple of int
        Class of the heading, row and column.

    Returns
    -------
    ndarray of uint8, shape (72, height, width)
        1 for the headings in which it can come to a cell and stand there.
    """
    states = np.zeros_like(free)
    waiting = np.empty(free.size, dtype=np.int64)
    ends = np.zeros_like(free)
    _flood(free, moves, *start, states, waiting, ends)
    return ends


def office_with_closets(
    size: int, resolution: float, rng: np.random.Generator
) -> tuple[OccupancyGrid, list[tuple[int, int]]]:
    """
    Draw an office beside closets, each behind a passage with a corner too narrow for a turn.

    Parameters
    ----------
    size, resolution, rng
        As for :func:`office`.

    Returns
    -------
    tuple
        The office, and a cell within each closet, x and y.
    """
    grid = office(size, resolution, rng)
    cells = grid.cells.copy()
    width, long, depth = (round(length / resolution) for length in (_PASSAGE, 2.0, 6.0))
    edge = size - depth
    cells[:, edge:] = OCCUPIED
    closets = []
    for y in range(long, size - 3 * long, 2 * long):
        # Where a wall of the office is in front, no passage begins.
        if (cells[y : y + width, edge - width : edge] != 0).any():
            continue
        corner = edge + long
        cells[y : y + width, edge:corner] = 0
        cells[y : y + long, corner - width : corner] = 0
        cells[y + long - width : y + long + width, corner - width : corner + long] = 0
        closets.append((corner + long // 2, y + long))
    return OccupancyGrid(cells, resolution, grid.origin), closets


@compiled
def _flood(
    free: NDArray[np.uint8],
    moves: Moves,
    k: int,
    y: int,
    x: int,
    states: NDArray[np.uint8],
    waiting: Integers,
    ends: NDArray[np.uint8],
) -> None:
    """Go on from every state, the last first, as long as there is one."""
    _, height, width = free.shape
    states[k, y, x] = 1
    waiting[0] = (k * height + y) * width + x
    count = 1
    while count:
        count -= 1
        state = waiting[count]
        k, y, x = state // (height * width), state // width % height, state % width
        every = True
        for j in range(CLASSES):
            every = every and free[j, y, x] == 1
        # All headings of a cell lead on as one does if all fit.
        if every and ends[k, y, x] and states[(k + 1) % CLASSES, y, x] == 2:
            continue
        for turn in range(-CLASSES // 2, CLASSES // 2):
            j = (k + turn) % CLASSES
            if not every and not _may_turn(free, x, y, k, turn):
                continue
            ends[j, y, x] = 1
            if every:
                states[j, y, x] = 2
            if not every and 0 < abs(turn) <= 3:
                # As small a turn is made while walking.
                continue
            if not _may_go(free, moves, x, y, j):
                continue
            to_x, to_y = x + moves.x[j], y + moves.y[j]
            if states[j, to_y, to_x] == 0:
                states[j, to_y, to_x] = 1
                waiting[count] = (j * height + to_y) * width + to_x
                count += 1


@compiled_part
def _may_turn(free: NDArray[np.uint8], x: int, y: int, k: int, turn: int) -> bool:
    if abs(turn) >= 34:
        return False
    side = 1 if turn > 0 else -1
    fits = True
    for step in range(abs(turn) + 1):
        fits = fits and free[(k + side * step) % CLASSES, y, x] == 1
    return fits


@compiled_part
def _may_go(free: NDArray[np.uint8], moves: Moves, x: int, y: int, j: int) -> bool:
    _, height, width = free.shape
    for at in range(moves.begins[j], moves.begins[j + 1]):
        to_x, to_y = x + moves.touched[at, 0], y + moves.touched[at, 1]
        if to_x < 0 or to_y < 0 or to_x >= width or to_y >= height or not free[j, to_y, to_x]:
            return False
    return True
