"""
What a wave goes on with: the ground, the costs, what waits, and how far it is.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_planner.grid.bit_grid import Bits
from quad_planner.search.lattice_costs import HEADINGS, NOT_REACHED, Costs
from quad_planner.search.lattice_states import LatticeGround

Integers = NDArray[np.int64]

TIME, PHASE, READ, WRITTEN, FRONTS, LISTED, TILES, TURN = range(8)
"""
Places in the state of a wave: cycle, what is done in it, the next that is looked at, fronts that
go on so far, fronts, words in the lists, tiles in use, the time of turns that is looked at.
"""
BEST, HEADING, ARRIVED, MOVES = range(8, 12)
"""
Places in the state of a wave: the least cost at the goal, heading and cycle of that arrival, and
how often a front went on for a cycle.
"""

_ROOM = 4096


class WaveCosts(NamedTuple):
    """Costs as a wave needs them, in whole numbers, and times of turns in cycles."""

    straight: int
    """Cost of a step to a cell beside."""
    diagonal: int
    """Cost of a diagonal step."""
    cycle: int
    """Cost of a cycle."""
    pause: int
    """Cost of the pause of a stretch."""
    most: int
    """Largest cost of a path."""
    scale: float
    """Cost of a step, of its length in :mod:`quad_planner.search.cell_steps`, at least."""
    least_turns: Integers
    """As in :class:`quad_planner.search.lattice_costs.Costs`."""
    last_turns: Integers
    """Costs of the turns from each heading to the goal's, shape (8,)."""
    first: Integers
    """Cycles of the turn to each heading at the start, shape (8,)."""
    times: Integers
    """Cycles that turns take, each once, rising, shape (n,)."""
    turns: Integers
    """Headings to which one turns in that time: bit j of turns[i, k], shape (n, 8)."""

    @classmethod
    def of(cls, costs: Costs) -> WaveCosts:
        """Take them from those of a search."""
        cycles = (costs.turns - costs.pause) // costs.cycle
        is_other = ~np.eye(HEADINGS, dtype=np.bool_)
        times = np.unique(cycles[is_other])
        takes = (cycles == times[:, None, None]) & is_other
        return cls(
            costs.straight,
            costs.diagonal,
            costs.cycle,
            costs.pause,
            costs.longest - costs.cycle,
            costs.scale,
            costs.least_turns,
            costs.last_turns,
            (costs.first_turns - costs.pause) // costs.cycle,
            times,
            (takes << np.arange(HEADINGS)).sum(axis=2),
        )


class WaveGround(NamedTuple):
    """Where a wave goes on, and how far it is."""

    words: Integers
    """Of each cell, by number: :func:`quad_planner.search.distance_field.distance_words`."""
    width: int
    """Number of cells of a row."""
    start: int
    """Number of the start's cell."""
    goal: int
    """Number of the goal's cell."""
    numbers: Integers
    """Tile of each square of 8 by 8 cells, 0 where none is made, shape (m, n)."""
    state: Integers
    """How far the wave is, shape (12,)."""
    weights: NDArray[np.int32]
    """
    Factors by which steps in the cells of the map cost more, in sixteenths, shape (height, width);
    shape (0, 0) where none does.
    """
    left: int
    """Column of the map in which the ground begins."""
    bottom: int
    """Row of the map in which the ground begins."""

    @classmethod
    def of(
        cls, ground: LatticeGround, ends: tuple[int, int], weights: NDArray[np.int32] | None
    ) -> WaveGround:
        """Begin on a ground, from a start to a goal: numbers of cells."""
        words, width, left, bottom = ground
        if weights is None:
            weights = np.empty((0, 0), dtype=np.int32)
        numbers = np.zeros((len(words) // width // 8 + 1, width // 8 + 1), dtype=np.int64)
        state = np.zeros(12, dtype=np.int64)
        state[TILES], state[BEST] = 1, NOT_REACHED
        return cls(words, width, *ends, numbers, state, weights, left, bottom)


class WaveLists(NamedTuple):
    """What grows while a wave goes on."""

    fronts: Integers
    """
    Place of each front, row << 32 | column << 3 | heading, and its cost so far, shape (n, 2).
    """
    words: Integers
    """Of all cycles, one after the other: words of tiles in which cells were reached."""
    bits: Bits
    """Those cells, where it is of use to turn."""
    begins: Integers
    """Where the words of each cycle begin, shape (n,)."""

    @classmethod
    def empty(cls) -> WaveLists:
        """Return lists with room for a few thousand."""
        return cls(
            np.empty((_ROOM, 2), dtype=np.int64),
            np.empty(_ROOM, dtype=np.int64),
            np.empty(_ROOM, dtype=np.uint64),
            np.zeros(_ROOM, dtype=np.int64),
        )

    def doubled(self) -> WaveLists:
        """Return the same with room for twice as many."""
        return WaveLists(
            np.concatenate((self.fronts, np.empty_like(self.fronts))),
            np.concatenate((self.words, np.empty_like(self.words))),
            np.concatenate((self.bits, np.empty_like(self.bits))),
            np.concatenate((self.begins, np.empty_like(self.begins))),
        )
