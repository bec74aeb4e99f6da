"""
Shortest paths from cell to cell, straight and diagonal, by jump point search.

Harabor and Grastien: Online Graph Pruning for Pathfinding on Grid Maps (AAAI 2011). No
corner is cut: a diagonal step needs both cells beside it free. Lengths are whole numbers,
2378 for a straight step and 3363 for a diagonal one, a ratio that is sqrt 2 within 1e-7:
so equal lengths are equal.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_planner.grid.bit_grid import BitGrid, Bits, first_bit, is_set, last_bit
from quad_planner.grid.compiled import compiled, compiled_part

Cells = NDArray[np.int64]
Records = NDArray[np.void]

STRAIGHT = 2378
DIAGONAL = 3363

# Direction k points at k times 45 degrees.
_DX = np.array([1, 1, 0, -1, -1, -1, 0, 1])
_DY = np.array([0, 1, 1, 1, 0, -1, -1, -1])

_FOUND = 0
_NO_PATH = 1
_NO_ROOM = 2
_INTERRUPTED = 3

_EXPANSIONS = 4096
"""After so many a search looks up, whether it is to go on."""

_ONE = np.uint64(1)
_LAST = np.uint64(63)
_ALL = ~np.uint64(0)
_DIAGONAL_STEPS = 32
"""So many cells of a diagonal are looked at; going on has to wait until it is its turn."""

_NODES_AT_FIRST = 2048
_ROOM = 2 * _DIAGONAL_STEPS + 2
"""In one direction at most two cells are found beside each cell of a diagonal."""

_HASH = np.uint64(0x9E3779B97F4A7C15)


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
    around = np.arange(256)
    free = [(around >> k & 1) > 0 for k in range(8)]
    legal = np.zeros(256, dtype=np.uint8)
    for k in range(8):
        may = free[k] if k % 2 == 0 else free[k] & free[k - 1] & free[(k + 1) % 8]
        legal |= np.where(may, 1 << k, 0).astype(np.uint8)
    table = np.zeros((256, 256), dtype=np.uint8)
    table[0] = legal
    for k in range(8):
        wanted = np.full(256, 1 << k)
        for side in (1, -1):
            beside = 1 << (k + side) % 8
            if k % 2:
                wanted |= beside
            else:
                opens = ~free[(k + 3 * side) % 8] & free[(k + 2 * side) % 8]
                wanted |= np.where(opens, beside | 1 << (k + 2 * side) % 8, 0)
        table[1 << k] = wanted & legal
    for arrivals in range(1, 256):
        for k in range(8):
            if arrivals >> k & 1:
                table[arrivals] |= table[1 << k]
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


_NODE = np.dtype(
    [
        ('length', np.int64),  # from the start
        ('x', np.int64),  # the cell, walls included
        ('y', np.int64),
        ('parent', np.int32),  # number of a node
        ('arrivals', np.uint8),  # directions by which a path of that length arrives, a bit each
        ('taken', np.uint8),  # directions in which the search went on, a bit each
    ],
    align=True,
)

_OPEN = np.dtype([('key', np.int64), ('node', np.int64)])


class _Tree(NamedTuple):
    """
    What a search has reached: nodes, numbered as they were found; number 0 is the start.

    A search looks at few cells of a large map: the arrays grow with these, not with the map.
    """

    nodes: Records
    """Of `_NODE`."""
    slots: NDArray[np.int32]
    """Where a cell's hash points, or behind: the number of its node plus one, or 0; 2^k."""
    heap: Records
    """Of `_OPEN`: nodes and the least length of a path through them, the least first."""
    counts: NDArray[np.int64]
    """How many nodes there are, and how many entries of the heap, shape (2,)."""


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

    @property
    def grid(self) -> BitGrid:
        """Return the free cells."""
        return self._grid

    def path(
        self,
        start: tuple[int, int],
        goal: tuple[int, int],
        check: Callable[[], None] = lambda: None,
    ) -> CellPath | None:
        """
        Find a shortest path.

        Parameters
        ----------
        start, goal : tuple of int
            x and y of cells of the map.
        check : callable
            Called again and again; raises to end the search.

        Returns
        -------
        CellPath or None
            None if there is no path, or an end is not free.
        """
        grid = self._grid
        for x, y in (start, goal):
            if not (0 <= x < grid.width and 0 <= y < grid.height):
                return None
            if not is_set(grid.rows, y + 1, x + 1):
                return None
        begin, end = ((x + 1, y + 1) for x, y in (start, goal))
        tree = _tree(begin)
        outcome = _INTERRUPTED
        while outcome not in (_FOUND, _NO_PATH):
            outcome = _search(grid.rows, grid.columns, ONWARD, *tree, end)
            check()
            if outcome == _NO_ROOM:
                tree = _larger(tree)
        if outcome == _NO_PATH:
            return None
        cells, straight, diagonal = _cells(tree.nodes, tree.slots, end)
        return CellPath(without_straights(cells), straight, diagonal)


