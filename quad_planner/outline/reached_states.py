"""
States that a search has reached, and those of them that wait.

They are in a table by open addressing: of the cells of a map times the classes of headings few are
reached.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from quad_common.compiled import compiled_loop, compiled_part
from quad_planner.grid.array_types import Mask
from quad_planner.grid.bucket_queue import BucketQueue, bucket_queue, push, with_room
from quad_planner.outline.heading_kernels import CLASSES, Integers

STATES = CLASSES + 1
"""Number of states of a cell."""

DONE_WITH = -1
"""In place of the length of a state that was gone on from: it is not looked at again."""

FILLED, FOUND, EXPANSIONS = range(3)
"""Places in `counts`."""

_BUCKET = 11
"""Binary logarithm of the width of a bucket of the queue."""
_REACH = 4095
"""Buckets ahead that a state is put, at most."""
_WEIGHT = 6
"""Weight of the bound on what is left, in halves."""


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


def table_of(size: int) -> Reached:
    """Make an empty table of so many places, a power of 2."""
    return Reached(
        np.zeros(size, dtype=np.int64),
        np.empty(size, dtype=np.int64),
        np.empty(size, dtype=np.int64),
        np.zeros(3, dtype=np.int64),
        np.empty(CLASSES, dtype=np.int64),
    )


@compiled_part
def place(states: Integers, state: int) -> int:
    """Return the place of a state in the table, or the one where it is to be."""
    mask = len(states) - 1
    at = (state * 0x9E3779B1 ^ state >> 7) & mask
    while states[at] != 0 and states[at] != state + 1:
        at = (at + 1) & mask
    return at


@compiled_loop
def copy_states(old: Reached, new: Reached) -> None:
    """Put all states into a larger table."""
    for at in range(len(old.states)):
        if old.states[at]:
            to = place(new.states, old.states[at] - 1)
            new.states[to] = old.states[at]
            new.lengths[to] = old.lengths[at]
            new.before[to] = old.before[at]
    for at in range(len(old.counts)):
        new.counts[at] = old.counts[at]


@compiled_part
def reach(
    state: int, length: int, before: int, left: int, reached: Reached, queue: BucketQueue
) -> None:
    """
    Note a path to a state if it is the shortest so far, and let the state wait.

    Parameters
    ----------
    state, length, before : int
        The state, the length of the path, and the state before it.
    left : int
        Bound on the length of what is left, of squares of two by two cells.
    reached : Reached
        The table; it must have room.
    queue : BucketQueue
        Those that wait; it must have room.
    """
    at = place(reached.states, state)
    if reached.states[at]:
        if reached.lengths[at] <= length:
            return
    else:
        reached.states[at] = state + 1
        reached.counts[FILLED] += 1
    reached.lengths[at] = length
    reached.before[at] = before
    first = queue.state[0]
    bucket = (length + _WEIGHT * left) >> _BUCKET
    bucket = min(max(bucket, first), first + _REACH)
    push(queue.heads, queue.entries, queue.state, state, length, bucket)


@compiled_loop
def leave_out(reached: Reached, width: int, allowed: Mask) -> None:
    """Leave out squares with states that were gone on from, unless others wait there."""
    for is_waiting in (False, True):
        for at in range(len(reached.states)):
            if reached.states[at] and (reached.lengths[at] != DONE_WITH) == is_waiting:
                cell = (reached.states[at] - 1) // STATES
                allowed[cell // width >> 1, cell % width >> 1] = is_waiting


def queue_of(reached: Reached, width: int, left: Integers) -> BucketQueue:
    """
    Let all states of a table that were not gone on from wait.

    Parameters
    ----------
    reached : Reached
        The table.
    width : int
        Width of the map [cells].
    left : ndarray of int
        Bound on the length of what is left from each square of two by two cells.

    Returns
    -------
    BucketQueue
        With room for a few thousand more.
    """
    queue = with_room(bucket_queue(_REACH), int(reached.counts[FILLED]))
    _wait_again(reached, width, left, queue)
    return queue


@compiled_loop
def _wait_again(reached: Reached, width: int, left: Integers, queue: BucketQueue) -> None:
    """Let all states that wait do so in an empty queue, by another bound on what is left."""
    first = np.int64(1 << 62)
    for is_sorted in (False, True):
        for at in range(len(reached.states)):
            if not reached.states[at] or reached.lengths[at] == DONE_WITH:
                continue
            state, length = reached.states[at] - 1, reached.lengths[at]
            cell = state // STATES
            ahead = _WEIGHT * left[cell // width >> 1, cell % width >> 1]
            bucket = (length + ahead) >> _BUCKET
            if is_sorted:
                bucket = min(bucket, first + _REACH)
                push(queue.heads, queue.entries, queue.state, state, length, bucket)
            else:
                first = min(first, bucket)
        queue.state[0] = first
