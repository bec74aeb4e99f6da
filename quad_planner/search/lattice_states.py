"""
The ground of a search over cells and headings, and what it knows of the states that it reached.

States are kept by tiles of 8 by 8 cells, made when the first of their cells is reached: so memory
is as large as the search, whatever the map's size, and what is near on the map is near in memory.
Memory is kept from one search to the next: to have it given again would take as
long as a search.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_part, inlined_part
from quad_planner.grid.bit_grid import BitGrid, BitMask
from quad_planner.search.distance_field import Beyond, distance_words
from quad_planner.search.lattice_costs import Costs

Integers = NDArray[np.int64]

_ROOM_AT_FIRST = 64
_MOST_KEPT = 16384
"""Number of tiles whose memory is kept for other searches, 49 MB."""

_CELLS = 64
_STATES = 8 * _CELLS


class _Tiles(NamedTuple):
    """Memory for tiles; number 0 is none."""

    cost: NDArray[np.int32]
    """Cost of each state plus one, and 0 where it is not reached, shape (512 n,)."""
    by: NDArray[np.uint8]
    """How each was reached, and whether the search went on from there, shape (512 n,)."""
    rests: Integers
    """
    Of each cell the least cost to come to rest, times 8, and the heading; 0 where not known,
    shape (64 n,).
    """
    corners: Integers
    """Column and row in which each tile begins, shape (2 n,)."""


_spare: list[_Tiles] = []


class LatticeGround(NamedTuple):
    """The part of a map in which a search goes on: cells by number, row by row, in a wall."""

    words: Integers
    """What is known of each cell: :func:`distance_words`, from the goal."""
    width: int
    """Number of cells of a row, with the wall."""
    left: int
    """Column of the map in which it begins."""
    bottom: int
    """Row of the map in which it begins."""

    def number(self, cell: tuple[int, int]) -> int:
        """Return the number of a cell of the map, of its x and y."""
        return (cell[1] - self.bottom) * self.width + cell[0] - self.left


class LatticeStates(NamedTuple):
    """States of a map; state 8 c + k is cell c of the tiles, reached by a step in heading k."""

    tiles: _Tiles
    """What is known of them."""
    numbers: Integers
    """Tile of each square of 8 by 8 cells, 0 where none is reached, shape (m, n)."""
    used: Integers
    """Number of tiles in use, shape (1,)."""


def ground_between(
    grid: BitGrid,
    start: tuple[int, int],
    goal: tuple[int, int],
    costs: Costs,
    check: Callable[[], None],
) -> LatticeGround:
    """Measure how far it is from each cell to the goal, where a path could be short enough."""
    along, across = (abs(a - b) for a, b in zip(start, goal))
    least = max(along, across) + (math.sqrt(2.0) - 1.0) * min(along, across)
    # A detour to the side costs this least where it replaces straight steps by diagonal ones.
    spare = costs.longest / costs.straight - least
    margin = math.ceil(max(spare, 0.0) / (2.0 * (math.sqrt(2.0) - 1.0))) + 2
    sizes = (grid.width, grid.height)
    low = [max(min(a, b) - margin, 0) for a, b in zip(start, goal)]
    high = [min(max(a, b) + 1 + margin, size) for a, b, size in zip(start, goal, sizes)]
    # In the grid with its wall, cells are one farther.
    free = BitMask(grid.rows, grid.width + 2).window(*(n + 1 for n in (*low, *high)))
    ends = [(end[0] - low[0], end[1] - low[1]) for end in (start, goal)]
    beyond = Beyond(*ends[0], math.ceil(costs.longest / costs.scale))
    words = distance_words(free, ends[1], check, beyond)
    return LatticeGround(words.reshape(-1), words.shape[1], low[0] - 1, low[1] - 1)


def lattice_states(width: int, height: int) -> LatticeStates:
    """Return the states of a map of so many cells, of which none is reached."""
    numbers = np.zeros((height // 8 + 1, width // 8 + 1), dtype=np.int64)
    try:
        tiles = _spare.pop()
    except IndexError:
        # Whoever else searches at the same time has it.
        tiles = _memory(_ROOM_AT_FIRST)
    return LatticeStates(tiles, numbers, np.ones(1, dtype=np.int64))


def give_back(states: LatticeStates) -> None:
    """Keep the memory of states that are done with."""
    if len(states.tiles.corners) <= 2 * _MOST_KEPT:
        # One, whichever threads give theirs back at the same time.
        _spare[:] = [states.tiles]


def with_tiles(states: LatticeStates, more: int) -> LatticeStates:
    """Return the same states with room for so many more tiles, which are few."""
    if has_tiles(states.used, states.tiles.corners, more):
        return states
    old = states.tiles
    larger = _memory(len(old.corners))
    larger.cost[: len(old.cost)] = old.cost
    larger.by[: len(old.by)] = old.by
    larger.rests[: len(old.rests)] = old.rests
    larger.corners[: len(old.corners)] = old.corners
    return states._replace(tiles=larger)


def _memory(tiles: int) -> _Tiles:
    return _Tiles(
        np.empty(_STATES * tiles, dtype=np.int32),
        np.empty(_STATES * tiles, dtype=np.uint8),
        np.empty(_CELLS * tiles, dtype=np.int64),
        np.empty(2 * tiles, dtype=np.int64),
    )


@inlined_part
def has_tiles(used: Integers, corners: Integers, more: int) -> bool:
    """Return whether so many more tiles may be made."""
    return bool(2 * (used[0] + more) <= len(corners))


@inlined_part
def state_of(numbers: Integers, x: int, y: int, heading: int) -> int:
    """Return a state; one of tile 0, below :data:`FIRST_STATE`, where its tile is not made."""
    return int(numbers[y >> 3, x >> 3] << 9 | (y & 7) << 6 | (x & 7) << 3 | heading)


FIRST_STATE = _STATES
"""The first number of a state."""


@compiled_part
def make_tile(
    cost: NDArray[np.int32],
    by: NDArray[np.uint8],
    rests: Integers,
    corners: Integers,
    numbers: Integers,
    used: Integers,
    x: int,
    y: int,
) -> None:
    """Make the tile of a cell; there must be room."""
    tile = int(used[0])
    used[0] += 1
    numbers[y >> 3, x >> 3] = tile
    corners[2 * tile], corners[2 * tile + 1] = x & ~7, y & ~7
    for at in range(_STATES * tile, _STATES * (tile + 1)):
        cost[at] = 0
        by[at] = 0
    for at in range(_CELLS * tile, _CELLS * (tile + 1)):
        rests[at] = 0


@inlined_part
def place_of(corners: Integers, state: int) -> tuple[int, int]:
    """Return the column and the row of a state's cell."""
    first = (state >> 9) << 1
    return int(corners[first]) + (state >> 3 & 7), int(corners[first + 1]) + (state >> 6 & 7)
