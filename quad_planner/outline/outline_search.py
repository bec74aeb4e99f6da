"""
A search over cells and classes of headings, for a robot with an outline.

Where the robot's circle fits a state is a cell: every heading fits there. Elsewhere it is a cell
and the class of the heading in which the robot came. From there it turns as
:mod:`~quad_planner.outline.turn_rule` allows, and moves straight on in its heading. The bound on
what is left is the distance through cells where some heading fits, or may fit; it is heavily
weighted, so paths are found soon and are not the shortest: the legs are chosen afterwards.
Whether there is a path is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from quad_common.compiled import compiled_loop, compiled_part
from quad_planner.grid.array_types import Mask
from quad_planner.grid.bucket_queue import (
    BucketQueue,
    bucket_queue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    push,
    with_room,
)
from quad_planner.outline.flood import Flood
from quad_planner.outline.heading_kernels import CLASSES, Integers
from quad_planner.outline.heading_moves import Moves, is_between_rooms, may_move
from quad_planner.outline.outline_zones import Zones, classes_beside, fits, is_narrow, is_room
from quad_planner.outline.turn_rule import may_turn
from quad_planner.search.cell_steps import STRAIGHT
from quad_planner.search.distance_field import NOT_REACHED, distance_field
from quad_planner.search.search_loop import DONE, FULL, PAUSED

ROOM = CLASSES
"""In place of a class: any heading."""

_STATES = CLASSES + 1
_EIGHTH = CLASSES // 8
_TURN = 24 * STRAIGHT
"""Length that a turn counts."""
_BUCKET = 11
"""Binary logarithm of the width of a bucket of the queue."""
_REACH = 128
"""Buckets ahead that a state is put, at most."""
_WEIGHT = 6
"""Weight of the bound on what is left, in halves."""
_AT_A_TIME = 2_000
"""Number of expansions between two calls of `check`."""
_AT_FIRST = 10_000
"""Number of expansions after which another search has its turn."""
_FLOODED_AT_FIRST = 256
"""Number of states of the flood from the goal before all others: a niche is soon flooded."""
_FLOODED_FOR_EACH = 4
"""States of the flood for one expansion of a search, which takes ten times as long."""
_MOST_PUSHES = CLASSES

_DONE_WITH = -1
"""In place of the length of a state that was gone on from: it is not looked at again."""

_FILLED, _FOUND, _EXPANSIONS = range(3)


class _Detail(NamedTuple):
    """How a search looks at places where the circle does not fit."""

    every: int
    """Number of classes from one direction in which the robot moves there to the next."""
    fraction: int
    """Expansions of another search for one of this."""


_DETAILS = (_Detail(_EIGHTH, 1), _Detail(1, 4))
"""
Searches. Along rows, columns and diagonals alone there are far fewer states; by all directions
every path is found, and it is known if there is none.
"""


class Ends(NamedTuple):
    """Where a search begins and ends."""

    x: int
    """Cell of the start."""
    y: int
    """Cell of the start."""
    heading_class: int
    """Class of the start's heading."""
    goal_x: int
    """Cell of the goal."""
    goal_y: int
    """Cell of the goal."""
    goal_class: int
    """Class of the goal's heading."""
    keeps_heading: bool
    """Whether the robot walks in any direction and keeps the heading of the start."""


class Reached(NamedTuple):
    """What the search knows: a table by open addressing; state = 73 cell + class."""

    states: Integers
    """State of each place plus one, 0 where there is none; as many as a power of 2."""
    lengths: Integers
    """Length of the path to it, as long as it waits."""
    before: Integers
    """State from which it was reached; of the first its own."""
    counts: Integers
    """Places in use, the state at the goal plus one, expansions."""
    fitting: Integers
    """Notes of one expansion: which classes fit."""