def _tree(start: tuple[int, int]) -> _Tree:
    """Make a tree of the start alone."""
    tree = _Tree(
        nodes=np.empty(_NODES_AT_FIRST, dtype=_NODE),
        slots=np.zeros(2 * _NODES_AT_FIRST, dtype=np.int32),
        heap=np.empty(_NODES_AT_FIRST, dtype=_OPEN),
        counts=np.ones(2, dtype=np.int64),
    )
    tree.nodes[0] = (0, *start, 0, 0, 0)
    tree.heap[0] = (0, 0)
    _fill_slots(tree.nodes, tree.slots, 1)
    return tree


def _larger(tree: _Tree) -> _Tree:
    """Return the same tree with twice the room."""
    size = len(tree.nodes)
    larger = _Tree(
        nodes=np.empty(2 * size, dtype=_NODE),
        slots=np.zeros(4 * size, dtype=np.int32),
        heap=np.empty(2 * size, dtype=_OPEN),
        counts=tree.counts,
    )
    larger.nodes[:size] = tree.nodes
    larger.heap[:size] = tree.heap
    _fill_slots(larger.nodes, larger.slots, int(tree.counts[0]))
    return larger


@compiled
def _fill_slots(nodes: Records, slots: NDArray[np.int32], count: int) -> None:
    for node in range(count):
        slots[_slot(nodes, slots, nodes[node].x, nodes[node].y)] = node + 1


@compiled_part
def _slot(nodes: Records, slots: NDArray[np.int32], x: int, y: int) -> int:
    """Return the slot that a cell has, or would have."""
    last = len(slots) - 1
    mixed = ((np.uint64(y) << np.uint64(32)) + np.uint64(x)) * _HASH
    slot = int(mixed >> np.uint64(32)) & last
    while slots[slot] != 0:
        node = slots[slot] - 1
        if nodes[node].x == x and nodes[node].y == y:
            break
        slot = (slot + 1) & last
    return slot


@compiled_part
def _octile(x: int, y: int, goal: tuple[int, int]) -> int:
    along, across = abs(x - goal[0]), abs(y - goal[1])
    return STRAIGHT * max(along, across) + (DIAGONAL - STRAIGHT) * min(along, across)


@compiled_part
def _around(rows: Bits, x: int, y: int) -> int:
    """Return the free neighbours of a cell; bit k stands for direction k."""
    pattern = 0
    for k in range(8):
        if is_set(rows, y + int(_DY[k]), x + int(_DX[k])):
            pattern |= 1 << k
    return pattern


@compiled_part
def _push(heap: Records, counts: NDArray[np.int64], key: int, node: int) -> None:
    at = counts[1]
    counts[1] += 1
    while at > 0:
        parent = (at - 1) >> 1
        if heap[parent].key <= key:
            break
        heap[at] = heap[parent]
        at = parent
    heap[at].key = key
    heap[at].node = node


@compiled_part
def _pop(heap: Records, counts: NDArray[np.int64]) -> None:
    """Take the first off the heap, whose content has been read."""
    counts[1] -= 1
    count = counts[1]
    last = heap[count]
    at = 0
    while True:
        child = 2 * at + 1
        if child >= count:
            break
        if child + 1 < count and heap[child + 1].key < heap[child].key:
            child += 1
        if heap[child].key >= last.key:
            break
        heap[at] = heap[child]
        at = child
    heap[at] = last


