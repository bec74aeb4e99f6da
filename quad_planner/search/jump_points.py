"""
Shortest paths from cell to cell, straight and diagonal, by jump point search.

Harabor and Grastien: Online Graph Pruning for Pathfinding on Grid Maps (AAAI 2011). No
corner is cut: a diagonal step needs both cells beside it free. Lengths are whole numbers,
2378 for a straight step and 3363 for a diagonal one, a ratio that is sqrt 2 within 1e-7:
so equal lengths are equal.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, compiled_loop, compiled_part
from quad_planner.grid.bit_grid import BitGrid, Bits, is_set
from quad_planner.search.cell_path import CellPath, without_straights
from quad_planner.search.cell_steps import DIAGONAL, DX, DY, ONWARD, STRAIGHT
from quad_planner.search.jump_look import look_along
from quad_planner.search.jump_tree import larger_tree, pop_node, push_node, slot_of, tree_of

Cells = NDArray[np.int64]
Records = NDArray[np.void]


_FOUND = 0
_NO_PATH = 1
_NO_ROOM = 2
_INTERRUPTED = 3

_EXPANSIONS = 4096
"""Number of expansions after which a search asks whether it is to go on."""

_DIAGONAL_STEPS = 32
"""Number of cells of a diagonal that are looked at; what follows waits for its turn."""

_ROOM = 2 * _DIAGONAL_STEPS + 2
"""Number of cells that one direction adds at most: two beside each cell of a diagonal."""


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
        if not (grid.is_free(*start) and grid.is_free(*goal)):
            return None
        begin, end = ((x + 1, y + 1) for x, y in (start, goal))
        tree = tree_of(begin)
        outcome = _INTERRUPTED
        while outcome not in (_FOUND, _NO_PATH):
            outcome = _search(grid.rows, grid.columns, ONWARD, *tree, end)
            check()
            if outcome == _NO_ROOM:
                tree = larger_tree(tree)
        if outcome == _NO_PATH:
            return None
        cells, straight, diagonal = _cells(tree.nodes, tree.slots, end)
        return CellPath(without_straights(cells), straight, diagonal)


@compiled_part
def _octile(x: int, y: int, goal: tuple[int, int]) -> int:
    along, across = abs(x - goal[0]), abs(y - goal[1])
    return STRAIGHT * max(along, across) + (DIAGONAL - STRAIGHT) * min(along, across)


@compiled_part
def _around(rows: Bits, x: int, y: int) -> int:
    """Return the free neighbours of a cell; bit k stands for direction k."""
    pattern = 0
    for k in range(8):
        if is_set(rows, y + int(DY[k]), x + int(DX[k])):
            pattern |= 1 << k
    return pattern


@compiled_loop
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
        Arrays of a `Tree`; they are changed.
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
        pop_node(heap, counts)
        x, y = int(nodes[node].x), int(nodes[node].y)
        if (x, y) == goal:
            return _FOUND
        # None are left where the node was on the heap twice.
        directions = onward[nodes[node].arrivals, _around(rows, x, y)] & ~nodes[node].taken
        for k in range(8):
            if (directions >> k) & 1:
                if len(nodes) - max(counts[0], counts[1]) < _ROOM:
                    # The node is looked at again, in the directions that are left.
                    push_node(heap, counts, key, node)
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
    dx, dy = int(DX[direction]), int(DY[direction])
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
            at = look_along(rows, y, x, dx, goal[0] if y == goal[1] else -1)
            if at >= 0:
                total = length + STRAIGHT * abs(at - x)
                _reach(nodes, slots, heap, counts, node, at, y, total, 2 - 2 * dx, goal)
        if dy != 0:
            at = look_along(columns, x, y, dy, goal[1] if x == goal[0] else -1)
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
    """Note that a cell was reached from a node, unless a shorter path to it is known."""
    slot = slot_of(nodes, slots, x, y)
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
        push_node(heap, counts, key, node)
        return
    elif nodes[node].length <= length:
        return
    nodes[node].length = length
    nodes[node].parent = parent
    nodes[node].arrivals = arrival
    nodes[node].taken = 0
    push_node(heap, counts, key, node)


@compiled
def _cells(
    nodes: Records, slots: NDArray[np.int32], goal: tuple[int, int]
) -> tuple[Cells, int, int]:
    """List where the path begins, turns and ends, in cells of the map; count its steps."""
    node = last = slots[slot_of(nodes, slots, goal[0], goal[1])] - 1
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
