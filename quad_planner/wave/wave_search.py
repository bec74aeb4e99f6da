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
from quad_planner.search.cell_steps import DX, DY
from quad_planner.search.distance_field import NOT_REACHED as NO_LENGTH
from quad_planner.search.distance_field import word_length
from quad_planner.search.lattice_costs import HEADINGS, NOT_REACHED, costs_of
from quad_planner.search.lattice_states import ground_between
from quad_planner.search.search_loop import DONE, FULL
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.search.weighted_search import TWO_PARTS
from quad_planner.wave.wave_cycles import go_on, place_of
from quad_planner.wave.wave_state import (
    ARRIVED,
    BEST,
    FRONTS,
    HEADING,
    MOVES,
    WaveCosts,
    WaveGround,
    WaveLists,
)
from quad_planner.wave.wave_tiles import WaveTiles, give_back, wave_tiles


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
    _begin(ground, costs, lists)
    tiles = wave_tiles(ground.numbers.size + 1)
    try:
        while (outcome := go_on(ground, costs, tiles, lists)) != DONE:
            if outcome == FULL:
                lists = lists.doubled()
            check()
        best, moves = ground.state[[BEST, MOVES]].tolist()
        if best == NOT_REACHED:
            return None
        cells = np.array(_places(ground, costs, tiles))
    finally:
        give_back(tiles)
    corner = np.array((window.left, window.bottom))
    return QuickestPath(cells + corner, best // counted.cycle, moves)


def _begin(ground: WaveGround, costs: WaveCosts, lists: WaveLists) -> None:
    """Let a front wait at the start for each heading, until the first turn is over."""
    y, x = divmod(ground.start, ground.width)
    for k in range(HEADINGS):
        lists.fronts[k] = place_of(x, y, k), int(costs.first[k]) * costs.cycle + costs.pause
    ground.state[FRONTS] = HEADINGS


def _places(ground: WaveGround, costs: WaveCosts, tiles: WaveTiles) -> list[tuple[int, int]]:
    """
    Go back from the goal; list where the path begins, turns and ends, in cells of the ground.

    A stretch began where the robot could have turned to its heading in time.
    """
    # Python's own numbers: quick to read one by one, and nothing to compile.
    reached, arrived, numbers = tiles.reached.data, tiles.arrived.data, ground.numbers.data
    steps = list(zip(DX.tolist(), DY.tolist()))
    times = _times_to(costs)
    first = costs.first.tolist()
    (y, x), start = divmod(ground.goal, ground.width), divmod(ground.start, ground.width)
    heading, now = (int(ground.state[at]) for at in (HEADING, ARRIVED))
    cost, places = costs.pause, [(x, y)]
    while True:
        dx, dy = steps[heading]
        cost += _onward(ground, costs, (x, y), (x - dx, y - dy))
        x, y = x - dx, y - dy
        # When the stretch began at the latest.
        begun = now - (cost + costs.cycle - 1) // costs.cycle
        if (y, x) == start and first[heading] <= begun:
            places.append((x, y))
            return places[::-1]
        tile, cell = numbers[y >> 3, x >> 3], (y & 7) << 3 | (x & 7)
        for k, time in times[heading]:
            word = 8 * tile + k
            if reached[word] >> cell & 1 and arrived[word << 6 | cell] + time <= begun:
                places.append((x, y))
                heading, now, cost = k, arrived[word << 6 | cell], costs.pause
                break


def _times_to(costs: WaveCosts) -> list[list[tuple[int, int]]]:
    """List for each heading the others, and the cycles of the turn from each."""
    found: list[list[tuple[int, int]]] = [[] for _ in range(HEADINGS)]
    for time, turns in zip(costs.times.tolist(), costs.turns.tolist()):
        for k, to in enumerate(turns):
            for heading in range(HEADINGS):
                if to >> heading & 1:
                    found[heading].append((k, time))
    return found


def _onward(
    ground: WaveGround, costs: WaveCosts, cell: tuple[int, int], beside: tuple[int, int]
) -> int:
    """Return what a step between two cells of the ground costs."""
    is_straight = cell[0] == beside[0] or cell[1] == beside[1]
    step = costs.straight if is_straight else costs.diagonal
    if not len(ground.weights):
        return step
    weight = sum(int(ground.weights[y + ground.bottom, x + ground.left]) for x, y in (cell, beside))
    return step * weight // TWO_PARTS
