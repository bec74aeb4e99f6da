"""
Straight moves over the cells, one for each class of headings, and the cells that each touches.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from quad_common.compiled import compiled_part
from quad_planner.outline.heading_kernels import CLASSES, STEP, Integers, class_of
from quad_planner.outline.outline_zones import Zones, fits, is_room
from quad_planner.search.cell_steps import DIAGONAL, STRAIGHT

LONGEST_MOVE = 8
"""Cells that a move goes along an axis, at most: enough for every class."""

_TOUCH = 1e-9
"""Distance within which a move touches a cell [cells]."""

_EDGE = 0.01
"""Part of a cell that places keep from its edge."""


class Moves(NamedTuple):
    """The moves of all classes; their lengths count straight and diagonal steps."""

    x: Integers
    """Cells along x, shape (72,)."""
    y: Integers
    """Cells along y, shape (72,)."""
    length: Integers
    """Shape (72,)."""
    touched: Integers
    """Cells that a move touches, seen from where it begins, x and y, shape (n, 2)."""
    begins: Integers
    """Index of the first of each class, and n, shape (73,)."""


def shortest_offsets() -> list[tuple[int, int]]:
    """Return for each class the shortest move whose heading belongs to it; ties by nearness."""
    best: dict[int, tuple[float, float, int, int]] = {}
    reach = range(-LONGEST_MOVE, LONGEST_MOVE + 1)
    for dy in reach:
        for dx in reach:
            if math.gcd(dx, dy) != 1:
                continue
            heading = math.atan2(dy, dx)
            k = class_of(heading)
            off = abs(math.remainder(heading - k * STEP, 2.0 * math.pi))
            best[k] = min(best.get(k, (math.inf, 0.0, 0, 0)), (dx * dx + dy * dy, off, dx, dy))
    return [best[k][2:] for k in range(CLASSES)]


_OFFSETS = np.array(shortest_offsets())
_LEAST, _MOST = np.abs(_OFFSETS).min(axis=1), np.abs(_OFFSETS).max(axis=1)
_LENGTHS = STRAIGHT * (_MOST - _LEAST) + DIAGONAL * _LEAST

_NEAR = np.array(
    [
        (k, x, y)
        for k, (dx, dy) in enumerate(_OFFSETS.tolist())
        for x in range(min(0, dx) - 1, max(0, dx) + 2)
        for y in range(min(0, dy) - 1, max(0, dy) + 2)
    ]
)
"""Cells that the move of a class may touch: the class, x and y."""


def inside_cell(x: float, y: float) -> tuple[float, float]:
    """Return a place in the same cell that is not on its edge [cells]."""
    within = (min(max(v - math.floor(v), _EDGE), 1.0 - _EDGE) for v in (x, y))
    return math.floor(x) + next(within), math.floor(y) + next(within)


def moves_from(x: float, y: float) -> Moves:
    """
    List the moves over places that lie in their cells as one place does.

    Parameters
    ----------
    x, y : float
        The place, not on the edge of a cell [cells].

    Returns
    -------
    Moves
        The moves.
    """
    x, y = x - math.floor(x), y - math.floor(y)
    k, cell_x, cell_y = _NEAR.T
    dx, dy = _OFFSETS[k].T
    # A segment and a square are apart if an axis separates them: x, y, or the segment's normal.
    from_x, from_y = cell_x + 0.5 - x, cell_y + 0.5 - y
    touched = (
        (np.abs(from_x - 0.5 * dx) <= 0.5 * np.abs(dx) + 0.5 + _TOUCH)
        & (np.abs(from_y - 0.5 * dy) <= 0.5 * np.abs(dy) + 0.5 + _TOUCH)
        & (np.abs(dx * from_y - dy * from_x) <= 0.5 * (np.abs(dx) + np.abs(dy)) + _TOUCH)
    )
    counts = np.bincount(k[touched], minlength=CLASSES)
    return Moves(
        np.ascontiguousarray(_OFFSETS[:, 0]),
        np.ascontiguousarray(_OFFSETS[:, 1]),
        _LENGTHS,
        np.ascontiguousarray(_NEAR[touched, 1:]),
        np.concatenate(([0], np.cumsum(counts))),
    )


@compiled_part
def may_move(zones: Zones, moves: Moves, x: int, y: int, move: int, heading_class: int) -> bool:
    """Return whether the robot fits in all cells that a move from a cell touches."""
    for at in range(moves.begins[move], moves.begins[move + 1]):
        to_x, to_y = x + moves.touched[at, 0], y + moves.touched[at, 1]
        if not (is_room(zones, to_x, to_y) or fits(zones, to_x, to_y, heading_class)):
            return False
    return True


@compiled_part
def is_between_rooms(zones: Zones, moves: Moves, x: int, y: int, move: int) -> bool:
    """Return whether the circle fits in all cells that a move touches."""
    for at in range(moves.begins[move], moves.begins[move + 1]):
        if not is_room(zones, x + moves.touched[at, 0], y + moves.touched[at, 1]):
            return False
    return True
