"""
Shortest paths over a mesh, with the fewest turns of all that are as short (S0 eq. 4).

    L_k(s, v) = min { L_{k-1}(s, v); L_{k-1}(s, u) + w(u, v) }

with s the source, u the vertex visited last, w(u, v) >= 0 the cost of the edge, and L_k(s, v) the
least cost known after visit k: Dijkstra's algorithm. A vertex is a crossing and the bearing on
which it was reached, and w is a length first, then a turn.

Most vertices are on no shortest path, so it goes over the mesh twice. First back from the goal
over crossings alone, for lengths: A*, until each crossing of every shortest path has its length
to the goal. Then from the start, as above, but only where the length so far and the length left
make the least one. Lengths are whole numbers, so they are compared exactly, and the path is the
one that Dijkstra's algorithm finds on the whole graph: of equal costs the vertex that waited
first is visited first.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part, inlined_part
from quad_planner.grid.bucket_queue import (
    BucketQueue,
    bucket_queue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    push,
)
from quad_planner.search.cell_steps import DX, DY
from quad_planner.search.search_loop import DONE, FULL, PAUSED, path_back, run_search

Integers = NDArray[np.int64]

CIRCLE = 6400
"""Bearings are whole numbers: parts of a circle that 8 divides."""

_HEADINGS = 8
_BEARINGS = 9
"""Ways in which a crossing is reached: along the mesh in eight directions, or from the start."""

_AT_A_TIME = 50_000
"""Number of visits between two calls of `check`."""

_ROOM_AT_FIRST = 8192
"""States for which there is room to wait at first."""

_START, _NO_ROOM = -1, -2

_FAR = 2**62
"""Length that no path has."""

_UNIT = 2**20
"""A cost is a length times this, plus the number of turns: turns decide among equal lengths."""


class Mesh(NamedTuple):
    """The moves that are free on a mesh, and what they cost."""

    exits: NDArray[np.uint8]
    """Free moves of each crossing: bit k for k times 45 degrees, shape (rows, columns)."""
    straight: int
    """Length of a move along a line of the mesh."""
    diagonal: int
    """Length of a move across."""


class Legs(NamedTuple):
    """Segments that join the start, or the goal, to crossings; in the order of their numbers."""

    crossings: Integers
    """Numbers of the crossings, row after row, shape (n,)."""
    lengths: Integers
    """Length of each, shape (n,)."""
    bearings: Integers
    """Bearing along each, -1 for one of no length; shape (n,)."""


class Ends(NamedTuple):
    """Start and goal of a search."""

    starts: Legs
    """Segments from the start."""
    goals: Legs
    """Segments to the goal."""
    direct: int
    """Length of the segment from the start to the goal, -1 if it is not free."""
    direct_bearing: int
    """Bearing along it, -1 if it has no length."""
    bearings: tuple[int, int]
    """Bearing of the robot at the start, and of the goal's heading."""


