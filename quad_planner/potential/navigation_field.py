"""
A navigation function on a map: a potential whose only minimum is the goal.

It is the time of travel to the goal, T with |grad T| = slowness (the eikonal equation),
at a speed that grows with the distance to obstacles: fast marching squared (Garrido,
Moreno, Abderrahim and Martin: Path Planning for Mobile Robot Navigation using Voronoi
Diagram and Fast Marching, IROS 2006). Each cell that is reached has a neighbour of a
smaller time, so that a descent ends at the goal from wherever there is a path.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_common.errors import ParameterError
from quad_planner.grid.array_types import Mask, Points
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.grid.bucket_queue import (
    bucket_queue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    push,
    with_room,
)
from quad_planner.grid.line_of_sight import sees

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]

_EXPANSIONS = 65536
"""Number of expansions between two calls of `check`."""

_MOST_BUCKETS = 2.0**16
"""Largest number of buckets: where some cells are very slow they are wider, which takes longer."""

_BETTER = 1.0 - 1e-12
"""A time counts as smaller when it is by more than rounding."""

_STEP = 0.5
"""Length of a step of the descent [cells]."""

_PATIENCE = 8
"""Number of steps to no earlier cell after which the descent goes from cell to cell."""

# What is kept of a descent between two calls, in one array.
_X, _Y, _EARLIEST, _IDLE = range(4)


def slowness_near_obstacles(distances: Floats, forbidden: Mask, influence: float) -> Floats:
    """
    Make the slowness that leads around obstacles, with 1 where they are far.

    Parameters
    ----------
    distances : ndarray, shape (height, width)
        Distance from each cell to the safety boundary, above 0 where the robot may be [m].
    forbidden : ndarray of bool, shape (height, width)
        True where the robot must not be.
    influence : float
        Farther away than this the speed does not grow, > 0 [m].

    Returns
    -------
    ndarray, shape (height, width)
        Factors of at least 1, infinite where the robot must not be.
    """
    slowness = np.full(distances.shape, np.inf)
    np.divide(influence, distances, out=slowness, where=~forbidden)
    np.maximum(slowness, 1.0, out=slowness)
    return slowness


def travel_times(
    slowness: Floats,
    goal: tuple[int, int],
    until: tuple[int, int] | None = None,
    check: Callable[[], None] = lambda: None,
) -> Floats:
    """
    Solve the eikonal equation |grad T| = slowness, by first-order upwind differences.

    Parameters
    ----------
    slowness : ndarray, shape (height, width)
        Time to cross a cell, at least 1; infinite where one must not be.
    goal : tuple of int
        x and y of the cell where T is 0.
    until : tuple of int, optional
        A cell at whose time the others may end: those that are later need not be right.
    check : callable
        Called again and again; raises to end it.

    Returns
    -------
    ndarray, shape (height, width)
        T; infinite where no path leads over the sides of cells.

    Raises
    ------
    ParameterError
        If a slowness is below 1 or no number, or a cell is not on the map.
    """
    height, width = slowness.shape
    if not (slowness >= 1.0).all():
        raise ParameterError('slowness', float(slowness.min()), 'at least 1 in every cell')
    for name, cell in (('goal', goal), ('until', until or goal)):
        if not (0 <= cell[0] < width and 0 <= cell[1] < height):
            raise ParameterError(name, cell, f'a cell of a map of {width} x {height} cells')
    walled = np.full((height + 2, width + 2), np.inf)
    walled[1:-1, 1:-1] = slowness
    times = np.full_like(walled, np.inf)
    if np.isfinite(slowness[goal[1], goal[0]]):
        places = [(y + 1) * (width + 2) + x + 1 for x, y in (goal, until or goal)]
        _march(walled, times, places[0], places[1] if until else -1, check)
    return times[1:-1, 1:-1]


def _march(
    slowness: Floats, times: Floats, goal: int, until: int, check: Callable[[], None]
) -> None:
    """Fill in the times; both arrays have a wall around them."""
    slowest = float(slowness[np.isfinite(slowness)].max())
    # A time is later than the one that it follows from by this at least: s / sqrt 2.
    bucket_width = max(math.sqrt(0.5), slowest / _MOST_BUCKETS)
    queue = bucket_queue(int(slowest / bucket_width) + 2)
    flat, flat_times = slowness.reshape(-1), times.reshape(-1)
    flat_times[goal] = 0.0
    push(*queue, goal, 0, 0)
    while True:
        queue = with_room(queue, 4)
        is_done = _expand(
            flat, flat_times, slowness.shape[1], 1.0 / bucket_width, until, *queue, _EXPANSIONS
        )
        check()
        if is_done:
            return


@compiled_loop
def _expand(
    slowness: Floats,
    times: Floats,
    width: int,
    buckets_per_time: float,
    until: int,
    heads: Integers,
    entries: Integers,
    state: Integers,
    most: int,
) -> bool:
    """
    Go on from cells that wait, the earliest first, by the width of a bucket.

    Returns whether all is done; else `most` cells are, or there is no more room.
    """
    for _ in range(most):
        if is_empty(state):
            return True
        if not has_room(entries, state, 4):
            return False
        bucket = next_bucket(heads, state)
        if until >= 0 and times[until] * buckets_per_time < bucket:
            return True
        cell, key = pop(heads, entries, state)
        if int(times[cell] * buckets_per_time) != key:
            # An earlier time was found: that one waits too.
            continue
        for offset in (1, -1, width, -width):
            beside = cell + offset
            slow = slowness[beside]
            if slow == np.inf or times[beside] <= times[cell]:
                continue
            time = _upwind(
                min(times[beside - 1], times[beside + 1]),
                min(times[beside - width], times[beside + width]),
                slow,
            )
            if time < times[beside] * _BETTER:
                times[beside] = time
                key = int(time * buckets_per_time)
                push(heads, entries, state, beside, key, key)
    return False


@compiled_part
def _upwind(a: float, b: float, slow: float) -> float:
    """Return T with max(T - a, 0)^2 + max(T - b, 0)^2 = slow^2, a and b the neighbours' T."""
    low, high = min(a, b), max(a, b)
    if high - low >= slow:
        return low + slow
    return float(0.5 * (low + high + np.sqrt(2.0 * slow * slow - (high - low) ** 2)))


