"""
Which rectangles may be on a shortest path: dead ends are left out.

The rectangles and their openings are a graph. Its blocks, joined by the rectangles that belong
to several of them, make a tree (Hopcroft and Tarjan: Efficient Algorithms for Graph Manipulation,
1973). A path that goes into a block off the tree's path from the start to the goal comes back
through the same rectangle, which is convex: straight through that it is shorter.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, inlined_part
from quad_planner.any_angle.intervals import neighbour, neighbours
from quad_planner.any_angle.rectangles import Rectangles
from quad_planner.grid.array_types import Mask

Integers = NDArray[np.int64]

_NONE = -1


class Blocks(NamedTuple):
    """The tree of blocks."""

    block: Integers
    """Block of each rectangle towards the root of its tree, -1 for the root, shape (n,)."""
    top: Integers
    """Rectangle by which each block hangs in the tree, shape (m,)."""


def blocks_of(rectangles: Rectangles) -> Blocks:
    """
    Find the blocks.

    Parameters
    ----------
    rectangles : Rectangles
        The free cells.

    Returns
    -------
    Blocks
        Of all connected areas.
    """
    count = len(rectangles.bounds)
    # Order of discovery, lowest order reached, parent, and the next neighbour to look at.
    notes = np.full((count, 4), _NONE)
    block, top = (np.full(count, _NONE) for _ in range(2))
    stack = np.empty(count, dtype=np.int64)
    found = _find(rectangles, notes, stack, block, top)
    return Blocks(block, top[:found])


def between(blocks: Blocks, start: int, goal: int) -> Mask | None:
    """
    Mark the rectangles that may be on a shortest path.

    Parameters
    ----------
    blocks : Blocks
        The tree.
    start, goal : int
        Rectangles.

    Returns
    -------
    ndarray of bool, shape (n,) or None
        The rectangles of all blocks between the two; None if they are not connected.
    """
    is_open = np.zeros(len(blocks.block), dtype=np.bool_)
    on_path = np.zeros(len(blocks.top), dtype=np.bool_)
    return is_open if _mark(blocks, start, goal, on_path, is_open) else None


@inlined_part
def _next(rectangles: Rectangles, here: int, at: int) -> int:
    """Return the neighbour at a place among those of both sides; -1 after the last."""
    first, last = neighbours(rectangles, here, True)
    if first + at < last:
        return neighbour(rectangles, first + at, True)
    at -= last - first
    first, last = neighbours(rectangles, here, False)
    return neighbour(rectangles, first + at, False) if first + at < last else _NONE


@compiled_loop
def _find(
    rectangles: Rectangles, notes: Integers, stack: Integers, block: Integers, top: Integers
) -> int:
    """Fill the tree of blocks, by a search in depth; return how many there are."""
    found = discovered = waiting = 0
    for root in range(len(block)):
        if notes[root, 0] != _NONE:
            continue
        here = root
        notes[here, 0] = notes[here, 1] = discovered
        notes[here, 3] = 0
        discovered += 1
        while here != _NONE:
            there = _next(rectangles, here, notes[here, 3])
            notes[here, 3] += 1
            if there != _NONE:
                if notes[there, 0] == _NONE:
                    notes[there, 0] = notes[there, 1] = discovered
                    notes[there, 2], notes[there, 3] = here, 0
                    discovered += 1
                    stack[waiting] = there
                    waiting += 1
                    here = there
                elif there != notes[here, 2]:
                    notes[here, 1] = min(notes[here, 1], notes[there, 0])
                continue
            parent = notes[here, 2]
            if parent != _NONE:
                notes[parent, 1] = min(notes[parent, 1], notes[here, 1])
                if notes[here, 1] >= notes[parent, 0]:
                    # What was found since is joined to the rest by the parent only.
                    while True:
                        waiting -= 1
                        block[stack[waiting]] = found
                        if stack[waiting] == here:
                            break
                    top[found] = parent
                    found += 1
            here = parent
    return found


@compiled_loop
def _mark(blocks: Blocks, start: int, goal: int, on_path: Mask, is_open: Mask) -> bool:
    """Mark the blocks on the path of the tree, then their rectangles."""
    block, top = blocks.block, blocks.top
    at = start
    while block[at] != _NONE:
        on_path[block[at]] = True
        at = top[block[at]]
    root, at = at, goal
    while block[at] != _NONE and not on_path[block[at]]:
        on_path[block[at]] = True
        at = top[block[at]]
    if block[at] == _NONE and at != root:
        return False
    # Above where the two paths to the root meet, none of their blocks is between.
    meeting, met = block[at], at
    at = start
    while block[at] != meeting:
        at = top[block[at]]
    if block[at] != _NONE and at == met:
        on_path[meeting] = False
    at = top[meeting] if meeting != _NONE else at
    while block[at] != _NONE:
        on_path[block[at]] = False
        at = top[block[at]]
    for k in range(len(block)):
        if block[k] != _NONE and on_path[block[k]]:
            is_open[k] = is_open[top[block[k]]] = True
    return True
