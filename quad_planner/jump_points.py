"""
Shortest paths from cell to cell, straight and diagonal, by jump point search.

Harabor and Grastien: Online Graph Pruning for Pathfinding on Grid Maps (AAAI 2011). No
corner is cut: a diagonal step needs both cells beside it free. Lengths are whole numbers,
2378 for a straight step and 3363 for a diagonal one, a ratio that is sqrt 2 within 1e-7:
so equal lengths are equal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_planner.bit_grid import BitGrid, Bits, is_set, next_set, previous_set
from quad_planner.compiled import compiled

Cells = NDArray[np.int64]

STRAIGHT = 2378
DIAGONAL = 3363

# Direction k points at k times 45 degrees.
_DX = np.array([1, 1, 0, -1, -1, -1, 0, 1])
_DY = np.array([0, 1, 1, 1, 0, -1, -1, -1])

_NO_PATH = -1
_HEAP_FULL = -2


def _pruned_directions() -> NDArray[np.uint8]:
    """
    Tabulate where to go on, by the directions of arrival and the free neighbours.

    Straight on, and where a wall beside the last cell ends, also to that side: only
    through this cell the shortest way leads there. A diagonal goes on along both its
    parts too. From the start, everywhere.

    Returns
    -------
    ndarray, shape (256, 256)
        Bit k of each index and entry stands for direction k.
    """
    table = np.zeros((256, 256), dtype=np.uint8)
    for around in range(256):
        free = [bool(around >> k & 1) for k in range(8)]
        legal = [free[k] and (k % 2 == 0 or (free[k - 1] and free[(k + 1) % 8])) for k in range(8)]
        everywhere = sum(1 << k for k in range(8) if legal[k])
        onward = []
        for k in range(8):
            wanted = {k}
            if k % 2:
                wanted |= {k - 1, (k + 1) % 8}
            else:
                for side in (1, -1):
                    if not free[(k + 3 * side) % 8] and free[(k + 2 * side) % 8]:
                        wanted |= {(k + side) % 8, (k + 2 * side) % 8}
            onward.append(sum(1 << d for d in wanted if legal[d]))
        table[0, around] = everywhere
        for arrivals in range(1, 256):
            directions = 0
            for k in range(8):
                if arrivals >> k & 1:
                    directions |= onward[k]
            table[arrivals, around] = directions
    return table


ONWARD = _pruned_directions()
"""Where a shortest path goes on, by arrivals and free neighbours; shape (256, 256)."""


@dataclass(frozen=True)
class CellPath:
    """A shortest path."""

    cells: Cells
    """Where it begins, turns and ends: x and y, shape (n, 2)."""
    straight_steps: int
    diagonal_steps: int

    @property
    def length(self) -> float:
        """In cells."""
        return float(self.straight_steps + np.sqrt(2.0) * self.diagonal_steps)


class JumpPointSearch:
    """
    A map made ready for any number of searches.

    Parameters
    ----------
    grid : BitGrid
        The free cells.
    """

    def __init__(self, grid: BitGrid) -> None:
        self._grid = grid
        self._stops_east, self._stops_west = (_stops(grid.rows, way) for way in (True, False))
        self._stops_north, self._stops_south = (_stops(grid.columns, way) for way in (True, False))
        size = (grid.height + 2) * (grid.width + 2)
        # Plus one, and 0 for cells that were not reached: zeros cost nothing until touched.
        self._lengths = np.zeros(size, dtype=np.int32)
        self._arrivals = np.zeros(size, dtype=np.uint8)
        self._parents = np.empty(size, dtype=np.int32)
        self._touched = np.empty(1024, dtype=np.int32)
        self._keys = np.empty(1024, dtype=np.int64)
        self._heap = np.empty(1024, dtype=np.int32)

    def path(self, start: tuple[int, int], goal: tuple[int, int]) -> CellPath | None:
        """
        Find a shortest path.

        Parameters
        ----------
        start, goal : tuple of int
            x and y of cells of the map.

        Returns
        -------
        CellPath or None
            None if there is no path, or an end is not free.
        """
        grid = self._grid
        width = grid.width + 2
        ends = [(y + 1) * width + x + 1 for x, y in (start, goal)]
        for x, y in (start, goal):
            if not (0 <= x < grid.width and 0 <= y < grid.height):
                return None
            if not is_set(grid.rows, y + 1, x + 1):
                return None
        while True:
            length, touched = _search(
                grid.rows,
                grid.columns,
                self._stops_east,
                self._stops_west,
                self._stops_north,
                self._stops_south,
                ONWARD,
                width,
                ends[0],
                ends[1],
                self._lengths,
                self._arrivals,
                self._parents,
                self._touched,
                self._keys,
                self._heap,
            )
            cells = None
            if length >= 0:
                cells = _cells(self._parents, width, ends[0], ends[1])
            # Only what was touched is cleared: a search looks at few cells of a large map.
            self._lengths[self._touched[:touched]] = 0
            if length != _HEAP_FULL:
                break
            size = 4 * len(self._heap)
            self._touched = np.empty(size, dtype=np.int32)
            self._keys = np.empty(size, dtype=np.int64)
            self._heap = np.empty(size, dtype=np.int32)
        if cells is None:
            return None
        steps = np.abs(np.diff(cells, axis=0))
        diagonal = int(steps.min(axis=1).sum())
        return CellPath(cells, int(steps.max(axis=1).sum()) - diagonal, diagonal)


def _stops(lines: Bits, forward: bool) -> Bits:
    """
    Mark where a scan along a line stops: at a wall, or where a wall beside it ends.

    Parameters
    ----------
    lines : ndarray of uint64, shape (m, n)
        Free cells.
    forward : bool
        Whether the scan goes towards larger places.

    Returns
    -------
    ndarray of uint64, shape (m, n)
        The marks.
    """
    shifted = np.empty_like(lines)
    one, last = np.uint64(1), np.uint64(63)
    if forward:
        shifted[:] = lines << one
        shifted[:, 1:] |= lines[:, :-1] >> last
    else:
        shifted[:] = lines >> one
        shifted[:, :-1] |= lines[:, 1:] << last
    opens = lines & ~shifted
    marks = ~lines
    marks[1:] |= opens[:-1]
    marks[:-1] |= opens[1:]
    return marks


@compiled
def _scan(lines: Bits, stops: Bits, line: int, place: int, forward: bool, goal: int) -> int:
    """
    Go along a line to the next place of interest.

    Returns its place, or -1 if there is a wall first. ``goal`` is the goal's place if it
    is in this line, else -1.
    """
    if forward:
        end = next_set(stops, line, place)
        if place < goal < end:
            return goal
    else:
        end = previous_set(stops, line, place)
        if end < goal < place:
            return goal
    return end if is_set(lines, line, end) else -1


@compiled
def _octile(x: int, y: int, goal_x: int, goal_y: int) -> int:
    along, across = abs(x - goal_x), abs(y - goal_y)
    return STRAIGHT * max(along, across) + (DIAGONAL - STRAIGHT) * min(along, across)


@compiled
def _around(rows: Bits, x: int, y: int) -> int:
    """Return the free neighbours of a cell; bit k stands for direction k."""
    pattern = 0
    for k in range(8):
        if is_set(rows, y + int(_DY[k]), x + int(_DX[k])):
            pattern |= 1 << k
    return pattern


@compiled
def _push(keys: Cells, heap: NDArray[np.int32], count: int, key: int, cell: int) -> int:
    at = count
    while at > 0:
        parent = (at - 1) >> 1
        if keys[parent] <= key:
            break
        keys[at] = keys[parent]
        heap[at] = heap[parent]
        at = parent
    keys[at] = key
    heap[at] = cell
    return count + 1


@compiled
def _pop(keys: Cells, heap: NDArray[np.int32], count: int) -> int:
    """Take the first off the heap, whose content has been read."""
    count -= 1
    key, cell = keys[count], heap[count]
    at = 0
    while True:
        child = 2 * at + 1
        if child >= count:
            break
        if child + 1 < count and keys[child + 1] < keys[child]:
            child += 1
        if keys[child] >= key:
            break
        keys[at] = keys[child]
        heap[at] = heap[child]
        at = child
    keys[at] = key
    heap[at] = cell
    return count


@compiled
def _search(
    rows: Bits,
    columns: Bits,
    stops_east: Bits,
    stops_west: Bits,
    stops_north: Bits,
    stops_south: Bits,
    onward: NDArray[np.uint8],
    width: int,
    start: int,
    goal: int,
    lengths: NDArray[np.int32],
    arrivals: NDArray[np.uint8],
    parents: NDArray[np.int32],
    touched: NDArray[np.int32],
    keys: Cells,
    heap: NDArray[np.int32],
) -> tuple[int, int]:
    """
    Search; the arrays are as :class:`JumpPointSearch` keeps them.

    Each leg from a parent is diagonal first, then straight. Returns the length, or
    ``_NO_PATH`` or ``_HEAP_FULL``, and how many cells were touched.
    """
    goal_y, goal_x = goal // width, goal % width
    lengths[start] = 1
    arrivals[start] = 0
    parents[start] = start
    touched[0] = start
    touch_count = 1
    count = _push(keys, heap, 0, _octile(start % width, start // width, goal_x, goal_y), start)
    found = np.empty(3, dtype=np.int64)
    found_by = np.empty(3, dtype=np.int64)
    found_at = np.empty(3, dtype=np.int64)
    while count > 0:
        cell = int(heap[0])
        key = int(keys[0])
        count = _pop(keys, heap, count)
        y, x = cell // width, cell % width
        length = int(lengths[cell]) - 1
        if key > length + _octile(x, y, goal_x, goal_y):
            continue
        if cell == goal:
            return length, touch_count
        directions = int(onward[arrivals[cell], _around(rows, x, y)])
        for k in range(8):
            if not (directions >> k) & 1:
                continue
            dx, dy = int(_DX[k]), int(_DY[k])
            at_x, at_y, done = x, y, length
            while True:
                if k & 1:
                    # The next cell of a diagonal, and what is straight beside it.
                    if not (
                        is_set(rows, at_y, at_x + dx)
                        and is_set(rows, at_y + dy, at_x)
                        and is_set(rows, at_y + dy, at_x + dx)
                    ):
                        break
                    at_x += dx
                    at_y += dy
                    done += DIAGONAL
                hits = 0
                if k & 1 and at_x == goal_x and at_y == goal_y:
                    found[0], found_by[0], found_at[0] = goal, k, done
                    hits = 1
                else:
                    if dx != 0:
                        stops = stops_east if dx > 0 else stops_west
                        ahead = goal_x if at_y == goal_y else -1
                        place = _scan(rows, stops, at_y, at_x, dx > 0, ahead)
                        if place >= 0:
                            found[hits] = at_y * width + place
                            found_by[hits] = 0 if dx > 0 else 4
                            found_at[hits] = done + STRAIGHT * abs(place - at_x)
                            hits += 1
                    if dy != 0:
                        stops = stops_north if dy > 0 else stops_south
                        ahead = goal_y if at_x == goal_x else -1
                        place = _scan(columns, stops, at_x, at_y, dy > 0, ahead)
                        if place >= 0:
                            found[hits] = place * width + at_x
                            found_by[hits] = 2 if dy > 0 else 6
                            found_at[hits] = done + STRAIGHT * abs(place - at_y)
                            hits += 1
                for hit in range(hits):
                    target, total = int(found[hit]), int(found_at[hit])
                    known = int(lengths[target]) - 1
                    if 0 <= known < total:
                        continue
                    bit = np.uint8(1 << int(found_by[hit]))
                    if known != total:
                        if known < 0:
                            if touch_count == len(touched):
                                return _HEAP_FULL, touch_count
                            touched[touch_count] = target
                            touch_count += 1
                        lengths[target] = total + 1
                        arrivals[target] = bit
                        parents[target] = cell
                    elif arrivals[target] & bit or arrivals[target] == 0:
                        continue
                    else:
                        # As short from another side: from there it may go on elsewhere.
                        arrivals[target] |= bit
                    if count == len(heap):
                        return _HEAP_FULL, touch_count
                    ty, tx = target // width, target % width
                    count = _push(
                        keys, heap, count, total + _octile(tx, ty, goal_x, goal_y), target
                    )
                if not k & 1 or (at_x == goal_x and at_y == goal_y):
                    break
    return _NO_PATH, touch_count


@compiled
def _cells(parents: NDArray[np.int32], width: int, start: int, goal: int) -> Cells:
    """List where the path begins, turns and ends, in cells of the map."""
    count = 1
    cell = goal
    while cell != start:
        cell = int(parents[cell])
        count += 2
    cells = np.empty((count, 2), dtype=np.int64)
    at = count
    cell = goal
    while True:
        at -= 1
        x, y = cell % width, cell // width
        cells[at, 0], cells[at, 1] = x - 1, y - 1
        if cell == start:
            break
        parent = int(parents[cell])
        from_x, from_y = parent % width, parent // width
        steps = min(abs(x - from_x), abs(y - from_y))
        # Diagonal first, then straight.
        at -= 1
        cells[at, 0] = from_x - 1 + (steps if x > from_x else -steps)
        cells[at, 1] = from_y - 1 + (steps if y > from_y else -steps)
        cell = parent
    # Without places where it goes straight on, or stays.
    kept = 1
    for k in range(1, count - 1):
        ax, ay = cells[k, 0] - cells[kept - 1, 0], cells[k, 1] - cells[kept - 1, 1]
        bx, by = cells[k + 1, 0] - cells[k, 0], cells[k + 1, 1] - cells[k, 1]
        if ax * by == ay * bx and ax * bx + ay * by >= 0:
            continue
        cells[kept] = cells[k]
        kept += 1
    if count > 1:
        cells[kept] = cells[count - 1]
        kept += 1
    return cells[:kept]
