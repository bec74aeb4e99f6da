"""
What a search over cells and headings knows of the cells that it has reached.

A record of 64 bytes, one line of a processor's cache, is made for a cell when it is first
reached: so memory is as large as the search, whatever the map's size.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import inlined_part

Integers = NDArray[np.int64]

_ROOM_AT_FIRST = 8192

_LINE = 8
"""Size of a record, in words of 64 bits."""

_HEADINGS = 8
_BY, _REST, _CELL = 4, 5, 6
"""Words of a record: 0 to 3 are costs, 7 is not used."""


class LatticeStates(NamedTuple):
    """Records; state 8 r + k is the cell of record r, reached by a step in heading k."""

    records: Integers
    """Records one after another, shape (8 n,); number 0 is none."""
    costs: NDArray[np.int32]
    """The same records, as numbers of 32 bits."""
    by: NDArray[np.uint8]
    """The same records, as bytes."""
    slots: NDArray[np.int32]
    """Record of each cell, 0 where it is not reached."""
    used: Integers
    """Number of records in use, shape (1,)."""


def lattice_states(cells: int) -> LatticeStates:
    """Return states of a map of so many cells, of which none is reached."""
    records = np.empty(_LINE * _ROOM_AT_FIRST, dtype=np.int64)
    slots = np.zeros(cells, dtype=np.int32)
    return LatticeStates(records, records.view(np.int32), records.view(np.uint8), slots, np.ones(1, np.int64))


def with_records(states: LatticeStates, more: int) -> LatticeStates:
    """Return the same states with room for so many more cells, which are few."""
    if has_records(states.records, states.used, more):
        return states
    records = np.concatenate((states.records, np.empty_like(states.records)))
    return LatticeStates(
        records, records.view(np.int32), records.view(np.uint8), states.slots, states.used
    )


@inlined_part
def has_records(records: Integers, used: Integers, more: int) -> bool:
    """Return whether so many more cells may be reached."""
    return bool(_LINE * (used[0] + more) <= len(records))


@inlined_part
def record_of(records: Integers, slots: NDArray[np.int32], used: Integers, cell: int) -> int:
    """Return a cell's record, made if there is none; there must be room."""
    record = int(slots[cell])
    if record == 0:
        record = int(used[0])
        used[0] += 1
        slots[cell] = record
        first = _LINE * record
        for at in range(_LINE):
            records[first + at] = 0
        records[first + _CELL] = cell
    return record


@inlined_part
def cell_of(records: Integers, state: int) -> int:
    """Return the cell of a state."""
    return int(records[state - state % _HEADINGS + _CELL])


@inlined_part
def cost_place(state: int) -> int:
    """
    Return where a state's cost is, of the records as numbers of 32 bits.

    What is there is the cost plus one, and 0 where the state is not reached.
    """
    return 2 * state - state % _HEADINGS


@inlined_part
def by_place(state: int) -> int:
    """Return where it is noted how a state was reached, of the records as bytes."""
    return 8 * state - 7 * (state % _HEADINGS) + 8 * _BY


@inlined_part
def rest_place(state: int) -> int:
    """
    Return where the least cost is to come to rest in a state's cell, of the records.

    What is there is that cost times 8, and the heading; 0 where not known.
    """
    return state - state % _HEADINGS + _REST
