"""Cheapest paths where some cells cost more than others, against SciPy on the same graph."""

import math
from itertools import pairwise, product

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import dijkstra

from quad_planner.grid.bit_grid import BitGrid, BitMask
from quad_planner.search.weighted_search import cheapest_path, line_cost, straightened


def least_cost(free, factors, start, goal):
    height, width = free.shape
    numbers = np.arange(free.size).reshape(free.shape)
    edges = []
    for y, x, (dx, dy) in product(range(height), range(width), ((1, 0), (0, 1), (1, 1), (-1, 1))):
        to_x, to_y = x + dx, y + dy
        if not (0 <= to_x < width and 0 <= to_y < height and free[y, x] and free[to_y, to_x]):
            continue
        if dx and dy and not (free[y, to_x] and free[to_y, x]):
            continue
        cost = math.hypot(dx, dy) * (factors[y, x] + factors[to_y, to_x]) / 2.0
        edges.append((numbers[y, x], numbers[to_y, to_x], cost))
    if not edges:
        return math.inf
    a, b, costs = zip(*edges)
    graph = coo_array((costs, (a, b)), shape=(free.size, free.size)).tocsr()
    costs = dijkstra(graph, directed=False, indices=numbers[start[::-1]])
    return float(costs[numbers[goal[::-1]]])


def requests(seed, count):
    rng = np.random.default_rng(seed)
    while count:
        height, width = rng.integers(3, 22, 2)
        free = rng.random((height, width)) >= rng.choice([0.0, 0.1, 0.3])
        spread = rng.choice([0.0, 3.0, 200.0])
        # Sixteenths, as the search counts them.
        factors = np.round(16.0 * (1.0 + spread * rng.random(free.shape) ** 3)) / 16.0
        cells = np.argwhere(free)[:, ::-1]
        if len(cells) < 2:
            continue
        yield free, factors, *(tuple(map(int, cells[k])) for k in rng.integers(0, len(cells), 2))
        count -= 1


def cost_of(points, factors):
    return sum(line_cost(factors, *a, *b) for a, b in pairwise(points))


@pytest.mark.parametrize('seed', range(8))
def test_no_path_is_cheaper(seed):
    for free, factors, start, goal in requests(seed, 15):
        least = least_cost(free, factors, start, goal)
        cells = cheapest_path(BitGrid.of(free), factors, start, goal)
        if cells is None:
            assert math.isinf(least)
            continue
        assert (tuple(cells[0]), tuple(cells[-1])) == (start, goal)
        assert cost_of(cells + 0.5, factors) == pytest.approx(least, rel=1e-6, abs=1e-9)
        straight = straightened(cells + 0.5, factors, BitMask.of(~free))
        assert cost_of(straight, factors) <= least * (1.0 + 1e-6) + 1e-9


def test_a_detour_avoids_dear_cells():
    factors = np.ones((20, 40))
    factors[:12, 15:25] = 5.0
    free = BitGrid.of(np.ones(factors.shape, dtype=bool))
    cells = cheapest_path(free, factors, (5, 5), (35, 5))
    assert cells[:, 1].max() >= 12
    cheap = np.where(factors > 1.0, 1.1, 1.0)
    assert cheapest_path(free, cheap, (5, 5), (35, 5)).tolist() == [[5, 5], [35, 5]]


def test_a_lines_cost_is_the_integral_of_the_factor():
    factors = np.array([[1.0, 3.0], [5.0, 7.0]])
    assert line_cost(factors, 0.5, 0.5, 1.5, 0.5) == pytest.approx(2.0)
    assert line_cost(factors, 0.5, 0.5, 1.5, 1.5) == pytest.approx(math.sqrt(2.0) * 4.0)
    assert line_cost(factors, 1.5, 1.75, 1.5, 0.5) == pytest.approx(0.75 * 7.0 + 0.5 * 3.0)
    assert line_cost(factors, 0.3, 0.3, 0.3, 0.3) == 0.0
    forth, back = line_cost(factors, 0.1, 0.3, 1.9, 1.2), line_cost(factors, 1.9, 1.2, 0.1, 0.3)
    assert forth == pytest.approx(back)


@pytest.mark.parametrize(('start', 'goal'), [((-1, 0), (3, 3)), ((0, 0), (9, 0)), ((2, 2), (0, 0))])
def test_ends_that_are_not_free_have_no_path(start, goal):
    free = np.ones((5, 5), dtype=bool)
    free[2, 2] = False
    assert cheapest_path(BitGrid.of(free), np.ones((5, 5)), start, goal) is None


def test_a_search_can_be_ended():
    def end():
        raise TimeoutError

    free = BitGrid.of(np.ones((600, 600), dtype=bool))
    factors = 1.0 + np.random.default_rng(0).random((600, 600))
    with pytest.raises(TimeoutError):
        cheapest_path(free, factors, (0, 0), (599, 599), end)
