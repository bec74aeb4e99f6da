"""
A search over cells and classes of headings, for a robot with an outline.

Where the robot's circle fits a state is a cell: every heading fits there. Elsewhere it is a cell
and the class of the heading in which the robot came. From there it turns as
:mod:`~quad_planner.outline.turn_rule` allows, and moves straight on in its heading. The bound on
what is left is the distance through cells where some heading fits, or may fit; it is heavily
weighted, so paths are found soon and are not the shortest: the legs are chosen afterwards.
Where it leads to a corner in which the robot cannot turn, the search fills all that is before the
corner. So the bound is corrected now and then: it is measured without the cells that were gone on
from, and so along paths that are left. Whether there is a path is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from quad_common.compiled import compiled_loop
from quad_planner.grid.array_types import Mask
from quad_planner.grid.bucket_queue import (
    BucketQueue,
    has_room,
    is_empty,
    next_bucket,
    pop,
    with_room,
)
from quad_planner.outline.flood import Flood
from quad_planner.outline.heading_kernels import CLASSES, Integers
from quad_planner.outline.heading_moves import Moves, is_between_rooms, may_move
from quad_planner.outline.outline_zones import Zones, classes_beside, fits, is_narrow, is_room
from quad_planner.outline.reached_states import (
    DONE_WITH,
    EXPANSIONS,
    FILLED,
    FOUND,
    STATES,
    Reached,
    copy_states,
    leave_out,
    place,
    queue_of,
    reach,
    table_of,
)
from quad_planner.outline.turn_rule import may_turn
from quad_planner.search.cell_steps import STRAIGHT
from quad_planner.search.distance_field import NOT_REACHED, distance_field
from quad_planner.search.search_loop import DONE, FULL, PAUSED

ROOM = CLASSES
"""In place of a class: any heading."""

_EIGHTH = CLASSES // 8
_TURN = 24 * STRAIGHT
"""Length that a turn counts."""
_AT_A_TIME = 2_000
"""Number of expansions between two calls of `check`."""
_AT_FIRST = 20_000
"""Number of expansions after which another search has its turn."""
_FLOODED_AT_ONCE = 256
"""Number of states of each flood before all others: a niche is soon flooded."""
_FLOODED_AT_FIRST = 24_000
"""Number of states of each flood after the first search has had its turn."""
_MOST_PUSHES = CLASSES
_CORRECTED_AFTER = 2_000
"""Number of expansions, at least, between two corrections of the bound on what is left."""
_SEEN_BEFORE = 300 * STRAIGHT
"""Length that is added to the bound where the search has been all around: two cells count one."""


class Detail(NamedTuple):
    """How a search looks at places where the circle does not fit."""

    every: int
    """Number of classes from one direction in which the robot moves there to the next."""
    fraction: int
    """Expansions of another search for one of this."""


DETAILS = (Detail(_EIGHTH, 1), Detail(1, 4))
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
    searches = [Search(zones, moves, ends, left, small, detail) for detail in DETAILS]
    if ends.keeps_heading:
        # It makes no difference: the heading is that of the start.
        searches = searches[-1:]
    # Where the heading is kept there are few states: a search soon knows that there is no path.
    floods = [] if ends.keeps_heading else _floods_of(zones, moves, ends)
    if _have_ended(floods, _FLOODED_AT_ONCE, check):
        return None
    expansions, flooded = _AT_FIRST, _FLOODED_AT_FIRST
    while True:
        check()
        # In turn, each for longer than before: whichever finds a path soon is not held up for long.
        for search in list(searches):
            if search.goes_on(expansions, check):
                path = search.path()
                if path is not None or search is searches[-1]:
                    return path
                searches.remove(search)
            if _have_ended(floods, flooded, check):
                return None
        expansions *= 2
        flooded *= 4


def _have_ended(floods: list[Flood], states: int, check: Callable[[], None]) -> bool:
    """Go on with floods for so many states each; return whether one has found no path."""
    for flood in list(floods):
        if flood.goes_on(states, check) and not flood.has_met:
            return True
        if flood.has_met or flood.is_too_large:
            # There is a path, or the searches find out without it.
            floods.remove(flood)
    return False


def _floods_of(zones: Zones, moves: Moves, ends: Ends) -> list[Flood]:
    """Make a flood from either end."""
    start = (ends.x, ends.y, ends.heading_class)
    goal = (ends.goal_x, ends.goal_y, ends.goal_class)
    return [Flood(zones, moves, start, goal, is_forward) for is_forward in (False, True)]


class Search:
    """
    A search that can be left for others, and gone on with.

    Parameters
    ----------
    zones, moves, ends, small
        As of :func:`outline_path`.
    left : ndarray of int
        Distance of the squares of `small` from the goal's, as of
        :func:`~quad_planner.search.distance_field.distance_field`.
    detail : Detail
        How it looks at places where the circle does not fit.
    """

    def __init__(
        self,
        zones: Zones,
        moves: Moves,
        ends: Ends,
        left: Integers,
        small: Mask,
        detail: Detail,
    ) -> None:
        self._zones, self._moves, self._ends, self._detail = zones, moves, ends, detail
        self._small = small
        self._uncorrected = self._left = left
        self._corrected_at = _CORRECTED_AFTER
        # Small, so that a warm-up makes it grow too.
        self._reached = table_of(1 << 9)
        _begin(zones, ends, self._reached)
        self._queue = queue_of(self._reached, zones.width, left)

    def goes_on(self, expansions: int, check: Callable[[], None]) -> bool:
        """Go on with it for so many expansions; return whether it is over."""
        until = self.expansions + expansions // self._detail.fraction
        while self.expansions < until:
            if 3 * int(self._reached.counts[FILLED]) > len(self._reached.states):
                larger = table_of(4 * len(self._reached.states))
                copy_states(self._reached, larger)
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
            if self.expansions >= self._corrected_at:
                self._correct(check)
            check()
        return False

    def _correct(self, check: Callable[[], None]) -> None:
        """Measure what is left without what was gone on from, and sort what waits by it."""
        self._corrected_at = self.expansions + max(_CORRECTED_AFTER, self.expansions // 4)
        allowed = self._small.copy()
        leave_out(self._reached, self._zones.width, allowed)
        left = distance_field(allowed, (self._ends.goal_x // 2, self._ends.goal_y // 2), check)
        # What is left out for the bound is not known to be of no use.
        further = np.where(self._uncorrected == NOT_REACHED, 0, _SEEN_BEFORE) + self._uncorrected
        self._left = np.where(left == NOT_REACHED, further, left)
        self._queue = queue_of(self._reached, self._zones.width, self._left)

    @property
    def expansions(self) -> int:
        """Number of states that were gone on from."""
        return int(self._reached.counts[EXPANSIONS])

    def path(self) -> Integers | None:
        """Return the path of a search that is over; None if there is none."""
        last = int(self._reached.counts[FOUND]) - 1
        return None if last < 0 else _path_to(last, self._zones.width, self._reached)


@compiled_loop
def _begin(zones: Zones, ends: Ends, reached: Reached) -> None:
    """Note the start in an empty table."""
    in_room = is_room(zones, ends.x, ends.y) and not ends.keeps_heading
    state = STATES * (ends.y * zones.width + ends.x)
    state += ROOM if in_room else ends.heading_class
    at = place(reached.states, state)
    reached.states[at] = state + 1
    reached.lengths[at] = 0
    reached.before[at] = state
    reached.counts[FILLED] = 1


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
        if 2 * (reached.counts[FILLED] + _MOST_PUSHES) > len(reached.states):
            return PAUSED
        next_bucket(queue.heads, queue.state)
        state, length = pop(queue.heads, queue.entries, queue.state)
        at = place(reached.states, state)
        if reached.lengths[at] != length:
            continue
        reached.lengths[at] = DONE_WITH
        reached.counts[EXPANSIONS] += 1
        cell, k = state // STATES, state % STATES
        x, y = cell % zones.width, cell // zones.width
        count = CLASSES
        if k == ROOM:
            fitting[:] = 1
        elif (x == ends.goal_x and y == ends.goal_y) or not ends.keeps_heading:
            count = classes_beside(zones, x, y, k, fitting)
        is_at_goal = x == ends.goal_x and y == ends.goal_y
        if is_at_goal and (k == ROOM or may_turn(fitting, count, k, ends.goal_class, True)):
            reached.counts[FOUND] = state + 1
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
            other = STATES * (to_y * zones.width + to_x) + (ROOM if goes_to_room else heading)
            reach(
                other,
                length + turn + moves.length[j],
                state,
                rest,
                reached,
                queue,
            )
    return PAUSED


def _path_to(last: int, width: int, reached: Reached) -> Integers:
    """Go back from a state; return the cells of the path to it."""
    places = []
    state, before = last, -1
    while state != before:
        cell = state // STATES
        places.append((cell % width, cell // width, state % STATES))
        before = state
        state = int(reached.before[place(reached.states, state)])
    return np.array(places[::-1])
