"""
Quickest paths over cells and eight headings, in whole gait cycles (S0 sec. 3): a wave in time.

A robot that rests at a cell has spent whole cycles, so what can be is asked cycle by cycle: in
which cells can the robot rest, by heading, after n cycles and not before? Those are reached by
fronts, robots in the middle of a stretch, which go on by a stride each cycle. Where fronts
arrive the robot may turn; all cells of a tile that were reached in a heading turn to another in
one operation on words of 64 bits, when the turn's cycles are over, and begin new fronts. A
front ends where a wall is, where another was in an earlier cycle, or where the robot could have
turned to its heading by then: that robot is ahead, and stays so, for what slows one slows
the other at the same place.

No front goes on through which a path would take more than the bound: its cost, with the length
of the shortest path to the goal and the least turns over free ground
(:func:`quad_planner.search.lattice_costs.total_cost`). The first cycle after which no
arrival at the goal could be earlier ends the search, so it is exact.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_planner.grid.bit_grid import BitGrid
from quad_planner.search.distance_field import NOT_REACHED as NO_LENGTH
from quad_planner.search.distance_field import word_length
from quad_planner.search.lattice_costs import NOT_REACHED, costs_of
from quad_planner.search.lattice_states import ground_between
from quad_planner.search.search_loop import DONE, FULL
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.wave.wave_cycles import go_on, places_back
from quad_planner.wave.wave_state import ARRIVED, BEST, MOVES, WaveCosts, WaveGround, WaveLists
from quad_planner.wave.wave_tiles import give_back, wave_tiles


@dataclass(frozen=True)
class QuickestPath:
    """A quickest path."""

    cells: NDArray[np.int64]
    """Cells where it begins, turns and ends: x and y, shape (n, 2)."""
    cycles: int
    """Gait cycles, of walking and turning."""
    moves: int
    """Number of cycles that all fronts went on, together."""


def quickest_path(
    grid: BitGrid,
    start: tuple[int, int],
    goal: tuple[int, int],
    terms: WalkTerms,
    check: Callable[[], None] = lambda: None,
) -> QuickestPath | None:
    """
    Find a path that takes the fewest gait cycles.

    Parameters
    ----------
    grid : BitGrid
        The free cells.
    start, goal : tuple of int
        x and y of two different cells of the map.
    terms : WalkTerms
        Times by which its gait cycles are counted.
    check : callable
        Called now and then; raises to end the search.

    Returns
    -------
    QuickestPath or None
        None if there is no path, or none within the bound, or an end is not free.
    """
    if not (grid.is_free(*start) and grid.is_free(*goal)):
        return None
    counted = costs_of(terms)
    window = ground_between(grid, start, goal, counted, check)
    ends = window.number(start), window.number(goal)
    if word_length(int(window.words[ends[0]])) == NO_LENGTH:
        return None
    ground = WaveGround.of(window, ends, terms.weights)
    costs, lists = WaveCosts.of(counted), WaveLists.empty()
    tiles = wave_tiles(ground.numbers.size + 1)
    try:
        while (outcome := go_on(ground, costs, tiles, lists)) != DONE:
            if outcome == FULL:
                lists = lists.doubled()
            check()
        best, arrived, moves = ground.state[[BEST, ARRIVED, MOVES]].tolist()
        if best == NOT_REACHED:
            return None
        # Each stretch takes a cycle at least.
        places = np.empty((arrived + 2, 2), dtype=np.int64)
        places = places[: places_back(ground, costs, tiles, places)]
    finally:
        give_back(tiles)
    cells = places[::-1] + np.array((window.left, window.bottom))
    return QuickestPath(cells, best // counted.cycle, moves)
