"""
Part of ``quadwalk bench planner``: plans by the outline against brute force, and in physics.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from quad_common.errors import PlannerError
from quad_common.maps.occupancy_grid import OCCUPIED, OccupancyGrid
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.planning.footprint_maps import (
    free_classes,
    office,
    office_with_closets,
    reachable,
)
from quad_lab.closed_loop.map_walk import MapWalk
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_planner.methods.outline_planner import BY_OUTLINE, OutlinePlanner
from quad_planner.methods.planner import Planner
from quad_planner.methods.shortest_planner import ShortestPlanner
from quad_planner.outline.heading_kernels import STEP
from quad_planner.outline.heading_moves import moves_from
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import outline_for, planner_for

_SAFETY = 0.05
"""Distance that the robot keeps from obstacles [m]."""

_RESOLUTION = 0.05
"""Side of the offices' cells [m]."""

_MAPS = {'a1': 200, 'titan_viii': 40, 'genibo': 40}
"""Offices for each robot."""

_SMALL, _LARGE = 200, 1024
"""Sides of the offices that brute force floods, and of that whose plans are timed [cells]."""

_REQUESTS = 10
"""Goals on each office; on the large one twenty times as many."""

_TIMEOUT = 600.0
"""A walk that takes longer has failed [s], simulated."""


@dataclass(frozen=True)
class _Door:
    """A walk through a door that is narrower than the robot's circle."""

    robot: str
    gait: str
    turning: str
    width: float
    """Width of the door [m]."""
    seed: int


_WALKS = (
    *(_Door('a1', 'trot', 'in_place', 0.55, seed) for seed in range(8)),
    *(_Door('a1', 'crawl', 'in_place', 0.55, seed) for seed in range(8, 11)),
    *(_Door('a1', 'trot', 'crab', 0.55, seed) for seed in range(11, 13)),
    *(_Door('a1', 'trot', 'arc', 0.55, seed) for seed in range(13, 15)),
    *(_Door('genibo', 'trot', 'in_place', 0.275, seed) for seed in range(15, 18)),
    *(_Door('titan_viii', 'trot', 'crab', 0.7, seed) for seed in range(18, 20)),
)
"""The walks; in a crab gait TITAN-VIII, which is wider than long, goes through sideways."""


