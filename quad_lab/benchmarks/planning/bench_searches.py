"""
Part of ``quadwalk bench planner``: the quickest path beside the shortest, and turns proven.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.walking_time import load_pace
from quad_lab.tools.benchmark_maps import load_scenario, scenario_files
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_planner.grid.bit_grid import BitGrid, BitMask
from quad_planner.grid.inflation import inflated
from quad_planner.methods.shortest_planner import turns_saved
from quad_planner.search.jump_points import JumpPointSearch
from quad_planner.search.lattice_search import fewest_turns
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.search.weighted_search import cheapest_path
from quad_planner.wave.wave_search import quickest_path

Mask = NDArray[np.bool_]
Result = TypeVar('Result')

_RADIUS = 8.0
"""That the robot keeps from occupied cells [cells]."""
_RESOLUTION = 0.05
"""[m]"""


def search_bars(
    makes: Mapping[str, Callable[[int, int], Mask]], quick: bool, seed: int
) -> list[Criterion]:
    """
    Time searches over cells and headings beside A* over the cells alone.

    Parameters
    ----------
    makes : mapping of str to callable
        Draw maps of a size from a seed, by the kind of map.
    quick : bool
        Smaller maps, fewer requests.
    seed : int
        Of the maps and of the requests.

    Returns
    -------
    list of Criterion
        For each kind of map.
    """
    size, count = (512, 5) if quick else (1024, 25)
    bars = []
    for kind, make in makes.items():
        bars += _bars(f'{kind} {size}', make(size, seed), count, seed)
    return bars


def scenario_bars(quick: bool) -> list[Criterion]:
    """
    Search MovingAI's problems, and compare with the lengths that are published.

    Parameters
    ----------
    quick : bool
        One in twenty.

    Returns
    -------
    list of Criterion
        How many are right; not measured where the files are not there.
    """
    right = count = 0
    for file in scenario_files():
        free, problems = load_scenario(file)
        search = JumpPointSearch(BitGrid.of(free))
        for problem in problems[:: 20 if quick else 1]:
            path = search.path(problem.start, problem.goal)
            right += problem.is_right(None if path is None else path.length)
            count += 1
    name = f'{count} problems of MovingAI: lengths as published'
    return [at_least(name, 100.0 * right / count if count else None, '%', 100.0)]


def _bars(name: str, occupied: Mask, count: int, seed: int) -> list[Criterion]:
    forbidden = inflated(BitMask.of(occupied), _RADIUS)
    grid = BitGrid.outside(forbidden)
    search = JumpPointSearch(grid)
    free = np.argwhere(~forbidden.unpacked())[:, ::-1]
    plain = np.ones(occupied.shape)
    pace = load_pace('titan_viii', 'crawl')
    rng = np.random.default_rng(seed)
    times: list[tuple[float, float, float, float]] = []
    saved = []
    while len(times) < count:
        ends = free[rng.integers(0, len(free), 2)].tolist()
        start, goal = ((int(x), int(y)) for x, y in ends)
        yaw, goal_yaw = rng.uniform(-math.pi, math.pi, 2).tolist()
        by_jumps, path = _timed(lambda: search.path(start, goal))  # noqa: B023
        if path is None or len(path.cells) < 2:
            continue
        cells = turns_saved(path.cells, forbidden.words)
        points = (cells + 0.5) * _RESOLUTION
        known = pace.cycles(
            Pose2D(float(points[0, 0]), float(points[0, 1]), yaw), Plan.through(points, goal_yaw)
        )
        by_a_star, _ = _timed(lambda: cheapest_path(grid, plain, start, goal))  # noqa: B023
        terms = WalkTerms(pace, _RESOLUTION, yaw, goal_yaw, known + 1)
        quickest, _ = _timed(lambda: quickest_path(grid, start, goal, terms))  # noqa: B023
        proof, fewest = _timed(lambda: fewest_turns(grid, cells))  # noqa: B023
        times.append((by_jumps, by_a_star, quickest, proof))
        saved.append(len(cells) - len(fewest))
    jumps, a_star, quickest_, proof_ = np.median(times, axis=0).tolist()
    return [
        figure(f'{name}: shortest by jump points', 1e3 * jumps, 'ms'),
        figure(f'{name}: shortest by A*', 1e3 * a_star, 'ms'),
        figure(f'{name}: quickest over cells and headings', 1e3 * quickest_, 'ms'),
        at_most(f'{name}: quickest, of the time of A*', quickest_ / a_star, 'x', 8.0),
        figure(f'{name}: fewest turns proven', 1e3 * proof_, 'ms'),
        figure(f'{name}: paths that had the fewest', 100.0 * saved.count(0) / count, '%'),
        figure(f'{name}: turns saved by the proof, at most', float(max(saved)), 'turns'),
    ]


def _timed(work: Callable[[], Result]) -> tuple[float, Result]:
    """Return the shorter of two times [s], and the result."""
    times = []
    for _ in range(2):
        began = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - began)
    return min(times), result
