"""
A flood from the start, or against the moves from the goal: whether a path exists, not which.

A search takes long where there is no path and the start's side of the map is large. The goal's side
is mostly small then: a room, or a niche. A flood that ends without having met the other end has
found out; of a cell and a class it asks once what a search asks for each class to turn from.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, inlined_part
from quad_planner.outline.heading_kernels import CLASSES, Integers
from quad_planner.outline.heading_moves import Moves, is_between_rooms, may_move
from quad_planner.outline.outline_zones import Zones, fits, is_narrow, is_room
from quad_planner.outline.turn_rule import BEND, EITHER_SIDE
from quad_planner.search.search_loop import DONE, FULL, PAUSED

_EIGHTH = CLASSES // 8
_ANY = CLASSES
"""In place of a class: the circle fits, and any heading."""
_STATES = CLASSES + 1

_KNOWN, _FITS, _REACHED = (np.uint8(1 << bit) for bit in range(3))
"""Bits of a class in a cell; the first: whether the second is known."""

_AT_A_TIME = 2_000
"""Number of states between two calls of `check`."""

_MOST_BYTES = 64 << 20
"""Memory of what a flood reached, or of what waits, from which on it is not doubled any more."""

_ROOM_AT_FIRST = 512
_MOST_PUSHES = CLASSES + 1
"""Number of cells that a state leads to at most; to each of them in as many states."""

_MOST_TURNS = 2 * CLASSES
"""Number of classes that are listed at most, to either side."""

_USED, _WAITING, _MET = range(3)
"""Places in `counts`: records in use, states that wait, and whether the other end was met."""


class _Reached(NamedTuple):
    """What is known of the cells that were reached."""

    slots: NDArray[np.int32]
    """Record of each cell, 0 where there is none, shape (height, width)."""
    records: NDArray[np.uint8]
    """Bits of each class, and whether any heading comes, shape (n, 73); number 0 is none."""
    waiting: Integers
    """States that wait, 73 cell + class; the last comes first."""
    counts: Integers
    """Numbers, see `_USED`."""
    turned: Integers
    """Notes of one state: classes to which the robot may turn."""


class Flood:
    """
    A flood from the goal of a request, or from its start.

    From the goal a state is one that the robot comes in, from the start one that it leaves in.

    Parameters
    ----------
    zones : Zones
        The map.
    moves : Moves
        The moves.
    start, goal : tuple of int
        Cells and classes: x, y and class.
    is_forward : bool
        Whether it is from the start.
    """

    def __init__(
        self,
        zones: Zones,
        moves: Moves,
        start: tuple[int, int, int],
        goal: tuple[int, int, int],
        is_forward: bool = False,
    ) -> None:
        self._zones, self._moves, self._is_forward = zones, moves, is_forward
        x, y, k = start
        self._start = np.array([x, y, _ANY if _is_room(zones, x, y) else k])
        self._reached = _Reached(
            np.zeros((zones.height, zones.width), dtype=np.int32),
            np.zeros((_ROOM_AT_FIRST, _STATES), dtype=np.uint8),
            np.empty(4 * _ROOM_AT_FIRST, dtype=np.int64),
            np.array([1, 0, 0]),
            np.empty(_MOST_TURNS, dtype=np.int64),
        )
        self.is_too_large = False
        """Whether it takes too much memory to go on: whether there is a path is not known."""
        self._at_goal = np.zeros(2 + _STATES, dtype=np.int64)
        self._at_goal[:2] = goal[:2]
        _begin(zones, *goal, self._reached, self._at_goal)
        if is_forward:
            _begin_forward(zones, self._start, self._reached, self._at_goal)

    def goes_on(self, states: int, check: Callable[[], None] = lambda: None) -> bool:
        """
        Go on for so many states.

        Parameters
        ----------
        states : int
            Number of states.
        check : callable
            Called now and then; raises to end it.

        Returns
        -------
        bool
            Whether it is over.
        """
        left = states
        while left > 0 and not self.is_too_large:
            check()
            slice_ = min(left, _AT_A_TIME)
            if self._is_forward:
                outcome = _flow(self._zones, self._moves, self._at_goal, self._reached, slice_)
            else:
                outcome = _flood(self._zones, self._moves, self._start, self._reached, slice_)
            if outcome == DONE:
                return True
            if outcome == FULL:
                self._make_room()
            else:
                left -= slice_
        return False

    @property
    def has_met(self) -> bool:
        """Whether the other end was reached: there is a path."""
        return bool(self._reached.counts[_MET])

    def _make_room(self) -> None:
        """Double what is full, unless it is too large already."""
        reached = self._reached
        used = int(reached.counts[_USED])
        name = 'records' if used + _MOST_PUSHES > len(reached.records) else 'waiting'
        full = getattr(reached, name)
        self.is_too_large = full.nbytes >= _MOST_BYTES
        if not self.is_too_large:
            larger = np.concatenate((full, np.zeros_like(full)))
            self._reached = reached._replace(**{name: larger})


@inlined_part
def _record(x: int, y: int, reached: _Reached) -> int:
    """Return the record of a cell, made if there is none; there must be room."""
    record = int(reached.slots[y, x])
    if record == 0:
        record = int(reached.counts[_USED])
        reached.counts[_USED] += 1
        reached.slots[y, x] = record
    return record


@inlined_part
def _come(zones: Zones, x: int, y: int, k: int, reached: _Reached) -> None:
    """Note a state, and let it wait if it is new."""
    record = _record(x, y, reached)
    if not reached.records[record, k] & _REACHED:
        reached.records[record, k] |= _REACHED
        reached.waiting[reached.counts[_WAITING]] = _STATES * (y * zones.width + x) + k
        reached.counts[_WAITING] += 1


@inlined_part
def _fits(zones: Zones, x: int, y: int, k: int, notes: NDArray[np.uint8]) -> bool:
    """Return whether the robot fits in a cell at a class, and note it."""
    if not notes[k] & _KNOWN:
        notes[k] |= _KNOWN | _FITS if fits(zones, x, y, k) else _KNOWN
    return bool(notes[k] & _FITS)


@inlined_part
def _turns(
    zones: Zones, x: int, y: int, k: int, least: int, notes: NDArray[np.uint8], turned: Integers
) -> int:
    """
    List the classes to which the robot may turn from one; return how many.

    It is the rule of :func:`~quad_planner.outline.turn_rule.may_turn`, for all classes at once, and
    the same for those from which it may turn to that one. A turn is of so many classes at least.
    """
    turned[0], count = k, 1
    farthest = 1
    for side in (1, -1):
        step = 1
        while step < CLASSES and _fits(zones, x, y, (k + side * step) % CLASSES, notes):
            if least <= step < EITHER_SIDE:
                turned[count] = (k + side * step) % CLASSES
                count += 1
            step += 1
        farthest = max(farthest, step)
    if farthest < CLASSES:
        return count
    for j in range(CLASSES):
        turned[j] = j
    return CLASSES


@compiled_loop
def _is_room(zones: Zones, x: int, y: int) -> bool:
    return is_room(zones, x, y)


@compiled_loop
def _begin(zones: Zones, x: int, y: int, k: int, reached: _Reached, at_goal: Integers) -> None:
    """Let the states at the goal wait from which the robot has its heading, and list them."""
    if is_room(zones, x, y):
        _come(zones, x, y, _ANY, reached)
        at_goal[2:] = 1
        return
    notes, turned = reached.records[_record(x, y, reached)], reached.turned
    # After it nothing is walked: the turn may be small.
    for at in range(_turns(zones, x, y, k, 1, notes, turned)):
        _come(zones, x, y, turned[at], reached)
        at_goal[2 + turned[at]] = 1


@inlined_part
def _arrive(zones: Zones, x: int, y: int, k: int, reached: _Reached, at_goal: Integers) -> None:
    """Let the states wait in which the robot may leave a cell that it comes to in a class."""
    if x == at_goal[0] and y == at_goal[1] and at_goal[2 + k]:
        reached.counts[_MET] = 1
    elif k == _ANY:
        _come(zones, x, y, _ANY, reached)
    else:
        notes, turned = reached.records[_record(x, y, reached)], reached.turned
        for at in range(_turns(zones, x, y, k, BEND + 1, notes, turned)):
            _come(zones, x, y, turned[at], reached)


@compiled_loop
def _begin_forward(zones: Zones, start: Integers, reached: _Reached, at_goal: Integers) -> None:
    """Let the states at the start wait, and none at the goal."""
    reached.slots[at_goal[1], at_goal[0]] = 0
    reached.counts[_WAITING] = 0
    _arrive(zones, start[0], start[1], start[2], reached, at_goal)


@inlined_part
def _has_room(reached: _Reached) -> bool:
    """Return whether one more state may be gone on from."""
    counts = reached.counts
    return bool(
        counts[_USED] + _MOST_PUSHES <= len(reached.records)
        and counts[_WAITING] + _MOST_PUSHES * CLASSES <= len(reached.waiting)
    )


@inlined_part
def _leads(zones: Zones, moves: Moves, x: int, y: int, move: int) -> bool:
    """Return whether the robot may leave a cell, where it fits in that heading, by a move."""
    to_x, to_y = x + moves.x[move], y + moves.y[move]
    to_room = is_room(zones, to_x, to_y)
    if not (to_room or fits(zones, to_x, to_y, move)):
        return False
    if is_room(zones, x, y) and move % _EIGHTH != 0:
        if not is_narrow(zones, x, y):
            return False
        if to_room and is_between_rooms(zones, moves, x, y, move):
            # Shorter moves lead there.
            return False
    return may_move(zones, moves, x, y, move, move)


@compiled_loop
def _flood(
    zones: Zones,
    moves: Moves,
    start: Integers,
    reached: _Reached,
    states: int,
) -> int:
    """Go on against the moves, for so many states: ``DONE``, ``PAUSED``, or ``FULL``."""
    counts, turned = reached.counts, reached.turned
    for _ in range(states):
        if not _has_room(reached):
            return FULL
        if counts[_WAITING] == 0 or counts[_MET]:
            return DONE
        counts[_WAITING] -= 1
        state = reached.waiting[counts[_WAITING]]
        cell, k = state // _STATES, state % _STATES
        x, y = cell % zones.width, cell // zones.width
        if x == start[0] and y == start[1] and k == start[2]:
            counts[_MET] = 1
            return DONE
        first, last = (0, CLASSES) if k == _ANY else (k, k + 1)
        for j in range(first, last):
            from_x, from_y = x - moves.x[j], y - moves.y[j]
            in_room = is_room(zones, from_x, from_y)
            if not (in_room or fits(zones, from_x, from_y, j)):
                continue
            if not _leads(zones, moves, from_x, from_y, j):
                continue
            if in_room:
                _come(zones, from_x, from_y, _ANY, reached)
                continue
            notes = reached.records[_record(from_x, from_y, reached)]
            for at in range(_turns(zones, from_x, from_y, j, BEND + 1, notes, turned)):
                _come(zones, from_x, from_y, turned[at], reached)
    return PAUSED


@compiled_loop
def _flow(
    zones: Zones,
    moves: Moves,
    at_goal: Integers,
    reached: _Reached,
    states: int,
) -> int:
    """Go on along the moves, for so many states: ``DONE``, ``PAUSED``, or ``FULL``."""
    counts = reached.counts
    for _ in range(states):
        if not _has_room(reached):
            return FULL
        if counts[_WAITING] == 0 or counts[_MET]:
            return DONE
        counts[_WAITING] -= 1
        state = reached.waiting[counts[_WAITING]]
        cell, k = state // _STATES, state % _STATES
        x, y = cell % zones.width, cell // zones.width
        first, last = (0, CLASSES) if k == _ANY else (k, k + 1)
        for j in range(first, last):
            if _leads(zones, moves, x, y, j):
                to_x, to_y = x + moves.x[j], y + moves.y[j]
                arrived = _ANY if is_room(zones, to_x, to_y) else j
                _arrive(zones, to_x, to_y, arrived, reached, at_goal)
    return PAUSED