def footprint_bars(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Plan by outlines through offices, and walk through narrow doors.

    Parameters
    ----------
    console : Console
        Where tables go.
    quick : bool
        Few maps and walks.
    seed : int
        Of the maps and requests.

    Returns
    -------
    tuple
        The bars, and details for JSON.
    """
    bars: list[Criterion] = []
    for robot, maps in _MAPS.items():
        bars += _against_brute_force(robot, maps // 20 if quick else maps, seed)
        console.print(f'{robot}: offices done')
    bars += _against_circle('a1', seed, 2 if quick else 20)
    bars += _times('a1', seed, _REQUESTS if quick else 20 * _REQUESTS)
    bars += _times_without_path('a1', seed, 1 if quick else 3)
    doors = _WALKS[:2] if quick else _WALKS
    with worker_pool() as pool:
        walks = list(pool.map(_walk, doors))
    table = Table('robot', 'gait', 'turning', 'door [m]', 'arrived', 'contacts', 'time [s]')
    for door, walk in zip(doors, walks):
        contacts = ', '.join(walk['contacts']) or 'none'
        table.add_row(
            door.robot,
            door.gait,
            door.turning,
            f'{door.width:g}',
            'yes' if walk['arrived'] else walk['reason'],
            contacts,
            f'{walk["duration"]:.0f}',
        )
    console.print(table)
    good = sum(w['arrived'] and w['by_outline'] and not w['contacts'] for w in walks)
    name = 'walks through doors narrower than the circle that arrived without contact'
    bars.append(at_least(f'{name}, of {len(doors)}', good, 'walks', len(doors)))
    return bars, {'walks': walks}


def _planner(robot: str, tolerance: float = 0.0, **options: Any) -> Planner[Any]:
    made = load_robot(robot)
    return planner_for(
        made,
        'shortest',
        _SAFETY,
        outline_for(made, _SAFETY, start_tolerance=tolerance),
        start_tolerance=tolerance,
        **options,
    )


def _pose(k: int, y: int, x: int) -> Pose2D:
    return Pose2D((x + 0.5) * _RESOLUTION, (y + 0.5) * _RESOLUTION, k * STEP)


def _plan(planner: Planner[Any], start: Pose2D, goal: Pose2D) -> Plan | None:
    try:
        return planner.plan(start, goal)
    except PlannerError:
        return None


def _against_brute_force(robot: str, maps: int, seed: int) -> list[Criterion]:
    """Compare which goals are reached with a flood over all cells and headings."""
    made = load_robot(robot)
    circle = ShortestPlanner(clearance_radius=made.standing_radius + _SAFETY)
    planner: OutlinePlanner[Any] = OutlinePlanner(circle, outline_for(made, _SAFETY))
    moves = moves_from(0.5, 0.5)
    reached = missed = wrong = 0
    for at in range(maps):
        rng = np.random.default_rng((seed, at))
        prepared = planner.prepare(office(_SMALL, _RESOLUTION, rng))
        free = free_classes(prepared.blocked, prepared.allowed, prepared.kernels[0])
        states = np.argwhere(free)
        start = tuple(map(int, states[rng.integers(len(states))]))
        ends = reachable(free, moves, (start[0], start[1], start[2]))
        for _ in range(_REQUESTS):
            goal = tuple(map(int, states[rng.integers(len(states))]))
            plan = planner.plan_by_outline(prepared, _pose(*start), _pose(*goal))
            found = plan is not None
            reached += bool(ends[goal])
            missed += bool(ends[goal]) and not found
            wrong += found and not ends[goal]
    name = f'{robot}: {maps} offices, goals'
    return [
        figure(f'{name} that brute force reaches, of {maps * _REQUESTS}', reached, 'goals'),
        at_most(f'{name} that the outline misses', missed, 'goals', 0),
        at_most(f'{name} that only the outline reaches', wrong, 'goals', 0),
    ]


def _against_circle(robot: str, seed: int, maps: int) -> list[Criterion]:
    """Compare lengths with those of the circle's plans, which the pace's lack makes the costs."""
    outline = _planner(robot, any_angle=True)
    made = load_robot(robot)
    circle = planner_for(made, 'shortest', _SAFETY, start_tolerance=0.0, any_angle=True)
    refused = longer = more = both = 0
    for at in range(maps):
        rng = np.random.default_rng((seed, at))
        grid = office(_SMALL, _RESOLUTION, rng)
        for planner in (outline, circle):
            planner.set_map(grid)
        assert circle.prepared is not None
        cells = np.argwhere(circle.prepared.allowed)
        for _ in range(_REQUESTS):
            start, goal = (
                _pose(int(rng.integers(72)), *map(int, cells[rng.integers(len(cells))]))
                for _ in range(2)
            )
            ours, theirs = _plan(outline, start, goal), _plan(circle, start, goal)
            if theirs is not None:
                both += 1
                refused += ours is None
                longer += ours is not None and ours.length > theirs.length + 1e-9
            more += theirs is None and ours is not None
    return [
        at_most(f'{robot}: plans by the circle that are refused, of {both}', refused, 'plans', 0),
        at_most(f'{robot}: plans by the circle that are shorter, of {both}', longer, 'plans', 0),
        figure(f'{robot}: plans that only the outline makes', more, 'plans'),
    ]


def _times(robot: str, seed: int, requests: int) -> list[Criterion]:
    """
    Time plans on a large office, between any two places where the robot fits.

    Times of a plan are the processor's: of the longest of hundreds it is not to be told whether
    the machine did something else meanwhile.
    """
    planner = _planner(robot)
    planner.warm_up()
    rng = np.random.default_rng(seed)
    grid = office(_LARGE, _RESOLUTION, rng)
    began = time.perf_counter()
    planner.set_map(grid)
    prepared = planner.prepared
    assert prepared is not None
    _ = prepared.zones, prepared.small
    took = time.perf_counter() - began
    cells = np.argwhere(prepared.allowed)
    times, found = [], []
    for _ in range(requests):
        start, goal = (
            _pose(int(rng.integers(72)), *map(int, cells[rng.integers(len(cells))]))
            for _ in range(2)
        )
        began = time.process_time()
        found.append(_plan(planner, start, goal) is not None)
        times.append(time.process_time() - began)
    name = f'{robot}: a plan on an office of {_LARGE} x {_LARGE}'
    return [
        figure(f'{robot}: preparing that office', 1e3 * took, 'ms'),
        figure(f'{name}, median of {requests}', 1e3 * float(np.median(times)), 'ms'),
        figure(f'{name}, 90 % of {requests}', 1e3 * float(np.percentile(times, 90)), 'ms'),
        figure(f'{name}, most where there is one', 1e3 * max(np.array(times)[found]), 'ms'),
        at_most(f'{name}, at most', 1e3 * max(times), 'ms', 50.0),
    ]


def _times_without_path(robot: str, seed: int, maps: int) -> list[Criterion]:
    """Time requests for goals in closets, which no turn leads into, as :func:`_times` does."""
    planner = _planner(robot)
    planner.warm_up()
    times, found = [], 0
    for at in range(maps):
        rng = np.random.default_rng((seed, at))
        grid, closets = office_with_closets(_LARGE, _RESOLUTION, rng)
        planner.set_map(grid)
        prepared = planner.prepared
        assert prepared is not None
        _ = prepared.zones, prepared.small
        cells = np.argwhere(prepared.allowed)
        for x, y in closets:
            start = _pose(int(rng.integers(72)), *map(int, cells[rng.integers(len(cells))]))
            goal = _pose(int(rng.integers(72)), y, x)
            began = time.process_time()
            plan = _plan(planner, start, goal)
            took = time.process_time() - began
            found += plan is not None
            if plan is None:
                times.append(took)
    name = f'{robot}: a request without a path on an office of {_LARGE} x {_LARGE}'
    return [
        figure(f'{name}, goals in closets with a path', found, 'goals'),
        figure(f'{name}, median of {len(times)}', 1e3 * float(np.median(times)), 'ms'),
        at_most(f'{name}, at most', 1e3 * max(times), 'ms', 50.0),
    ]


def _walk(door: _Door) -> dict[str, Any]:
    """Walk through a door, from one room to the next."""
    rng = np.random.default_rng(door.seed)
    resolution, wall = 0.025, slice(76, 80)
    cells = np.zeros((120, 160), dtype=np.int8)
    cells[[0, -1]] = OCCUPIED
    cells[:, [0, -1]] = OCCUPIED
    width = round(door.width / resolution)
    low = int(rng.integers(36, 84 - width))
    cells[:, wall] = OCCUPIED
    cells[low : low + width, wall] = 0
    # With a crab gait the heading is that in which the robot fits through.
    heading = math.pi / 2.0 if door.robot == 'titan_viii' else 0.0
    start, goal = (
        Pose2D(
            float(rng.uniform(low_x, low_x + 0.25)),
            float(rng.uniform(0.9, 2.1)),
            heading if door.turning == 'crab' else float(rng.uniform(-math.pi, math.pi)),
        )
        for low_x in (0.65, 3.0)
    )
    parameters = PlannerParameters(
        robot=door.robot,
        gait=door.gait,
        turning=door.turning,
        method='shortest',
        any_angle=True,
        footprint='outline',
        safety_distance=_SAFETY,
    )
    grid = OccupancyGrid(cells, resolution, Pose2D(0.0, 0.0, 0.0))
    walk = MapWalk(parameters, grid, start, goal, 'mujoco')
    try:
        record = walk.run(_TIMEOUT)
    finally:
        walk.close()
    return {
        'robot': door.robot,
        'gait': door.gait,
        'turning': door.turning,
        'seed': door.seed,
        'arrived': record.has_arrived,
        'reason': record.reason,
        'by_outline': bool(record.plans) and record.plans[0].remark == BY_OUTLINE,
        'contacts': sorted(record.contacts),
        'duration': record.duration,
    }
