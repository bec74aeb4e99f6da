"""
What is seen from a point of the free cells: corners, through opening after opening.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part, inlined_part
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


_AT_A_TIME = 256
"""Number of points that are looked from between two calls of `check`."""

_WAITING, _SEEN, _LOOKS = range(3)
"""Places in `counts`: intervals that wait, corners that are seen, and looks so far."""


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
        self._seen: Integers = np.empty(4096, dtype=np.int64)

    def seen_from(
        self, places: Integers, targets: Floats, check: Callable[[], None] = lambda: None
    ) -> tuple[Integers, Integers]:
        """
        List what points see.

        Parameters
        ----------
        places : ndarray of int, shape (m,)
            Rectangle that holds each point, or has it on its edge.
        targets : ndarray, shape (m, 5)
            Each point, another point, and the greatest length of a path from the one to the
            other: what is not on a path that is as short may be left out [cells].
        check : callable
            Called now and then; raises to end it.

        Returns
        -------
        tuple of ndarray of int
            Points, in rising order, and numbers of the corners that they see, each once for a
            point; not of those that are seen only past another one.
        """
        marks = np.zeros(int(self._numbers.max(initial=-1)) + 1, dtype=np.int64)
        counts, lasts = np.zeros(3, dtype=np.int64), np.empty(len(places), dtype=np.int64)
        done = 0
        while done < len(places):
            check()
            until = min(done + _AT_A_TIME, len(places))
            reached = _look_from(
                self._rectangles,
                (self._numbers, marks, counts, np.empty((3, 3))),
                places[:until],
                targets,
                self._waiting,
                self._seen,
                lasts,
                done,
            )
            if reached < until:
                self._waiting = np.empty(2 * len(self._waiting), dtype=INTERVAL)
                self._seen = np.concatenate((self._seen, np.empty_like(self._seen)))
            done = reached
        points = np.repeat(np.arange(len(places)), np.diff(lasts, prepend=0))
        return points, self._seen[: len(points)].copy()


@compiled_loop
def _look_from(
    rectangles: Rectangles,
    notes: tuple[Integers, Integers, Integers, Floats],
    places: Integers,
    targets: Floats,
    waiting: Records,
    seen: Integers,
    lasts: Integers,
    first: int,
) -> int:
    """Look from points, from the first one on; return the first for which there was no room."""
    counts = notes[2]
    for at in range(first, len(places)):
        before = counts[_SEEN]
        counts[_LOOKS] += 1
        if not _look(rectangles, notes, places[at], targets[at], waiting, seen):
            counts[_SEEN] = before
            return at
        lasts[at] = counts[_SEEN]
    return len(places)


@compiled_part
def _look(
    rectangles: Rectangles,
    notes: tuple[Integers, Integers, Integers, Floats],
    rectangle: int,
    target: Floats,
    waiting: Records,
    seen: Integers,
) -> bool:
    """Look from one point; return whether there was room."""
    # The last: sides seen of one rectangle, whether the upper one, and from where to where.
    numbers, marks, counts, spans = notes
    counts[_WAITING] = 0
    x, y = target[0], target[1]
    spans[0, 0], spans[0, 1], spans[0, 2] = 1.0, -np.inf, np.inf
    spans[1, 0], spans[1, 1], spans[1, 2] = 0.0, -np.inf, np.inf
    here, sides = rectangle, 2
    while True:
        for k in range(sides):
            is_up = spans[k, 0] != 0.0
            span = (spans[k, 1], spans[k, 2])
            if not _pass_on(
                rectangles, numbers, here, is_up, span, target, waiting, seen, marks, counts
            ):
                return False
        if counts[_WAITING] == 0:
            break
        counts[_WAITING] -= 1
        interval = waiting[counts[_WAITING]]
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
    return True


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
    marks: Integers,
    counts: Integers,
) -> bool:
    """Look through the openings of a rectangle's side; return whether there was room."""
    line = float(rectangles.bounds[here, TOP if is_up else BOTTOM])
    first, last = neighbours(rectangles, here, is_up)
    count = last - first
    if counts[_WAITING] + count > len(waiting) or counts[_SEEN] + 2 * count > len(seen):
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
            if corner < 0 or numbers[corner] < 0:
                continue
            number = numbers[corner]
            if marks[number] != counts[_LOOKS]:
                marks[number] = counts[_LOOKS]
                seen[counts[_SEEN]] = number
                counts[_SEEN] += 1
        interval = waiting[counts[_WAITING]]
        interval.left, interval.right = left, right
        interval.rectangle, interval.is_up = there, is_up
        counts[_WAITING] += 1
    return True
