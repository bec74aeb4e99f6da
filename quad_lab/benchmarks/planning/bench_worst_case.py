"""
Part of ``quadwalk bench planner``: the methods that take longest, on maps that others made.

Nav2's depot and warehouse, Willow Garage where its map lies beside them, and a floor of 400
offices; TITAN-VIII and genibo, a small robot.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from quad_common.errors import PlannerError
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.walking_time import load_pace
from quad_lab.benchmarks.planning.office_floor import office_floor
from quad_lab.tools.benchmark_maps import OTHERS_MAPS, maps_of_others
from quad_lab.tools.criterion import Criterion, at_most
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.planner import Planner
from quad_planner.planner_setup import planner_for

Array = NDArray[np.float64]

_ROBOTS = ('genibo', 'titan_viii')
_SAFETY_DISTANCE = 0.05
"""[m]"""


class _Method(NamedTuple):
    """A method, and how long it may take [ms]."""

    name: str
    any_angle: bool
    median: float
    most: float


_METHODS = {
    'shortest, any angle': _Method('shortest', True, 2.0, 20.0),
    'mesh': _Method('mesh', False, 10.0, 50.0),
    'quickest': _Method('quickest', False, 20.0, 150.0),
    'quickest, any angle': _Method('quickest', True, 20.0, 150.0),
}

_PREPARATION = 100.0
"""Time in which a map is to be ready for `mesh` [ms]."""


def worst_case_bars(console: Console, quick: bool, seed: int) -> list[Criterion]:
    """
    Time plans between random poses.

    Parameters
    ----------
    console : Console
        Where the table goes.
    quick : bool
        Few requests.
    seed : int
        Of the poses, and of the offices.

    Returns
    -------
    list of Criterion
        For each method the largest of the maps' and robots' medians and the longest plan.
    """
    table = Table('map', 'robot', 'method', 'prepared [ms]', 'median', '90 %', 'most [ms]')
    times: dict[str, list[Array]] = {label: [] for label in _METHODS}
    preparations = []
    for name, grid in _maps(seed):
        for robot in _ROBOTS:
            for label, method in _METHODS.items():
                planner = _planner(robot, method)
                prepared = _preparation(planner, grid)
                took = _times(planner, grid, 5 if quick else 50, seed)
                times[label].append(took)
                if label == 'mesh':
                    preparations.append(prepared)
                figures = (prepared, np.median(took), np.percentile(took, 90), took.max())
                table.add_row(name, robot, label, *(f'{figure:.1f}' for figure in figures))
    console.print(table)
    bars = []
    for label, method in _METHODS.items():
        median = max(float(np.median(took)) for took in times[label])
        most = max(float(took.max()) for took in times[label])
        bars.append(at_most(f'{label}: worst median of a plan', median, 'ms', method.median))
        bars.append(at_most(f'{label}: longest plan', most, 'ms', method.most))
    bars.append(at_most('mesh: longest preparation', max(preparations), 'ms', _PREPARATION))
    return bars


def _maps(seed: int) -> Iterator[tuple[str, OccupancyGrid]]:
    """Load the maps that are there, and draw the offices."""
    for name in (*OTHERS_MAPS, 'willow'):
        for path in sorted(maps_of_others().glob(f'**/{name}.yaml'))[:1]:
            yield name, load_map(path)
    yield '400 offices', office_floor(seed=seed)


def _planner(robot: str, method: _Method) -> Planner[InflatedMap]:
    """Return a planner whose code is compiled."""
    planner = planner_for(
        load_robot(robot),
        method.name,
        _SAFETY_DISTANCE,
        any_angle=method.any_angle,
        pace=load_pace(robot, 'crawl'),
    )
    planner.warm_up()
    return planner


def _preparation(planner: Planner[InflatedMap], grid: OccupancyGrid) -> float:
    """Let a planner take a map; return how long that took [ms]."""
    began = time.perf_counter()
    planner.set_map(grid)
    return 1e3 * (time.perf_counter() - began)


def _times(planner: Planner[InflatedMap], grid: OccupancyGrid, count: int, seed: int) -> Array:
    """Plan between random poses in the largest free area; return how long each plan took [ms]."""
    rng = np.random.default_rng(seed)
    prepared = planner.prepared
    assert prepared is not None
    sizes = np.bincount(prepared.areas.ravel())
    free = np.argwhere(prepared.areas == 1 + int(np.argmax(sizes[1:])))[:, ::-1]
    times: list[float] = []
    # The first plan makes ready what is made when it is first needed.
    while len(times) <= count:
        ends = grid.map_to_world(free[rng.integers(0, len(free), 2)] + rng.random((2, 2)))
        yaws = rng.uniform(-np.pi, np.pi, 2)
        poses = [Pose2D(*map(float, (*end, yaw))) for end, yaw in zip(ends, yaws)]
        took = []
        # The shorter of two times: others share the machine.
        for _ in range(2):
            began = time.perf_counter()
            try:
                planner.plan(*poses)
            except PlannerError:
                break
            took.append(1e3 * (time.perf_counter() - began))
        if took:
            times.append(min(took))
    return np.array(times[1:])
