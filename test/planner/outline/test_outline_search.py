"""A search finds its way out of where the robot cannot turn, and loses no path for it."""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.planning.footprint_maps import free_classes, office
from quad_planner.methods.outline_planner import OutlinePlanner
from quad_planner.methods.shortest_planner import ShortestPlanner
from quad_planner.outline import outline_search
from quad_planner.outline.heading_moves import moves_from
from quad_planner.outline.outline_search import DETAILS, Ends, Search
from quad_planner.planner_setup import outline_for
from quad_planner.search.distance_field import distance_field

SAFETY = 0.05
CELL = 0.05
MOVES = moves_from(0.5, 0.5)
REQUESTS = 40

HARD = 3_000
"""Expansions of a request whose search is led where the robot cannot turn."""


@pytest.fixture(scope='module')
def requests():
    """Return an office as the planner of a1's outline prepares it, and requests on it."""
    made = load_robot('a1')
    circle = ShortestPlanner(clearance_radius=made.standing_radius + SAFETY)
    planner = OutlinePlanner(circle, outline_for(made, SAFETY))
    rng = np.random.default_rng(3)
    prepared = planner.prepare(office(480, CELL, rng))
    free = np.argwhere(free_classes(prepared.blocked, prepared.allowed, prepared.kernels[0]))
    picked = free[rng.integers(len(free), size=(REQUESTS, 2))]
    return prepared, [
        Ends(int(x), int(y), int(k), int(goal_x), int(goal_y), int(goal_k), False)
        for (k, y, x), (goal_k, goal_y, goal_x) in picked
    ]


def searched(prepared, ends, detail):
    """Return whether a search finds a path, and the number of its expansions."""
    left = distance_field(prepared.small, (ends.goal_x // 2, ends.goal_y // 2))
    search = Search(prepared.zones, MOVES, ends, left, prepared.small, detail)
    assert search.goes_on(10**9, lambda: None)
    return search.path() is not None, search.expansions


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('detail', DETAILS, ids=['eighths', 'all'])
def test_corrections_lose_no_path_and_save_expansions(requests, detail, monkeypatch):
    prepared, ends = requests
    monkeypatch.setattr(outline_search, '_CORRECTED_AFTER', 200)
    if detail is not DETAILS[0]:
        # A search in vain goes through all of the office: once, with the fewest headings, will do.
        found = [(each, searched(prepared, each, DETAILS[0])) for each in ends]
        ends = [each for each, (path, expansions) in found if path or expansions < HARD]
    corrected = [searched(prepared, each, detail) for each in ends]
    monkeypatch.setattr(outline_search, '_CORRECTED_AFTER', 10**9)
    plain = [searched(prepared, each, detail) for each in ends]
    found = [path for path, _ in plain]
    assert [path for path, _ in corrected] == found
    assert sum(found) > len(found) // 2
    hard = [k for k, (path, expansions) in enumerate(plain) if path and expansions > HARD]
    assert len(hard) > 1
    before, after = (sum(each[k][1] for k in hard) for each in (plain, corrected))
    assert after < 0.7 * before