def mesh_path(mesh: Mesh, ends: Ends, check: Callable[[], None] = lambda: None) -> list[int] | None:
    """
    Find a shortest path, and of these one with the fewest turns.

    Parameters
    ----------
    mesh : Mesh
        The mesh.
    ends : Ends
        How start and goal join it.
    check : callable
        Called now and then; raises to end the search.

    Returns
    -------
    list of int or None
        Numbers of the crossings between start and goal, none for a path that goes straight there;
        None if there is no path.
    """
    starts, goals = ends.starts, ends.goals
    least = ends.direct if ends.direct >= 0 else _FAR
    left = np.zeros(mesh.exits.size, dtype=np.int64)
    if len(starts.crossings) and len(goals.crossings):
        least = _lengths_left(mesh, ends, least, left, check)
    if least == _FAR:
        return None
    room = _ROOM_AT_FIRST
    while True:
        check()
        costs = np.zeros(_BEARINGS * len(left), dtype=np.int64)
        before = np.empty(len(costs), dtype=np.int64)
        last = _fewest_turns(
            mesh, ends, left, least, costs, before, np.empty((room, 3), dtype=np.int64)
        )
        if last != _NO_ROOM:
            break
        room *= 8
    states = path_back(before.__getitem__, last, _START)[1:] if last != _START else []
    return [state // _BEARINGS for state in states]


def _lengths_left(
    mesh: Mesh, ends: Ends, least: int, left: Integers, check: Callable[[], None]
) -> int:
    """
    Find the length from crossings to the goal, as far as they may be on a shortest path.

    Parameters
    ----------
    mesh, ends, check
        As for :func:`mesh_path`.
    least : int
        Length of a path that is known.
    left : ndarray of int, shape (n,)
        Zeros; the lengths, plus one, are filled in.

    Returns
    -------
    int
        Length of the shortest path.
    """
    starts, goals = ends.starts, ends.goals
    columns = mesh.exits.shape[1]
    # A* bounds what is left by the length to the crossing nearest to the start.
    near = int(starts.crossings[np.argmin(starts.lengths)])
    to_near = _octile(starts.crossings, near, columns, mesh.straight, mesh.diagonal)
    beyond = int((to_near - starts.lengths).max())
    from_start = np.zeros(len(left), dtype=np.int64)
    from_start[starts.crossings] = starts.lengths + 1
    left[goals.crossings] = goals.lengths + 1
    keys = goals.lengths + _octile(goals.crossings, near, columns, mesh.straight, mesh.diagonal)
    first = int(keys.min())
    queue = bucket_queue(int(keys.max() - first) // mesh.straight + 4)
    for crossing, bucket in zip(goals.crossings.tolist(), (keys - first) // mesh.straight):
        push(queue.heads, queue.entries, queue.state, crossing, 0, int(bucket))
        if from_start[crossing]:
            least = min(least, int(from_start[crossing] + left[crossing]) - 2)
    # Least length, what keys exceed it by on a shortest path at most, and where keys begin.
    known = np.array([least, beyond - first, near, first])

    def expand(queue: BucketQueue) -> int:
        return _go_back(mesh, from_start, left, known, queue, _AT_A_TIME)

    run_search(expand, queue, 0, check)
    return int(known[0])


def _octile(
    crossings: Integers, other: int, columns: int, straight: int, diagonal: int
) -> Integers:
    """Return the least lengths between crossings and another on a free mesh."""
    along = np.abs(crossings % columns - other % columns)
    across = np.abs(crossings // columns - other // columns)
    shorter = np.minimum(along, across)
    lengths: Integers = straight * (np.maximum(along, across) - shorter) + diagonal * shorter
    return lengths


@compiled_loop
def _go_back(
    mesh: Mesh,
    from_start: Integers,
    left: Integers,
    known: Integers,
    queue: BucketQueue,
    at_a_time: int,
) -> int:
    """
    Go on with the search from the goal, for so many visits at a time.

    Returns ``DONE``, ``PAUSED``, or ``FULL`` if the queue must grow.
    """
    heads, entries, state = queue.heads, queue.entries, queue.state
    exits, straight, diagonal = mesh.exits, mesh.straight, mesh.diagonal
    columns = exits.shape[1]
    near_x, near_y = known[2] % columns, known[2] // columns
    for _ in range(at_a_time):
        if is_empty(state):
            return DONE
        bucket = next_bucket(heads, state)
        if bucket * straight > known[0] + known[1]:
            return DONE
        if not has_room(entries, state, _HEADINGS):
            return FULL
        here, length = pop(heads, entries, state)
        if length and length != left[here]:
            continue
        row, column = here // columns, here % columns
        for k in range(_HEADINGS):
            if not (exits[row, column] >> k) & 1:
                continue
            x, y = column + DX[k], row + DY[k]
            there = y * columns + x
            onward = left[here] + (diagonal if k & 1 else straight)
            if left[there] and left[there] <= onward:
                continue
            left[there] = onward
            if from_start[there]:
                known[0] = min(known[0], onward + from_start[there] - 2)
            along, across = abs(x - near_x), abs(y - near_y)
            key = onward - 1 + straight * max(along, across)
            key += (diagonal - straight) * min(along, across)
            push(heads, entries, state, there, onward, (key - known[3]) // straight)
    return PAUSED


@compiled_loop
def _fewest_turns(
    mesh: Mesh,
    ends: Ends,
    left: Integers,
    least: int,
    costs: Integers,
    before: Integers,
    heap: Integers,
) -> int:
    """
    Search from the start along shortest paths, by turns.

    Fills the state before each, and returns the last state before the goal, or `_NO_ROOM`.
    """
    exits, starts, goals = mesh.exits, ends.starts, ends.goals
    columns = exits.shape[1]
    waiting = order = 0
    at_goal, last = np.iinfo(np.int64).max, _START
    at_start, at_end = ends.bearings
    for leg in range(len(starts.crossings)):
        crossing, length = starts.crossings[leg], starts.lengths[leg]
        if left[crossing] == 0 or length + left[crossing] - 1 != least:
            continue
        if waiting == len(heap):
            return _NO_ROOM
        state = _BEARINGS * crossing + _way(_bearing_of(starts, leg, at_start))
        turn = int(_bearing_of(starts, leg, at_start) != at_start)
        costs[state] = length * _UNIT + turn + 1
        before[state] = _START
        _push(heap, waiting, costs[state], order, state)
        waiting, order = waiting + 1, order + 1
    if ends.direct == least:
        bearing = ends.direct_bearing if ends.direct_bearing >= 0 else at_start
        at_goal = least * _UNIT + int(bearing != at_start) + int(bearing != at_end) + 1
    while waiting and heap[0, 0] < at_goal:
        cost, state = heap[0, 0], heap[0, 2]
        _pop(heap, waiting)
        waiting -= 1
        # A cheaper one has been visited before.
        if cost != costs[state]:
            continue
        crossing, k = state // _BEARINGS, state % _BEARINGS
        length = (cost - 1) // _UNIT
        arrived = k * (CIRCLE // _HEADINGS)
        if k == _HEADINGS:
            for leg in range(len(starts.crossings)):
                if starts.crossings[leg] == crossing:
                    arrived = _bearing_of(starts, leg, at_start)
        row, column = crossing // columns, crossing % columns
        if waiting + _HEADINGS > len(heap):
            return _NO_ROOM
        for j in range(_HEADINGS):
            if not (exits[row, column] >> j) & 1:
                continue
            there = crossing + DY[j] * columns + DX[j]
            step = mesh.diagonal if j & 1 else mesh.straight
            if left[there] == 0 or length + step + left[there] - 1 != least:
                continue
            onward = cost + step * _UNIT + int(j != k)
            other = _BEARINGS * there + j
            if costs[other] == 0 or onward < costs[other]:
                costs[other] = onward
                before[other] = state
                _push(heap, waiting, onward, order, other)
                waiting, order = waiting + 1, order + 1
        for leg in range(len(goals.crossings)):
            if goals.crossings[leg] == crossing and length + goals.lengths[leg] == least:
                bearing = _bearing_of(goals, leg, arrived)
                total = cost + goals.lengths[leg] * _UNIT
                total += int(bearing != arrived) + int(bearing != at_end)
                if total < at_goal:
                    at_goal, last = total, state
    return last


@inlined_part
def _bearing_of(legs: Legs, leg: int, arrived: int) -> int:
    """Return the bearing along a segment; that of the arrival if it has no length."""
    return int(legs.bearings[leg]) if legs.bearings[leg] >= 0 else arrived


@inlined_part
def _way(bearing: int) -> int:
    """Return how a crossing is reached on a bearing."""
    part = CIRCLE // _HEADINGS
    return bearing // part if bearing % part == 0 else _HEADINGS


@compiled_part
def _push(heap: Integers, waiting: int, cost: int, order: int, state: int) -> None:
    """Put a state on the heap of those that wait, of which there are so many."""
    at = waiting
    while at > 0:
        parent = (at - 1) >> 1
        if heap[parent, 0] < cost or (heap[parent, 0] == cost and heap[parent, 1] < order):
            break
        for part in range(3):
            heap[at, part] = heap[parent, part]
        at = parent
    heap[at, 0], heap[at, 1], heap[at, 2] = cost, order, state


@compiled_part
def _pop(heap: Integers, waiting: int) -> None:
    """Take the first off the heap of so many, whose content has been read."""
    last = waiting - 1
    cost, order, state = heap[last, 0], heap[last, 1], heap[last, 2]
    at = 0
    while True:
        child = 2 * at + 1
        if child >= last:
            break
        if child + 1 < last and (
            heap[child + 1, 0] < heap[child, 0]
            or (heap[child + 1, 0] == heap[child, 0] and heap[child + 1, 1] < heap[child, 1])
        ):
            child += 1
        if cost < heap[child, 0] or (cost == heap[child, 0] and order < heap[child, 1]):
            break
        for part in range(3):
            heap[at, part] = heap[child, part]
        at = child
    heap[at, 0], heap[at, 1], heap[at, 2] = cost, order, state
