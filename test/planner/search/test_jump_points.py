"""Jump point search is exact: against plain Dijkstra, and against published lengths."""

import heapq
import math
from itertools import pairwise

import numpy as np
import pytest

from quad_lab.tools.benchmark_maps import load_scenario, scenario_files
from quad_planner.grid.bit_grid import BitGrid
from quad_planner.search.cell_steps import DIAGONAL, STRAIGHT
from quad_planner.search.jump_points import JumpPointSearch

STEPS = [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1) if x or y]


def plain_dijkstra(free, start):
    """Shortest lengths to all cells, with no corner cut."""
    height, width = free.shape
    lengths = {start: 0}
    heap = [(0, start)]
    while heap:
        length, (x, y) = heapq.heappop(heap)
        if length > lengths[x, y]:
            continue
        for dx, dy in STEPS:
            u, v = x + dx, y + dy
            if not (0 <= u < width and 0 <= v < height):
                continue
            if not (free[v, u] and free[y, u] and free[v, x]):
                continue
            longer = length + (DIAGONAL if dx and dy else STRAIGHT)
            if longer < lengths.get((u, v), math.inf):
                lengths[u, v] = longer
                heapq.heappush(heap, (longer, (u, v)))
    return lengths


def assert_walkable(free, path, start, goal):
    cells = path.cells
    assert tuple(cells[0]) == start
    assert tuple(cells[-1]) == goal
    straight = diagonal = 0
    for a, b in pairwise(cells):
        steps = np.abs(b - a).max()
        step = np.sign(b - a)
        assert (a + steps * step == b).all()
        assert steps > 0
        for k in range(steps):
            x, y = a + k * step
            assert free[y + step[1], x + step[0]]
            assert free[y, x + step[0]]
            assert free[y + step[1], x]
        diagonal += steps if step.all() else 0
        straight += 0 if step.all() else steps
    assert (straight, diagonal) == (path.straight_steps, path.diagonal_steps)
    directions = [tuple(np.sign(b - a)) for a, b in pairwise(cells)]
    assert all(a != b for a, b in pairwise(directions))


@pytest.mark.parametrize('density', [0.02, 0.15, 0.3, 0.45])
@pytest.mark.parametrize('seed', range(12))
def test_paths_are_as_short_as_plain_dijkstras(density, seed):
    rng = np.random.default_rng([seed, round(100 * density)])
    height, width = rng.integers(1, 80, 2)
    free = rng.random((height, width)) >= density
    if seed % 3 == 0:
        # Rooms and blocks, not only dust.
        free = np.kron(free[: height // 4 + 1, : width // 4 + 1], np.ones((4, 4))) > 0.0
    cells = [(int(x), int(y)) for y, x in np.argwhere(free)]
    if not cells:
        return
    search = JumpPointSearch(BitGrid.of(free))
    start = cells[rng.integers(len(cells))]
    lengths = plain_dijkstra(free, start)
    for k in rng.integers(0, len(cells), 25):
        path = search.path(start, cells[k])
        if path is None:
            assert cells[k] not in lengths
            continue
        assert STRAIGHT * path.straight_steps + DIAGONAL * path.diagonal_steps == lengths[cells[k]]
        assert_walkable(free, path, start, cells[k])


def test_no_corner_is_cut():
    free = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], dtype=bool)
    path = JumpPointSearch(BitGrid.of(free)).path((0, 0), (2, 2))
    assert path.length == 4.0
    assert path.diagonal_steps == 0


def test_ends_that_are_not_free_or_not_on_the_map_have_no_path():
    free = np.ones((5, 7), dtype=bool)
    free[2, 3] = False
    search = JumpPointSearch(BitGrid.of(free))
    for end in ((3, 2), (-1, 0), (7, 0), (0, 5)):
        assert search.path((0, 0), end) is None
        assert search.path(end, (0, 0)) is None
    assert search.path((1, 1), (1, 1)).length == 0.0


def test_a_search_leaves_nothing_behind():
    rng = np.random.default_rng(3)
    free = rng.random((60, 60)) > 0.3
    free[0, 0] = free[-1, -1] = True
    used = JumpPointSearch(BitGrid.of(free))
    cells = [(int(x), int(y)) for y, x in np.argwhere(free)]
    for k in range(0, len(cells) - 1, 40):
        fresh = JumpPointSearch(BitGrid.of(free)).path(cells[k], cells[-k - 1])
        again = used.path(cells[k], cells[-k - 1])
        if fresh is None:
            assert again is None
        else:
            assert (again.cells == fresh.cells).all()


def test_noise_that_needs_a_larger_heap_is_searched_too():
    rng = np.random.default_rng(8)
    free = rng.random((400, 400)) > 0.35
    free[0, 0] = free[-1, -1] = True
    path = JumpPointSearch(BitGrid.of(free)).path((0, 0), (399, 399))
    lengths = plain_dijkstra(free, (0, 0))
    wanted = lengths.get((399, 399))
    found = None
    if path is not None:
        found = STRAIGHT * path.straight_steps + DIAGONAL * path.diagonal_steps
    assert found == wanted


def test_a_long_search_asks_again_and_again_whether_to_go_on():
    free = np.random.default_rng(8).random((400, 400)) > 0.2
    free[0, 0] = True
    free[-2:, -2:] = [[False, False], [False, True]]
    search = JumpPointSearch(BitGrid.of(free))
    calls = []
    assert search.path((0, 0), (399, 399), lambda: calls.append(1)) is None
    assert len(calls) > 2

    def stop():
        calls.pop()
        if not calls:
            raise TimeoutError

    with pytest.raises(TimeoutError):
        search.path((0, 0), (399, 399), stop)


def test_two_maps_are_searched_side_by_side():
    rng = np.random.default_rng(5)
    maps = [rng.random((200, 200)) > fraction for fraction in (0.1, 0.3)]
    for free in maps:
        free[0, 0] = free[-1, -1] = True
    searches = [JumpPointSearch(BitGrid.of(free)) for free in maps]
    alone = [search.path((0, 0), (199, 199)) for search in searches]
    # One search runs while the other has stopped to ask.
    inner = []
    outer = searches[1].path(
        (0, 0), (199, 199), lambda: inner.append(searches[0].path((0, 0), (199, 199)))
    )
    assert (outer is None) == (alone[1] is None)
    if outer is not None:
        assert outer.length == alone[1].length
    assert all(path.length == alone[0].length for path in inner)


SCENARIOS = scenario_files()


@pytest.mark.skipif(not SCENARIOS, reason='no scenarios: QUADWALK_MAPS names no folder with them')
@pytest.mark.parametrize('scenario', SCENARIOS, ids=lambda path: path.name)
def test_lengths_are_those_of_the_published_scenarios(scenario):
    free, problems = load_scenario(scenario)
    search = JumpPointSearch(BitGrid.of(free))
    wrong = []
    for problem in problems:
        path = search.path(problem.start, problem.goal)
        if not problem.is_right(None if path is None else path.length):
            wrong.append((problem, path))
    assert problems
    assert wrong == []
