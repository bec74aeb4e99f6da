"""
Part of ``quadwalk bench planner``: how much walking time the quickest path saves, in physics.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from quad_common.errors import PlannerError
from quad_common.maps.map_file import load_map
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.walking_time import load_pace
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.gait_measures import plan_walk
from quad_lab.tools.benchmark_maps import benchmark_maps
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.planner import Planner
from quad_planner.planner_setup import planner_for

Array = NDArray[np.float64]

_ROBOT, _GAIT = 'titan_viii', 'crawl'

_METHODS = {
    'mesh': ('mesh', False),
    'shortest': ('shortest', False),
    'shortest, any angle': ('shortest', True),
    'quickest': ('quickest', False),
    'quickest, any angle': ('quickest', True),
}
"""Names, and of each the method and whether it takes any angle."""

_WALKED = ('mesh', 'quickest, any angle')

_NEAREST = 3.0
"""Start and goal are at least so far apart [m]."""

_TIMEOUT = 4000.0
"""A walk that takes longer has failed [s], simulated."""


@dataclass(frozen=True)
class _Request:
    """A start and a goal, and what the methods make of them."""

    map_name: str
    start: Pose2D
    plans: dict[str, Plan]


def walking_bars(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Plan between random poses by every method, and walk the mesh's plans and the quickest.

    Parameters
    ----------
    console : Console
        Where tables go.
    quick : bool
        Walk few.
    seed : int
        Of the poses.

    Returns
    -------
    tuple
        The bars, and details for JSON.
    """
    rng = np.random.default_rng(seed)
    maps = _maps()
    each = 1 if quick else 15
    requests = [request for path in maps for request, _ in zip(_requests(path, rng), range(each))]
    pace = load_pace(_ROBOT, _GAIT)
    cycles = {
        name: np.array([float(pace.cycles(r.start, r.plans[name])) for r in requests])
        for name in _METHODS
    }
    console.print(_table(requests, cycles, pace.cycle_period))
    jobs = [(name, request) for request in requests for name in _WALKED]
    with worker_pool() as pool:
        walked = list(pool.map(_walk, *zip(*((r.start, r.plans[name]) for name, r in jobs))))
    times = {
        name: np.array([time for time, job in zip(walked, jobs) if job[0] == name])
        for name in _WALKED
    }
    bars = _bars(requests, times, {n: pace.cycle_period * cycles[n] for n in _WALKED})
    details = {
        'maps': [path.stem for path in maps],
        'requests': [
            {
                'map': request.map_name,
                'start': asdict(request.start),
                'goal': asdict(request.plans['mesh'].poses[-1]),
                'cycles': {name: int(cycles[name][at]) for name in _METHODS},
                'walked': {name: float(times[name][at]) for name in _WALKED},
            }
            for at, request in enumerate(requests)
        ],
    }
    return bars, details


def _table(requests: list[_Request], cycles: dict[str, Array], cycle_period: float) -> Table:
    table = Table('method', 'mean length [m]', 'mean walking time [s]', 'saved over mesh [%]')
    for name in _METHODS:
        lengths = [request.plans[name].length for request in requests]
        table.add_row(
            name,
            f'{np.mean(lengths):.1f}',
            f'{cycle_period * cycles[name].mean():.0f}',
            f'{100.0 * _saved(cycles["mesh"], cycles[name]).mean():.1f}',
        )
    return table


def _bars(
    requests: list[_Request], times: dict[str, Array], predicted: dict[str, Array]
) -> list[Criterion]:
    """Compare the walked times [s], NaN for walks that failed."""
    mesh, quickest = (times[name] for name in _WALKED)
    saved = 100.0 * _saved(mesh, quickest)
    errors = [np.abs(times[name] / predicted[name] - 1.0) for name in _WALKED]
    arrived = sum(int(np.isfinite(times[name]).sum()) for name in _WALKED)
    count = len(requests)
    bars = [
        at_least(f'walks that arrived, of {2 * count}', arrived, 'walks', 2 * count),
        at_least(f'walking time saved over mesh, mean of {count}', saved.mean(), '%', 10.0),
    ]
    for name, fraction in (('least', 0), ('lower quartile', 25), ('median', 50), ('most', 100)):
        value = float(np.nanpercentile(saved, fraction)) if np.isfinite(saved).any() else None
        bars.append(figure(f'walking time saved over mesh, {name}', value, '%'))
    bars.append(at_most('predicted walking time, largest error', 100.0 * np.max(errors), '%', 3.0))
    return bars


def _saved(mesh: Array, other: Array) -> Array:
    saved: Array = 1.0 - other / mesh
    return saved


def _maps() -> list[Path]:
    """Return Nav2's maps if they are there, or our own."""
    maps = benchmark_maps()
    return maps[2:] or maps


def _requests(path: Path, rng: np.random.Generator) -> Iterator[_Request]:
    """Draw poses in the largest free area of a map, between which every method finds a path."""
    grid = load_map(path)
    robot = load_robot(_ROBOT)
    planners: dict[str, Planner[InflatedMap]] = {}
    for label, (method, any_angle) in _METHODS.items():
        pace = load_pace(_ROBOT, _GAIT)
        planners[label] = planner_for(robot, method, any_angle=any_angle, pace=pace)
        planners[label].set_map(grid)
    prepared = planners['mesh'].prepared
    assert prepared is not None
    sizes = np.bincount(prepared.areas.ravel())
    free = np.argwhere(prepared.areas == 1 + int(np.argmax(sizes[1:])))[:, ::-1]
    while True:
        ends = grid.map_to_world(free[rng.integers(0, len(free), 2)] + rng.random((2, 2)))
        yaws = rng.uniform(-np.pi, np.pi, 2)
        start, goal = (Pose2D(*map(float, (*end, yaw))) for end, yaw in zip(ends, yaws))
        if start.distance_to(goal) < _NEAREST:
            continue
        try:
            plans = {label: planner.plan(start, goal) for label, planner in planners.items()}
        except PlannerError:
            continue
        yield _Request(path.stem, start, plans)


def _walk(start: Pose2D, plan: Plan) -> float:
    """Walk a plan in physics; return the time from the first cycle to the arrival [s]."""
    robot = load_robot(_ROBOT)
    to_start = start.inverse()
    local = Plan(tuple(to_start @ pose for pose in plan.poses))
    walk = plan_walk(robot, load_gait(_GAIT, robot), local, 'in_place', timeout=_TIMEOUT)
    return walk.record.times[-1] - walk.record.times[0] if walk.arrived else float('nan')
