"""
A mesh laid over a map: which crossings the robot may stand on, and which moves are free.

A move is cut where it crosses the lines between the cells. A piece lies in one cell, and its
midpoint tells which: nothing is sampled, nothing can be missed. As no point of an allowed cell
is nearer to an obstacle than the clearance, no point of the move is.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part, inlined_part
from quad_planner.grid.array_types import Mask
from quad_planner.grid.bit_grid import BitMask, Bits, is_set

_EPSILON = 1e-6
"""A point so near to a cell's edge counts as on it [cells]."""

MOVES = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))
"""Columns and rows to the neighbour at k times 45 degrees; k + 4 is the reverse of k."""


def mesh_moves(
    forbidden: BitMask, spacing: float, between: tuple[int, int], columns: int
) -> tuple[Mask, NDArray[np.uint8]]:
    """
    Lay rows of a mesh over a map.

    Parameters
    ----------
    forbidden : BitMask
        The forbidden cells.
    spacing : float
        Width of the mesh [cells].
    between : tuple of int
        Rows of crossings, from the first up to, but without, the second.
    columns : int
        Number of columns of crossings.

    Returns
    -------
    tuple of ndarray, both of shape (n, columns)
        Crossings that are candidates; moves, of eight, that are free between them.
    """
    first, last = between
    candidates = np.zeros((last - first, columns), dtype=np.bool_)
    exits = np.zeros((last - first, columns), dtype=np.uint8)
    _lay(forbidden.words, forbidden.width, spacing, first, candidates, exits)
    return candidates, exits


@compiled_loop
def _lay(
    forbidden: Bits,
    width: int,
    spacing: float,
    first: int,
    candidates: Mask,
    exits: NDArray[np.uint8],
) -> None:
    """Fill the arrays."""
    rows, columns = candidates.shape
    for r in range(rows):
        for c in range(columns):
            candidates[r, c] = _is_allowed(forbidden, width, c * spacing, (r + first) * spacing)
    for r in range(rows):
        for c in range(columns):
            for k in range(4):
                dc, dr = MOVES[k]
                to_r, to_c = r + dr, c + dc
                if to_r >= rows or not 0 <= to_c < columns:
                    continue
                if not (candidates[r, c] and candidates[to_r, to_c]):
                    continue
                x, y = c * spacing, (r + first) * spacing
                if segment_allowed(forbidden, width, x, y, dc * spacing, dr * spacing):
                    exits[r, c] |= np.uint8(1 << k)
                    exits[to_r, to_c] |= np.uint8(1 << (k + 4))


@inlined_part
def _is_allowed(forbidden: Bits, width: int, x: float, y: float) -> bool:
    """Return whether a point lies in an allowed cell, whose edges belong to it."""
    last_x, last_y = width - 1, len(forbidden) - 1
    low_x = min(max(math.floor(x - _EPSILON), 0), last_x)
    low_y = min(max(math.floor(y - _EPSILON), 0), last_y)
    if not is_set(forbidden, low_y, low_x):
        return True
    high_x = min(max(math.floor(x + _EPSILON), 0), last_x)
    high_y = min(max(math.floor(y + _EPSILON), 0), last_y)
    return not (
        is_set(forbidden, low_y, high_x)
        and is_set(forbidden, high_y, low_x)
        and is_set(forbidden, high_y, high_x)
    )


@compiled_loop
def segment_allowed(forbidden: Bits, width: int, x: float, y: float, dx: float, dy: float) -> bool:
    """
    Return whether a segment stays in allowed cells all along.

    Parameters
    ----------
    forbidden : ndarray of uint64, shape (height, n)
        The words of a `BitMask`: the forbidden cells.
    width : int
        Width of the map [cells].
    x, y : float
        Start of the segment, on the map [cells].
    dx, dy : float
        Vector to its end [cells].

    Returns
    -------
    bool
        Whether every piece of it lies in an allowed cell or along the edge of one.
    """
    if _is_clear(forbidden, width, x, y, dx, dy):
        return True
    longest = max(abs(dx), abs(dy))
    # The lines that the segment crosses next, counted in the directions in which it goes.
    line_x, line_y = _first_line(x, dx), _first_line(y, dy)
    step_x, step_y = (1.0 if dx > 0.0 else -1.0), (1.0 if dy > 0.0 else -1.0)
    here = 0.0
    while here < 1.0:
        cut_x = (line_x - x) / dx if dx != 0.0 else 1.0
        cut_y = (line_y - y) / dy if dy != 0.0 else 1.0
        there = min(max(min(cut_x, cut_y), 0.0), 1.0)
        # A piece of no length is where the segment touches a corner: the next one decides.
        if (there - here) * longest >= _EPSILON:
            middle = 0.5 * (there + here)
            if not _is_allowed(forbidden, width, x + middle * dx, y + middle * dy):
                return False
        here = there
        if cut_x <= there:
            line_x += step_x
        if cut_y <= there:
            line_y += step_y
    return True


@inlined_part
def _first_line(start: float, step: float) -> float:
    """Return the first line between cells behind a start."""
    return math.floor(start) + 1.0 if step > 0.0 else math.ceil(start) - 1.0


@compiled_part
def _is_clear(forbidden: Bits, width: int, x: float, y: float, dx: float, dy: float) -> bool:
    """Return whether no cell of the box around a segment is forbidden."""
    left = max(math.floor(min(x, x + dx) - _EPSILON), 0)
    right = min(math.floor(max(x, x + dx) + _EPSILON), width - 1)
    bottom = max(math.floor(min(y, y + dy) - _EPSILON), 0)
    top = min(math.floor(max(y, y + dy) + _EPSILON), len(forbidden) - 1)
    first, last = left >> 6, right >> 6
    for row in range(bottom, top + 1):
        for at in range(first, last + 1):
            word = forbidden[row, at]
            if at == first:
                word &= ~np.uint64(0) << np.uint64(left & 63)
            if at == last:
                word &= ~np.uint64(0) >> np.uint64(63 - (right & 63))
            if word != 0:
                return False
    return True
