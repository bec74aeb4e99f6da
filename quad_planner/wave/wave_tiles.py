"""
What a wave knows of the cells that it reached, by tiles of 8 by 8 cells.

For each heading a tile is a word of 64 bits, bit 8 y + x for its cell (x, y); words and arrivals
of tile n and heading k are number 8 n + k. A tile is made when the first of its cells is reached.
Memory is kept from one search to the next: to have it given again would take as
long as a search.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_part
from quad_planner.grid.bit_grid import Bits
from quad_planner.search.distance_field import word_length

Integers = NDArray[np.int64]

_CELLS = 64
_MOST_KEPT = 65536
"""Number of tiles whose memory is kept for other searches, 150 MB where all of it was used."""

_DIAGONALS = np.zeros(16, dtype=np.uint64)
"""Bits 1, 3, 5, 7 for bits 0 to 3."""
for _bits in range(16):
    _DIAGONALS[_bits] = sum((_bits >> k & 1) << 2 * k + 1 for k in range(4))


class WaveTiles(NamedTuple):
    """Memory for tiles; number 0 is none."""

    steps: Bits
    """Cells from which a step in the heading is free, shape (8 n,)."""
    reached: Bits
    """Cells that were reached by walking in the heading, shape (8 n,)."""
    closed: Bits
    """Cells reached, or turned at, in the heading: to turn to it there is of no more use."""
    fresh: Bits
    """Cells that were reached in this cycle, shape (8 n,)."""
    arrived: NDArray[np.int32]
    """Cycle in which each cell was reached, shape (512 n,)."""
    corners: Integers
    """Column and row in which each tile begins, shape (2 n,)."""


_spare: list[WaveTiles] = []


def wave_tiles(count: int) -> WaveTiles:
    """Return memory for so many tiles; the system gives it where it is first used."""
    try:
        tiles = _spare.pop()
    except IndexError:
        # Whoever else searches at the same time has it.
        return _memory(count)
    return tiles if len(tiles.corners) >= 2 * count else _memory(count)


def give_back(tiles: WaveTiles) -> None:
    """Keep the memory of tiles that are done with."""
    if len(tiles.corners) <= 2 * _MOST_KEPT:
        # One, whichever threads give theirs back at the same time.
        _spare[:] = [tiles]


def _memory(tiles: int) -> WaveTiles:
    steps, reached, closed, fresh = np.empty((4, 8 * tiles), dtype=np.uint64)
    return WaveTiles(
        steps,
        reached,
        closed,
        fresh,
        np.empty(8 * _CELLS * tiles, dtype=np.int32),
        np.empty(2 * tiles, dtype=np.int64),
    )


@compiled_part
def make_tile(
    words: Integers, width: int, goal: int, tiles: WaveTiles, tile: int, x: int, y: int
) -> None:
    """Make the tile of a cell, numbered; no step leads on from the goal."""
    steps, reached, closed, fresh = tiles.steps, tiles.reached, tiles.closed, tiles.fresh
    corners = tiles.corners
    left, bottom = x & ~7, y & ~7
    corners[2 * tile], corners[2 * tile + 1] = left, bottom
    for k in range(8 * tile, 8 * tile + 8):
        steps[k] = 0
        reached[k] = 0
        closed[k] = 0
        fresh[k] = 0
    height = len(words) // width
    for row in range(min(8, height - bottom)):
        # Byte x: bit k for a step in heading k from cell x.
        block = np.uint64(0)
        first = (bottom + row) * width + left
        for column in range(min(8, width - left)):
            word = words[first + column]
            if word_length(word) >= 0 and first + column != goal:
                may = np.uint64(word >> 8 & 0x55) | _DIAGONALS[word >> 4 & 15]
                block |= may << np.uint64(8 * column)
        if block == 0:
            continue
        # Rows and columns of 8 by 8 bits change places (Warren, Hacker's Delight, 7-3).
        swap = (block ^ (block >> np.uint64(7))) & np.uint64(0x00AA00AA00AA00AA)
        block ^= swap ^ (swap << np.uint64(7))
        swap = (block ^ (block >> np.uint64(14))) & np.uint64(0x0000CCCC0000CCCC)
        block ^= swap ^ (swap << np.uint64(14))
        swap = (block ^ (block >> np.uint64(28))) & np.uint64(0x00000000F0F0F0F0)
        block ^= swap ^ (swap << np.uint64(28))
        for k in range(8):
            byte = (block >> np.uint64(8 * k)) & np.uint64(255)
            steps[8 * tile + k] |= byte << np.uint64(8 * row)
