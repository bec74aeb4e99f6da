"""Quickest paths over cells and headings, against a search that shares nothing with them."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_lab.benchmarks.planning.plain_searches import least_cycles_over_cells
from quad_lab.benchmarks.planning.small_requests import RESOLUTION, random_requests
from quad_planner.grid.bit_grid import BitGrid
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.wave.wave_search import quickest_path

CRAWL = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(44.2))


def cycles_of(cells, start_yaw, goal_yaw, pace):
    """Count the cycles of a path stretch by stretch."""
    total, heading = 0, start_yaw
    for (x, y), (to_x, to_y) in itertools.pairwise(cells):
        onward = math.atan2(to_y - y, to_x - x)
        total += pace.turn_cycles(onward - heading)
        total += pace.straight_cycles(math.hypot(to_x - x, to_y - y) * RESOLUTION)
        heading = onward
    return total + pace.last_turn_cycles(goal_yaw - heading)


@pytest.mark.sweep(kept=4)
@pytest.mark.parametrize('seed', range(10))
def test_no_path_takes_fewer_cycles(seed):
    for request in random_requests(seed, 30):
        free, start, goal, start_yaw, goal_yaw, pace = request
        least = least_cycles_over_cells(request)
        path = quickest_path(
            BitGrid.of(free), start, goal, WalkTerms(pace, RESOLUTION, start_yaw, goal_yaw, 500)
        )
        assert (path.cycles if path else None) == least
        if path is not None:
            assert tuple(path.cells[0]) == start
            assert tuple(path.cells[-1]) == goal
            assert cycles_of(path.cells.tolist(), start_yaw, goal_yaw, pace) == least


def test_a_bound_is_just_above_what_is_found():
    for free, start, goal, start_yaw, goal_yaw, pace in random_requests(100, 60):
        grid, terms = BitGrid.of(free), WalkTerms(pace, RESOLUTION, start_yaw, goal_yaw, 500)
        path = quickest_path(grid, start, goal, terms)
        if path is None:
            continue
        enough = replace(terms, bound=path.cycles + 1)
        assert quickest_path(grid, start, goal, enough).cycles == path.cycles
        assert quickest_path(grid, start, goal, replace(terms, bound=path.cycles)) is None


def test_the_turns_cost_a_detour_that_is_worth_it():
    free = np.ones((40, 60), dtype=bool)
    # The short path is a staircase of notches, the long one goes around in two turns.
    for k in range(5):
        free[8 + 2 * (k % 2) : 20, 8 + 10 * k] = False
        free[0 : 6 + 2 * (k % 2), 8 + 10 * k] = False
    grid = BitGrid.of(free)
    path = quickest_path(grid, (2, 7), (57, 7), WalkTerms(CRAWL, RESOLUTION, 0.0, 0.0, 500))
    slow_turns = WalkingTimeModel(cycle_period=5.0, stride=0.226, turn=math.radians(4.0))
    straighter = quickest_path(
        grid, (2, 7), (57, 7), WalkTerms(slow_turns, RESOLUTION, 0.0, 0.0, 2000)
    )
    assert len(straighter.cells) <= len(path.cells)


def test_headings_at_both_ends_count():
    grid = BitGrid.of(np.ones((30, 30), dtype=bool))

    def cycles(start_yaw, goal_yaw):
        path = quickest_path(
            grid, (5, 15), (25, 15), WalkTerms(CRAWL, RESOLUTION, start_yaw, goal_yaw, 500)
        )
        return path.cycles

    # One metre is five strides; a quarter turn takes three cycles.
    assert cycles(0.0, 0.0) == 5
    assert cycles(math.pi / 2.0, 0.0) == 8
    assert cycles(0.0, math.pi / 2.0) == 8
    assert cycles(math.pi, math.pi) == 15


@pytest.mark.parametrize(('start', 'goal'), [((-1, 0), (3, 3)), ((0, 0), (9, 0)), ((2, 2), (0, 0))])
def test_ends_that_are_not_free_have_no_path(start, goal):
    free = np.ones((5, 5), dtype=bool)
    free[2, 2] = False
    assert (
        quickest_path(BitGrid.of(free), start, goal, WalkTerms(CRAWL, RESOLUTION, 0.0, 0.0, 500))
        is None
    )


def test_a_search_can_be_ended():
    free = np.random.default_rng(0).random((700, 700)) >= 0.2
    free[:5], free[-5:] = True, True

    def end():
        raise TimeoutError

    with pytest.raises(TimeoutError):
        quickest_path(
            BitGrid.of(free),
            (0, 0),
            (699, 699),
            WalkTerms(CRAWL, RESOLUTION, 0.0, 0.0, 2000),
            check=end,
        )


def test_memory_that_is_kept_shows_in_no_other_search():
    rng = np.random.default_rng(5)
    large, small = (BitGrid.of(rng.random((n, n)) >= 0.1) for n in (150, 40))
    terms = WalkTerms(CRAWL, RESOLUTION, 0.3, 2.0, 500)

    def path(grid, side):
        cells = [(x, y) for x in range(side) for y in range(side) if grid.is_free(x, y)]
        found = quickest_path(grid, cells[0], cells[-1], terms)
        return found.cells.tolist(), found.cycles, found.moves

    first = path(large, 150)
    assert path(small, 40) == path(small, 40)
    assert path(large, 150) == first


def test_a_gait_that_pauses_takes_the_fewest_cycles_too():
    pace = WalkingTimeModel(cycle_period=0.5, stride=0.17, turn=math.radians(27.6), stopping=2.3)
    for request in random_requests(7, 40):
        asked = request._replace(pace=pace)
        terms = WalkTerms(pace, RESOLUTION, asked.start_yaw, asked.goal_yaw, 500)
        path = quickest_path(BitGrid.of(asked.free), asked.start, asked.goal, terms)
        assert (path.cycles if path else None) == least_cycles_over_cells(asked)


def test_turns_that_cost_nothing_are_made_in_the_same_cycle():
    pace = replace(CRAWL, bend=math.pi)
    for request in random_requests(8, 40):
        asked = request._replace(pace=pace)
        terms = WalkTerms(pace, RESOLUTION, asked.start_yaw, asked.goal_yaw, 500)
        path = quickest_path(BitGrid.of(asked.free), asked.start, asked.goal, terms)
        assert (path.cycles if path else None) == least_cycles_over_cells(asked)


def test_where_walking_takes_longer_no_path_takes_fewer_cycles():
    rng = np.random.default_rng(3)
    for request in random_requests(11, 100):
        weights = rng.integers(16, 80, request.free.shape).astype(np.int32)
        terms = WalkTerms(
            request.pace, RESOLUTION, request.start_yaw, request.goal_yaw, 2000, weights
        )
        path = quickest_path(BitGrid.of(request.free), request.start, request.goal, terms)
        least = least_cycles_over_cells(request, weights / 16.0)
        assert (path.cycles if path else None) == least


def test_a_wave_takes_as_long_there_as_back():
    # Walked backwards, with both headings turned around, a path takes the same stretches and turns.
    for request in random_requests(9, 60):
        free, start, goal, start_yaw, goal_yaw, pace = request
        pace = replace(pace, heading_tolerance=pace.bend)
        grid = BitGrid.of(free)
        there = quickest_path(
            grid, start, goal, WalkTerms(pace, RESOLUTION, start_yaw, goal_yaw, 500)
        )
        back = quickest_path(
            grid,
            goal,
            start,
            WalkTerms(pace, RESOLUTION, goal_yaw + math.pi, start_yaw + math.pi, 500),
        )
        assert (there and there.cycles) == (back and back.cycles)