def descend_times(
    times: Floats,
    forbidden: BitMask,
    start: Points,
    goal: tuple[int, int],
    check: Callable[[], None] = lambda: None,
) -> Points:
    """
    Follow the falling gradient of T to the goal's cell, in steps of half a cell.

    Where that leads no farther, for the gradient is not that of a smooth function, it goes
    on over centers of cells, each of a smaller time than the one before. So it arrives.

    Parameters
    ----------
    times : ndarray, shape (height, width)
        Times by :func:`travel_times`.
    forbidden : BitMask
        Cells that a path must not enter: those of infinite slowness.
    start : ndarray, shape (2,)
        Point in a cell that is reached [cells].
    goal : tuple of int
        x and y of the goal's cell.
    check : callable
        Called again and again; raises to end the descent.

    Returns
    -------
    ndarray, shape (n, 2)
        Points from the start to one in the goal's cell [cells].

    Raises
    ------
    ParameterError
        If no path leads from the start.
    """
    height, width = times.shape
    x, y = min(math.floor(start[0]), width - 1), min(math.floor(start[1]), height - 1)
    if not (x >= 0 and y >= 0 and np.isfinite(times[y, x])):
        raise ParameterError('start', tuple(start), 'in a cell from which a path leads to the goal')
    state = np.array([start[0], start[1], times[y, x], 0.0])
    parts = [np.array([start], dtype=np.float64)]
    points = np.empty((4096, 2))
    while True:
        count, is_done = _descend(times, forbidden.words, goal[0], goal[1], state, points)
        parts.append(points[:count].copy())
        check()
        if is_done:
            return np.concatenate(parts)


@compiled_loop
def _descend(
    times: Floats, forbidden: Bits, goal_x: int, goal_y: int, state: Floats, points: Points
) -> tuple[int, bool]:
    """Fill in points; return how many there are, and whether the last is at the goal."""
    height, width = times.shape
    for count in range(len(points)):
        x, y = state[_X], state[_Y]
        cell_x, cell_y = min(int(x), width - 1), min(int(y), height - 1)
        if cell_x == goal_x and cell_y == goal_y:
            return count, True
        new_x, new_y = x, y
        if state[_IDLE] < _PATIENCE:
            new_x, new_y = _gradient_step(times, forbidden, x, y)
        if new_x == x and new_y == y:
            new_x, new_y = _earlier_center(times, cell_x, cell_y)
            state[_IDLE] = _PATIENCE
        state[_X], state[_Y] = new_x, new_y
        points[count] = new_x, new_y
        reached = times[min(int(new_y), height - 1), min(int(new_x), width - 1)]
        if reached < state[_EARLIEST]:
            state[_EARLIEST] = reached
            state[_IDLE] = 0.0
        else:
            state[_IDLE] += 1.0
    return len(points), False


@compiled_part
def _gradient_step(times: Floats, forbidden: Bits, x: float, y: float) -> tuple[float, float]:
    """Return the point a step down the gradient, or the same point if one must not be there."""
    height, width = times.shape
    left, below = int(np.floor(x - 0.5)), int(np.floor(y - 0.5))
    down_x = down_y = 0.0
    for row in range(max(below, 0), min(below + 2, height)):
        for column in range(max(left, 0), min(left + 2, width)):
            if times[row, column] < np.inf:
                weight = (1.0 - abs(x - column - 0.5)) * (1.0 - abs(y - row - 0.5))
                slope_x, slope_y = _slope(times, column, row)
                down_x -= weight * slope_x
                down_y -= weight * slope_y
    size = np.hypot(down_x, down_y)
    if size < 1e-9:
        return x, y
    new_x, new_y = x + _STEP * down_x / size, y + _STEP * down_y / size
    if not (0.0 <= new_x <= width and 0.0 <= new_y <= height):
        return x, y
    return (new_x, new_y) if sees(forbidden, width, x, y, new_x, new_y) else (x, y)


@compiled_part
def _slope(times: Floats, x: int, y: int) -> tuple[float, float]:
    """Return the upwind gradient of T at a cell's center, towards what is later."""
    height, width = times.shape
    here = times[y, x]
    west = times[y, x - 1] if x > 0 else np.inf
    east = times[y, x + 1] if x + 1 < width else np.inf
    south = times[y - 1, x] if y > 0 else np.inf
    north = times[y + 1, x] if y + 1 < height else np.inf
    along = max(here - min(west, east), 0.0)
    across = max(here - min(south, north), 0.0)
    return (along if west <= east else -along), (across if south <= north else -across)


@compiled_part
def _earlier_center(times: Floats, x: int, y: int) -> tuple[float, float]:
    """Return the center of the earliest neighbour, with no corner cut."""
    height, width = times.shape
    best_x, best_y = x, y
    for row in range(max(y - 1, 0), min(y + 2, height)):
        for column in range(max(x - 1, 0), min(x + 2, width)):
            cuts = times[y, column] == np.inf or times[row, x] == np.inf
            if not cuts and times[row, column] < times[best_y, best_x]:
                best_x, best_y = column, row
    return best_x + 0.5, best_y + 0.5
