"""A flood from either end meets the other exactly where brute force finds a path."""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.planning.footprint_maps import free_classes, office, reachable
from quad_planner.methods.outline_planner import OutlinePlanner
from quad_planner.methods.shortest_planner import ShortestPlanner
from quad_planner.outline import flood as flood_module
from quad_planner.outline.flood import Flood
from quad_planner.outline.heading_moves import moves_from
from quad_planner.outline.outline_search import Ends, free_for_smallest, outline_path
from quad_planner.planner_setup import outline_for

SAFETY = 0.05
CELL = 0.05
MOVES = moves_from(0.5, 0.5)


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('is_forward', [False, True])
@pytest.mark.parametrize('robot', ['a1', 'titan_viii'])
def test_it_meets_the_other_end_where_brute_force_finds_a_path(robot, is_forward):
    made = load_robot(robot)
    circle = ShortestPlanner(clearance_radius=made.standing_radius + SAFETY)
    planner = OutlinePlanner(circle, outline_for(made, SAFETY))
    answers = []
    for seed in range(4):
        rng = np.random.default_rng(seed)
        prepared = planner.prepare(office(120, CELL, rng))
        free = free_classes(prepared.blocked, prepared.allowed, prepared.kernels[0])
        states = np.argwhere(free)
        (k, y, x), *goals = (tuple(map(int, states[rng.integers(len(states))])) for _ in range(16))
        ends = reachable(free, MOVES, (k, y, x))
        for goal in goals:
            at_goal = (goal[2], goal[1], goal[0])
            flood = Flood(prepared.zones, MOVES, (x, y, k), at_goal, is_forward)
            # Little by little: what was reached is kept.
            while not flood.goes_on(500):
                assert not flood.has_met
            assert flood.has_met == bool(ends[goal])
            answers.append(flood.has_met)
    assert 0 < sum(answers) < len(answers)


@pytest.mark.parametrize('is_forward', [False, True])
def test_a_goal_that_is_the_start_is_met(is_forward):
    made = load_robot('a1')
    circle = ShortestPlanner(clearance_radius=made.standing_radius + SAFETY)
    prepared = OutlinePlanner(circle, outline_for(made, SAFETY)).prepare(
        office(120, CELL, np.random.default_rng(0))
    )
    y, x = (int(n) for n in np.argwhere(prepared.allowed)[0])
    flood = Flood(prepared.zones, MOVES, (x, y, 3), (x, y, 40), is_forward)
    assert flood.goes_on(10)
    assert flood.has_met


def a1_office(side=200):
    """Return an office as the planner of a1's outline prepares it."""
    made = load_robot('a1')
    circle = ShortestPlanner(clearance_radius=made.standing_radius + SAFETY)
    planner = OutlinePlanner(circle, outline_for(made, SAFETY))
    return planner.prepare(office(side, CELL, np.random.default_rng(0)))


def in_a_large_room(prepared):
    """Return x and y of a cell in the largest area in which the circle fits."""
    sizes = np.bincount(prepared.areas.ravel())
    cells = np.argwhere(prepared.areas == 1 + np.argmax(sizes[1:]))
    y, x = (int(n) for n in cells[len(cells) // 2])
    return x, y


def flood_of(prepared, is_forward=False):
    """Return a flood that meets no other end: the cell in the corner is a wall."""
    ends = [(0, 0, 0), (*in_a_large_room(prepared), 0)]
    return Flood(prepared.zones, MOVES, *(ends[::-1] if is_forward else ends), is_forward)


@pytest.mark.parametrize('is_forward', [False, True])
def test_it_can_be_ended_at_any_time(is_forward):
    class Superseded(Exception):
        pass

    checks = []

    def check():
        checks.append(None)
        if len(checks) > 3:
            raise Superseded

    with pytest.raises(Superseded):
        flood_of(a1_office(), is_forward).goes_on(10**9, check)


def test_one_that_takes_too_much_memory_says_so_and_the_search_answers_without_it(monkeypatch):
    prepared = a1_office()
    free = np.argwhere(free_classes(prepared.blocked, prepared.allowed, prepared.kernels[0]))
    x, y = in_a_large_room(prepared)
    ends = [Ends(x, y, 0, *(int(n) for n in free[at][[2, 1, 0]]), False) for at in (0, 9, -1)]
    small = free_for_smallest(prepared.blocked)

    def answers():
        return [outline_path(prepared.zones, MOVES, each, small) for each in ends]

    expected = answers()
    monkeypatch.setattr(flood_module, '_MOST_BYTES', 1 << 16)
    flood = flood_of(prepared)
    assert not flood.goes_on(10**9)
    assert flood.is_too_large
    assert not flood.has_met
    assert any(path is not None for path in expected)
    for found, wanted in zip(answers(), expected):
        np.testing.assert_array_equal(found, wanted)
