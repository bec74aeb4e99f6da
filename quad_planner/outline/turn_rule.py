"""
Which turns on the spot a robot can make where it stands, and be relied on to make.

A follower turns by the short side, so every class between must fit. A turn of nearly half a
circle may go either side, for the heading is never exact. A change of heading of less than 20
degrees may be made while walking, as the follower does: it needs room for every heading.
"""

from __future__ import annotations

from quad_common.compiled import compiled_part
from quad_planner.outline.heading_kernels import CLASSES, Integers

HALF = CLASSES // 2

EITHER_SIDE = HALF - 2
"""Difference of classes from which a turn may go either side."""

BEND = 3
"""Difference of classes up to which the follower may turn while it walks."""


@compiled_part
def may_turn(fitting: Integers, count: int, before: int, after: int, is_last: bool) -> bool:
    """
    Return whether a robot may turn from one class to another.

    Parameters
    ----------
    fitting : ndarray of int, shape (72,)
        1 for each class that fits there.
    count : int
        Number of those that do.
    before, after : int
        The classes.
    is_last : bool
        Whether it is the turn at the goal, after which nothing is walked.
    """
    if count == CLASSES:
        return True
    turn = (after - before + HALF) % CLASSES - HALF
    size = abs(turn)
    if size >= EITHER_SIDE or (0 < size <= BEND and not is_last):
        return False
    side = 1 if turn > 0 else -1
    fits = True
    for step in range(size + 1):
        fits = fits and fitting[(before + side * step) % CLASSES] == 1
    return fits
