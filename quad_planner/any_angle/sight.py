"""
What is seen from a point of the free cells: corners, through opening after opening.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, inlined_part
from quad_planner.any_angle.intervals import (
    INTERVAL,
    crossing,
    least_through,
    neighbour,
    neighbours,
    opening_part,
)
from quad_planner.any_angle.rectangles import BOTTOM, TOP, Rectangles

Floats = NDArray[np.float64]
Integers = NDArray[np.int64]
Records = NDArray[np.void]


class Sight:
    """
    A look-out on some of the corners.

    Parameters
    ----------
    rectangles : Rectangles
        The free cells.
    numbers : ndarray of int, shape (4 n,)
        Number that is reported for each corner, or -1 if it is not wanted.
    """

    def __init__(self, rectangles: Rectangles, numbers: Integers) -> None:
        self._rectangles = rectangles
        self._numbers = numbers
        self._waiting = np.empty(1024, dtype=INTERVAL)
        self._seen = np.empty(1024, dtype=np.int64)

    def seen_from(self, rectangle: int, target: Floats) -> Integers:
        """
        List what a point sees.

        Parameters
        ----------
        rectangle : int
            Rectangle that holds the point, or has it on its edge.
        target : ndarray, shape (5,)
            The point, another point, and the greatest length of a path from the one to the
            other: what is not on a path that is as short may be left out [cells].

        Returns
        -------
        ndarray of int
            Numbers of corners, each once; not of those that are seen only past another one.
        """
        while True:
            count = _look(
                self._rectangles, self._numbers, rectangle, target, self._waiting, self._seen
            )
            if count >= 0:
                return np.unique(self._seen[:count])
            self._waiting = np.empty(2 * len(self._waiting), dtype=INTERVAL)
            self._seen = np.empty(2 * len(self._seen), dtype=np.int64)


@compiled
def _look(
    rectangles: Rectangles,
    numbers: Integers,
    rectangle: int,
    target: Floats,
    waiting: Records,
    seen: Integers,
) -> int:
    """Fill `seen`, and return how many; -1 if there is no room."""
    x, y = target[0], target[1]
    counts = np.zeros(2, dtype=np.int64)
    # Sides that are seen of one rectangle: whether the upper one, and from where to where.
    spans = np.empty((3, 3))
    spans[0, 0], spans[0, 1], spans[0, 2] = 1.0, -np.inf, np.inf
    spans[1, 0], spans[1, 1], spans[1, 2] = 0.0, -np.inf, np.inf
    here, sides = rectangle, 2
    while True:
        for k in range(sides):
            is_up = spans[k, 0] != 0.0
            span = (spans[k, 1], spans[k, 2])
            if not _pass_on(rectangles, numbers, here, is_up, span, target, waiting, seen, counts):
                return -1
        if counts[0] == 0:
            break
        counts[0] -= 1
        interval = waiting[counts[0]]
        here, is_up, sides = interval.rectangle, interval.is_up != 0, 1
        left, right = interval.left, interval.right
        near = float(rectangles.bounds[here, BOTTOM if is_up else TOP])
        far = float(rectangles.bounds[here, TOP if is_up else BOTTOM])
        spans[0, 0] = 1.0 if is_up else 0.0
        if y != near:
            spans[0, 1] = crossing(x, y, left, near, far)
            spans[0, 2] = crossing(x, y, right, near, far)
        elif left <= x <= right:
            # In the opening: all of the rectangle is seen.
            spans[0, 1], spans[0, 2], sides = -np.inf, np.inf, 3
            spans[1, 0] = spans[2, 0] = 0.0 if is_up else 1.0
            spans[1, 1], spans[1, 2] = -np.inf, left - 0.5
            spans[2, 1], spans[2, 2] = right + 0.5, np.inf
        else:
            # Along the side nothing is seen past the opening's end, which is noted.
            sides = 0
    return int(counts[1])


@inlined_part
def _pass_on(
    rectangles: Rectangles,
    numbers: Integers,
    here: int,
    is_up: bool,
    span: tuple[float, float],
    target: Floats,
    waiting: Records,
    seen: Integers,
    counts: Integers,
) -> bool:
    """Look through the openings of a rectangle's side; return whether there was room."""
    line = float(rectangles.bounds[here, TOP if is_up else BOTTOM])
    first, last = neighbours(rectangles, here, is_up)
    if counts[0] + last - first > len(waiting) or counts[1] + 2 * (last - first) > len(seen):
        return False
    for at in range(first, last):
        there = neighbour(rectangles, at, is_up)
        left, right, left_corner, right_corner = opening_part(
            rectangles, here, there, is_up, span[0], span[1]
        )
        if left > right:
            continue
        length = least_through(target[0], target[1], left, right, line, is_up, target[2], target[3])
        if length > target[4]:
            continue
        for corner in (left_corner, right_corner):
            if corner >= 0 and numbers[corner] >= 0:
                seen[counts[1]] = numbers[corner]
                counts[1] += 1
        interval = waiting[counts[0]]
        interval.left, interval.right = left, right
        interval.rectangle, interval.is_up = there, is_up
        counts[0] += 1
    return True