@compiled
def _search(
    rows: Bits,
    columns: Bits,
    onward: NDArray[np.uint8],
    nodes: Records,
    slots: NDArray[np.int32],
    heap: Records,
    counts: NDArray[np.int64],
    goal: tuple[int, int],
) -> int:
    """
    Search on for a while.

    Parameters
    ----------
    rows, columns : ndarray of uint64, shape (m, n)
        The map, as in `BitGrid`.
    onward : ndarray, shape (256, 256)
        `ONWARD`.
    nodes, slots, heap, counts
        As in `_Tree`; they are changed.
    goal : tuple of int
        x and y of the goal's cell, walls included.

    Returns
    -------
    int
        `_FOUND` or `_NO_PATH` at the end, else `_NO_ROOM` or `_INTERRUPTED`.
    """
    for _ in range(_EXPANSIONS):
        if counts[1] == 0:
            return _NO_PATH
        node, key = int(heap[0].node), int(heap[0].key)
        _pop(heap, counts)
        x, y = int(nodes[node].x), int(nodes[node].y)
        if (x, y) == goal:
            return _FOUND
        # None are left where the node was on the heap twice.
        directions = onward[nodes[node].arrivals, _around(rows, x, y)] & ~nodes[node].taken
        for k in range(8):
            if (directions >> k) & 1:
                if len(nodes) - max(counts[0], counts[1]) < _ROOM:
                    # The node is looked at again, in the directions that are left.
                    _push(heap, counts, key, node)
                    return _NO_ROOM
                nodes[node].taken |= np.uint8(1 << k)
                _go_on(rows, columns, nodes, slots, heap, counts, node, k, goal)
    return _INTERRUPTED


@compiled_part
def _go_on(
    rows: Bits,
    columns: Bits,
    nodes: Records,
    slots: NDArray[np.int32],
    heap: Records,
    counts: NDArray[np.int64],
    node: int,
    direction: int,
    goal: tuple[int, int],
) -> None:
    """Go on from a node in a direction; along a diagonal, look to both sides at each cell."""
    dx, dy = int(_DX[direction]), int(_DY[direction])
    x, y, length = int(nodes[node].x), int(nodes[node].y), int(nodes[node].length)
    is_diagonal = dx != 0 and dy != 0
    steps = 0
    while True:
        if is_diagonal:
            if not _is_open(rows, x, y, dx, dy):
                return
            x += dx
            y += dy
            length += DIAGONAL
            steps += 1
            if (x, y) == goal or steps == _DIAGONAL_STEPS:
                _reach(nodes, slots, heap, counts, node, x, y, length, direction, goal)
                return
        if dx != 0:
            at = _look(rows, y, x, dx, goal[0] if y == goal[1] else -1)
            if at >= 0:
                total = length + STRAIGHT * abs(at - x)
                _reach(nodes, slots, heap, counts, node, at, y, total, 2 - 2 * dx, goal)
        if dy != 0:
            at = _look(columns, x, y, dy, goal[1] if x == goal[0] else -1)
            if at >= 0:
                total = length + STRAIGHT * abs(at - y)
                _reach(nodes, slots, heap, counts, node, x, at, total, 4 - 2 * dy, goal)
        if not is_diagonal:
            return


@compiled_part
def _is_open(rows: Bits, x: int, y: int, dx: int, dy: int) -> bool:
    """Return whether a diagonal step is free, and both cells beside it."""
    return is_set(rows, y, x + dx) and is_set(rows, y + dy, x) and is_set(rows, y + dy, x + dx)


@compiled_part
def _look(lines: Bits, line: int, place: int, step: int, goal: int) -> int:
    """
    Look along a line for the next place of interest.

    Returns it, or -1 if there is a wall first. ``goal`` is the goal's place if it is in this
    line, else -1.
    """
    if step > 0:
        end = _stop_ahead(lines, line, place + 1)
        if place < goal < end:
            return goal
    else:
        end = _stop_behind(lines, line, place - 1)
        if end < goal < place:
            return goal
    return end if is_set(lines, line, end) else -1


@compiled_part
def _stop_ahead(lines: Bits, line: int, place: int) -> int:
    """Return the first place from this one on where a wall is, or one beside it has ended."""
    at = place >> 6
    mask = _ALL << np.uint64(place & 63)
    while True:
        # What comes from beyond the ends of a line meets the wall.
        before = max(at - 1, 0)
        above, below = lines[line + 1, at], lines[line - 1, at]
        closed = ~((above << _ONE) | (lines[line + 1, before] >> _LAST))
        stops = ~lines[line, at] | (above & closed)
        closed = ~((below << _ONE) | (lines[line - 1, before] >> _LAST))
        stops = (stops | (below & closed)) & mask
        if stops != 0:
            return (at << 6) + first_bit(stops)
        mask = _ALL
        at += 1


