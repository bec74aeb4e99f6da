"""Shortest paths over cells with the fewest turns, against a search that shares nothing with it."""

import heapq
import math

import numpy as np
import pytest

from quad_lab.benchmarks.planning.small_requests import random_requests
from quad_planner.grid.bit_grid import BitGrid
from quad_planner.search.jump_points import JumpPointSearch
from quad_planner.search.lattice_search import fewest_turns

STEPS = ((1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1))


def least_length_and_turns(free, start, goal):
    """Search over cells and headings by length first, then by turns; None without a path."""
    height, width = free.shape
    waiting = [(0.0, 0, *start, k) for k in range(8)]
    done = set()
    while waiting:
        length, turns, x, y, k = heapq.heappop(waiting)
        if (x, y, k) in done:
            continue
        done.add((x, y, k))
        if (x, y) == goal:
            return length, turns
        for j, (dx, dy) in enumerate(STEPS):
            to_x, to_y = x + dx, y + dy
            if not (0 <= to_x < width and 0 <= to_y < height and free[to_y, to_x]):
                continue
            if dx and dy and not (free[y, to_x] and free[to_y, x]):
                continue
            # Rounded, so that equal lengths are equal.
            onward = round(length + math.hypot(dx, dy), 9)
            heapq.heappush(waiting, (onward, turns + ((x, y) != start and j != k), to_x, to_y, j))
    return None


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('seed', range(10))
def test_no_path_as_short_turns_less(seed):
    for free, start, goal, *_ in random_requests(seed, 25):
        grid = BitGrid.of(free)
        known = JumpPointSearch(grid).path(start, goal)
        least = least_length_and_turns(free, start, goal)
        if known is None:
            assert least is None
            continue
        cells = fewest_turns(grid, known.cells)
        length = float(np.hypot(*np.diff(cells, axis=0).T).sum())
        assert (pytest.approx(length, abs=1e-6), len(cells) - 2) == least
        assert len(cells) <= len(known.cells)


def test_memory_that_is_kept_shows_in_no_other_search():
    rng = np.random.default_rng(5)
    # Large enough that more tiles are needed than there are at first.
    large, small = (BitGrid.of(rng.random((n, n)) >= 0.1) for n in (150, 40))

    def path(grid, side):
        cells = [(x, y) for x in range(side) for y in range(side) if grid.is_free(x, y)]
        known = JumpPointSearch(grid).path(cells[0], cells[-1])
        return fewest_turns(grid, known.cells).tolist()

    first = path(large, 150)
    assert path(small, 40) == path(small, 40)
    assert path(large, 150) == first