def free_for_smallest(inner: Mask) -> Mask:
    """Return which squares of two by two cells hold one that is not forbidden."""
    height, width = inner.shape
    free = np.zeros(((height + 1) // 2 * 2, (width + 1) // 2 * 2), dtype=np.bool_)
    free[:height, :width] = ~inner
    halves = free[0::2] | free[1::2]
    result: Mask = halves[:, 0::2] | halves[:, 1::2]
    return result


def outline_path(
    zones: Zones,
    moves: Moves,
    ends: Ends,
    small: Mask,
    check: Callable[[], None] = lambda: None,
) -> Integers | None:
    """
    Find a path.

    Parameters
    ----------
    zones : Zones
        The map.
    moves : Moves
        The moves.
    ends : Ends
        Start and goal; the robot fits at both.
    small : ndarray of bool
        As of :func:`free_for_smallest`.
    check : callable
        Called now and then; raises to end the search.

    Returns
    -------
    ndarray of int, shape (n, 3), or None
        Cells where its moves begin and end, x and y, and the class there or :data:`ROOM`; None if
        no path leads to the goal.
    """
    left = distance_field(small, (ends.goal_x // 2, ends.goal_y // 2), check)
    if left[ends.y // 2, ends.x // 2] == NOT_REACHED:
        return None
    searches = [_Search(zones, moves, ends, left, detail) for detail in _DETAILS]
    if ends.keeps_heading:
        # It makes no difference: the heading is that of the start.
        searches = searches[-1:]
    # Where the heading is kept there are few states: a search soon knows that there is no path.
    flood = None if ends.keeps_heading else _flood_of(zones, moves, ends)
    expansions, flooded = _AT_FIRST, _FLOODED_AT_FIRST
    while True:
        check()
        if flood is not None and flood.goes_on(flooded, check) and not flood.has_met:
            return None
        if flood is not None and flood.is_too_large:
            # The searches find out without it.
            flood = None
        # In turn, each for longer than before: whichever finds a path soon is not held up for long.
        for search in list(searches):
            if not search.goes_on(expansions, check):
                continue
            path = search.path()
            if path is not None or search is searches[-1]:
                return path
            searches.remove(search)
        flooded = _FLOODED_FOR_EACH * expansions
        expansions *= 2


def _flood_of(zones: Zones, moves: Moves, ends: Ends) -> Flood:
    start = (ends.x, ends.y, ends.heading_class)
    return Flood(zones, moves, start, (ends.goal_x, ends.goal_y, ends.goal_class))


class _Search:
    """A search that can be left for others, and gone on with."""

    def __init__(
        self, zones: Zones, moves: Moves, ends: Ends, left: Integers, detail: _Detail
    ) -> None:
        self._zones, self._moves, self._ends = zones, moves, ends
        self._left, self._detail = left, detail
        # Small, so that a warm-up makes it grow too.
        self._reached = _table(1 << 9)
        self._queue = bucket_queue(_REACH)
        _begin(zones, ends, left, self._reached, self._queue)

    def goes_on(self, expansions: int, check: Callable[[], None]) -> bool:
        """Go on with it for so many expansions; return whether it is over."""
        until = int(self._reached.counts[_EXPANSIONS]) + expansions // self._detail.fraction
        while int(self._reached.counts[_EXPANSIONS]) < until:
            if 3 * int(self._reached.counts[_FILLED]) > len(self._reached.states):
                larger = _table(4 * len(self._reached.states))
                _copy(self._reached, larger)
                self._reached = larger
            outcome = _search(
                self._detail.every,
                self._zones,
                self._moves,
                self._ends,
                self._left,
                self._reached,
                self._queue,
            )
            if outcome == DONE:
                return True
            if outcome == FULL:
                self._queue = with_room(self._queue, len(self._queue.entries))
            check()
        return False

    def path(self) -> Integers | None:
        """Return the path of a search that is over; None if there is none."""
        last = int(self._reached.counts[_FOUND]) - 1
        return None if last < 0 else _path_to(last, self._zones.width, self._reached)


def _table(size: int) -> Reached:
    return Reached(
        np.zeros(size, dtype=np.int64),
        np.empty(size, dtype=np.int64),
        np.empty(size, dtype=np.int64),
        np.zeros(3, dtype=np.int64),
        np.empty(CLASSES, dtype=np.int64),
    )


@compiled_part
def _place(states: Integers, state: int) -> int:
    """Return the place of a state in the table, or the one where it is to be."""
    mask = len(states) - 1
    at = (state * 0x9E3779B1 ^ state >> 7) & mask
    while states[at] != 0 and states[at] != state + 1:
        at = (at + 1) & mask
    return at


@compiled_loop
def _copy(old: Reached, new: Reached) -> None:
    """Put all states into a larger table."""
    for at in range(len(old.states)):
        if old.states[at]:
            place = _place(new.states, old.states[at] - 1)
            new.states[place] = old.states[at]
            new.lengths[place] = old.lengths[at]
            new.before[place] = old.before[at]
    for at in range(len(old.counts)):
        new.counts[at] = old.counts[at]


@compiled_part
def _reach(
    state: int, length: int, before: int, ahead: int, reached: Reached, queue: BucketQueue
) -> None:
    """Note a path to a state if it is the shortest so far, and let the state wait."""
    at = _place(reached.states, state)
    if reached.states[at]:
        if reached.lengths[at] <= length:
            return
    else:
        reached.states[at] = state + 1
        reached.counts[_FILLED] += 1
    reached.lengths[at] = length
    reached.before[at] = before
    first = queue.state[0]
    bucket = (length + ahead) >> _BUCKET
    bucket = min(max(bucket, first), first + _REACH)
    push(queue.heads, queue.entries, queue.state, state, length, bucket)


@compiled_loop
def _begin(zones: Zones, ends: Ends, left: Integers, reached: Reached, queue: BucketQueue) -> None:
    """Let the start wait."""
    in_room = is_room(zones, ends.x, ends.y) and not ends.keeps_heading
    state = _STATES * (ends.y * zones.width + ends.x)
    state += ROOM if in_room else ends.heading_class
    # The queue's first bucket is that of the start.
    ahead = _WEIGHT * left[ends.y >> 1, ends.x >> 1]
    queue.state[0] = ahead >> _BUCKET
    _reach(state, 0, state, ahead, reached, queue)


@compiled_loop
def _search(
    every: int,
    zones: Zones,
    moves: Moves,
    ends: Ends,
    left: Integers,
    reached: Reached,
    queue: BucketQueue,
) -> int:
    """
    Go on with a search for a while.

    Returns ``DONE``, ``PAUSED``, or ``FULL`` if the queue must grow.
    """
    fitting = reached.fitting
    for _ in range(_AT_A_TIME):
        if is_empty(queue.state):
            return DONE
        if not has_room(queue.entries, queue.state, _MOST_PUSHES):
            return FULL
        if 2 * (reached.counts[_FILLED] + _MOST_PUSHES) > len(reached.states):
            return PAUSED
        next_bucket(queue.heads, queue.state)
        state, length = pop(queue.heads, queue.entries, queue.state)
        at = _place(reached.states, state)
        if reached.lengths[at] != length:
            continue
        reached.lengths[at] = _DONE_WITH
        reached.counts[_EXPANSIONS] += 1
        cell, k = state // _STATES, state % _STATES
        x, y = cell % zones.width, cell // zones.width
        count = CLASSES
        if k == ROOM:
            fitting[:] = 1
        elif (x == ends.goal_x and y == ends.goal_y) or not ends.keeps_heading:
            count = classes_beside(zones, x, y, k, fitting)
        is_at_goal = x == ends.goal_x and y == ends.goal_y
        if is_at_goal and (k == ROOM or may_turn(fitting, count, k, ends.goal_class, True)):
            reached.counts[_FOUND] = state + 1
            return DONE
        stride = every
        if ends.keeps_heading or (k == ROOM and not is_narrow(zones, x, y)):
            stride = _EIGHTH
        for j in range(0, CLASSES, stride):
            heading = j
            turn = 0
            if ends.keeps_heading:
                heading = k
            elif k != ROOM:
                if not may_turn(fitting, count, k, j, False):
                    continue
                turn = 0 if j == k else _TURN
            to_x, to_y = x + moves.x[j], y + moves.y[j]
            if not (is_room(zones, to_x, to_y) or fits(zones, to_x, to_y, heading)):
                continue
            goes_to_room = is_room(zones, to_x, to_y) and not ends.keeps_heading
            is_long = k == ROOM and goes_to_room and j % _EIGHTH != 0
            if is_long and is_between_rooms(zones, moves, x, y, j):
                # Shorter moves lead there.
                continue
            rest = left[to_y >> 1, to_x >> 1]
            if rest == NOT_REACHED or not may_move(zones, moves, x, y, j, heading):
                continue
            other = _STATES * (to_y * zones.width + to_x) + (ROOM if goes_to_room else heading)
            _reach(
                other,
                length + turn + moves.length[j],
                state,
                _WEIGHT * rest,
                reached,
                queue,
            )
    return PAUSED


def _path_to(last: int, width: int, reached: Reached) -> Integers:
    """Go back from a state; return the cells of the path to it."""
    places = []
    state, before = last, -1
    while state != before:
        cell = state // _STATES
        places.append((cell % width, cell // width, state % _STATES))
        before = state
        state = int(reached.before[_place(reached.states, state)])
    return np.array(places[::-1])