@compiled_part
def _stop_behind(lines: Bits, line: int, place: int) -> int:
    """Return the last place up to this one where a wall is, or one beside it has ended."""
    last = lines.shape[1] - 1
    at = place >> 6
    mask = _ALL >> np.uint64(63 - (place & 63))
    while True:
        after = min(at + 1, last)
        above, below = lines[line + 1, at], lines[line - 1, at]
        closed = ~((above >> _ONE) | (lines[line + 1, after] << _LAST))
        stops = ~lines[line, at] | (above & closed)
        closed = ~((below >> _ONE) | (lines[line - 1, after] << _LAST))
        stops = (stops | (below & closed)) & mask
        if stops != 0:
            return (at << 6) + last_bit(stops)
        mask = _ALL
        at -= 1


@compiled_part
def _reach(
    nodes: Records,
    slots: NDArray[np.int32],
    heap: Records,
    counts: NDArray[np.int64],
    parent: int,
    x: int,
    y: int,
    length: int,
    direction: int,
    goal: tuple[int, int],
) -> None:
    """Note that a cell was reached from a node, unless a shorter way to it is known."""
    slot = _slot(nodes, slots, x, y)
    key = length + _octile(x, y, goal)
    arrival = np.uint8(1 << direction)
    node = int(slots[slot]) - 1
    if node < 0:
        node = counts[0]
        counts[0] += 1
        nodes[node].x = x
        nodes[node].y = y
        slots[slot] = node + 1
    elif nodes[node].length == length and nodes[node].arrivals & arrival == 0:
        # As short from another side: from there it may go on elsewhere.
        nodes[node].arrivals |= arrival
        _push(heap, counts, key, node)
        return
    elif nodes[node].length <= length:
        return
    nodes[node].length = length
    nodes[node].parent = parent
    nodes[node].arrivals = arrival
    nodes[node].taken = 0
    _push(heap, counts, key, node)


@compiled
def _cells(
    nodes: Records, slots: NDArray[np.int32], goal: tuple[int, int]
) -> tuple[Cells, int, int]:
    """List where the path begins, turns and ends, in cells of the map; count its steps."""
    node = last = slots[_slot(nodes, slots, goal[0], goal[1])] - 1
    count = 1
    while node != 0:
        node = nodes[node].parent
        count += 2
    cells = np.empty((count, 2), dtype=np.int64)
    at, node = count - 1, last
    straight = diagonal = 0
    while True:
        x, y = int(nodes[node].x), int(nodes[node].y)
        cells[at, 0], cells[at, 1] = x - 1, y - 1
        if node == 0:
            break
        node = nodes[node].parent
        from_x, from_y = int(nodes[node].x), int(nodes[node].y)
        steps = min(abs(x - from_x), abs(y - from_y))
        diagonal += steps
        straight += max(abs(x - from_x), abs(y - from_y)) - steps
        # Diagonal first, then straight.
        cells[at - 1, 0] = from_x - 1 + (steps if x > from_x else -steps)
        cells[at - 1, 1] = from_y - 1 + (steps if y > from_y else -steps)
        at -= 2
    return cells, straight, diagonal


def without_straights(cells: Cells) -> Cells:
    """
    Leave out places where a path goes straight on, or stays.

    Parameters
    ----------
    cells : ndarray, shape (n, 2), n >= 1
        A path; it is changed.

    Returns
    -------
    ndarray, shape (m, 2)
        Where it begins, turns and ends.
    """
    return cells[: _drop_straights(cells)]


@compiled
def _drop_straights(cells: Cells) -> int:
    """Move the places that are kept to the front, and count them."""
    last = len(cells) - 1
    kept = 1
    for k in range(1, last):
        ax, ay = cells[k, 0] - cells[kept - 1, 0], cells[k, 1] - cells[kept - 1, 1]
        bx, by = cells[k + 1, 0] - cells[k, 0], cells[k + 1, 1] - cells[k, 1]
        if ax * by == ay * bx and ax * bx + ay * by >= 0:
            continue
        cells[kept, 0], cells[kept, 1] = cells[k, 0], cells[k, 1]
        kept += 1
    if last > 0:
        cells[kept, 0], cells[kept, 1] = cells[last, 0], cells[last, 1]
        kept += 1
    return kept
