"""
A queue of cells that is sorted by buckets: none of a bucket leaves before the one before is empty.

It is for searches whose keys grow by a bounded step: the buckets form a ring. Within a
bucket the last comes first, so a search must bear to see a cell again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import inlined_part

Integers = NDArray[np.int64]

_CELL, _KEY, _NEXT = range(3)
_BUCKET, _WAITING, _USED, _FREE = range(4)


class BucketQueue(NamedTuple):
    """The arrays of a queue; compiled code is given one by one, which is faster."""

    heads: Integers
    """The first entry of each bucket, or -1; as many as a power of 2."""
    entries: Integers
    """Cell, key, and the next entry of the same bucket, shape (n, 3)."""
    state: Integers
    """Bucket that is being emptied, cells that wait, entries in use, first free entry."""


def bucket_queue(reach: int) -> BucketQueue:
    """
    Make an empty queue.

    Parameters
    ----------
    reach : int
        Largest number of buckets ahead that a cell is put.

    Returns
    -------
    BucketQueue
        A queue with room for a few thousand cells.
    """
    return BucketQueue(
        heads=np.full(1 << (reach + 1).bit_length(), -1, dtype=np.int64),
        entries=np.empty((4096, 3), dtype=np.int64),
        state=np.array([0, 0, 0, -1], dtype=np.int64),
    )


def with_room(queue: BucketQueue, pushes: int) -> BucketQueue:
    """Return the queue with room for so many more entries."""
    entries = queue.entries
    while int(queue.state[_USED]) + pushes > len(entries):
        entries = np.concatenate((entries, np.empty_like(entries)))
    return queue._replace(entries=entries)


@inlined_part
def has_room(entries: Integers, state: Integers, pushes: int) -> bool:
    """Return whether so many cells may be pushed."""
    return bool(state[_USED] + pushes <= len(entries))


@inlined_part
def is_empty(state: Integers) -> bool:
    """Return whether no cell waits."""
    return bool(state[_WAITING] == 0)


@inlined_part
def push(
    heads: Integers, entries: Integers, state: Integers, cell: int, key: int, bucket: int
) -> None:
    """Let a cell wait, with a number that comes back with it; there must be room."""
    entry = state[_FREE]
    if entry >= 0:
        state[_FREE] = entries[entry, _NEXT]
    else:
        entry = state[_USED]
        state[_USED] += 1
    place = bucket & (len(heads) - 1)
    entries[entry, _CELL] = cell
    entries[entry, _KEY] = key
    entries[entry, _NEXT] = heads[place]
    heads[place] = entry
    state[_WAITING] += 1


@inlined_part
def next_bucket(heads: Integers, state: Integers) -> int:
    """Return the first bucket that has a cell; there must be one."""
    while heads[state[_BUCKET] & (len(heads) - 1)] < 0:
        state[_BUCKET] += 1
    return int(state[_BUCKET])


@inlined_part
def pop(heads: Integers, entries: Integers, state: Integers) -> tuple[int, int]:
    """Take a cell of the first bucket that has one: the cell, and the number that came with it."""
    place = next_bucket(heads, state) & (len(heads) - 1)
    entry = heads[place]
    heads[place] = entries[entry, _NEXT]
    entries[entry, _NEXT] = state[_FREE]
    state[_FREE] = entry
    state[_WAITING] -= 1
    return int(entries[entry, _CELL]), int(entries[entry, _KEY])
