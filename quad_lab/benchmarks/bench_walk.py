"""
``quadwalk bench walk``: random walks over sample maps and maps of others, over topics.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.table import Table

from quad_common.errors import ParameterError, PlannerError
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_lab.tools.benchmark_maps import OTHERS_MAPS, benchmark_maps
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.walk import WalkOptions, walk
from quad_lab.topic_walk.walk_record import WalkRecord, WalkResult
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.methods.planner import Planner
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters
from quad_sim.engines.registry import AUTO, make_simulator

PAIRS = 30
QUICK_PAIRS = 4
QUICK_LENGTH = 1.5
"""Longest path of the quick sample [m]."""
SHORTEST = 0.5
"""Shortest path that is worth a walk [m]."""
QUICK_BUDGET = 28.0
"""The quick sample begins no further walk after so long [s]."""

_ROBOT = 'titan_viii'

_MOST_DRAWS = 20_000
"""So many pairs in a row that have no plan of such a length mean that there is none."""


@dataclass(eq=False, repr=False)
class NoPairFound(PlannerError):
    """No pair of poses that was drawn has a plan of the wanted length."""

    draws: int
    """Number of pairs that were drawn."""
    map_name: str
    """Name of the map file."""
    lengths: tuple[float, float]
    """Least and largest length of the plan [m]."""

    def sentence(self) -> str:
        """Say which lengths were wanted."""
        shortest, longest = self.lengths
        return (
            f'of {self.draws} random pairs of poses on {self.map_name} none has a plan '
            f'of {shortest:g} to {longest:g} m'
        )


def measure(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress and the table of walks go.
    quick : bool
        Only a few short walks.
    seed : int
        Of the start and goal poses.

    Returns
    -------
    tuple
        The bars, and details for JSON: every walk's figures.
    """
    robot = load_robot(_ROBOT)
    maps = benchmark_maps()
    longest = QUICK_LENGTH if quick else math.inf
    pairs = draw_pairs(robot, maps, QUICK_PAIRS if quick else PAIRS, longest, seed)
    bare = bare_factor(robot, 1.0 if quick else 5.0)
    walks: list[tuple[str, WalkRecord, WalkResult]] = []
    began = time.monotonic()
    for number, (path, start, goal) in enumerate(pairs, 1):
        record = walk(WalkOptions(map_file=path, start=start, goal=goal, robot=_ROBOT, seed=seed))
        result = record.result()
        walks.append((path.stem, record, result))
        _say(console, number, len(pairs), path.stem, result)
        if quick and time.monotonic() - began > QUICK_BUDGET:
            break
    results = [result for _, _, result in walks]
    _print_walks(console, walks)
    bars = _bars(results, bare, [record for _, record, _ in walks])
    others = len({path.stem for path in maps} & set(OTHERS_MAPS))
    bars.insert(
        0, at_least('maps of others walked on', others or None, f'of {len(OTHERS_MAPS)}', 2)
    )
    if others < len(OTHERS_MAPS):
        console.print("Nav2's maps depot and warehouse were not found: set QUADWALK_MAPS.")
    details: dict[str, object] = {
        'quick': quick,
        'seed': seed,
        'maps': [path.stem for path in maps],
        'walks': [{'map': name, **result.as_dict()} for name, _, result in walks],
    }
    return bars, details


def draw_pairs(
    robot: Robot, maps: list[Path], count: int, longest: float, seed: int
) -> list[tuple[Path, Pose2D, Pose2D]]:
    """
    Draw start and goal poses that have a plan, the maps in turn.

    Parameters
    ----------
    robot : Robot
        Whose clearance counts.
    maps : list of Path
        The maps.
    count : int
        How many pairs.
    longest : float
        Longest plan [m]; more than :data:`SHORTEST`.
    seed : int
        Of the drawing.

    Returns
    -------
    list of (Path, Pose2D, Pose2D)
        Map, start and goal.

    Raises
    ------
    ParameterError
        If no plan can be so short, or there is no map.
    PlannerError
        If none is found on a map.
    """
    if not longest > SHORTEST:
        raise ParameterError('longest', longest, f'more than {SHORTEST:g} m')
    if not maps:
        raise ParameterError('maps', maps, 'one map at least')
    rng = np.random.default_rng(seed)
    # A pair counts if the node would walk it.
    parameters = PlannerParameters(robot=_ROBOT, method='mesh')
    loaded = []
    for path in maps:
        planner = planner_from_parameters(parameters, robot)
        grid = load_map(path)
        planner.set_map(grid)
        loaded.append((path, grid, planner))
    pairs: list[tuple[Path, Pose2D, Pose2D]] = []
    while len(pairs) < count:
        path, grid, planner = loaded[len(pairs) % len(loaded)]
        for _ in range(_MOST_DRAWS):
            start, goal = (_random_pose(grid, rng) for _ in range(2))
            if SHORTEST < _plan_length(planner, start, goal) <= longest:
                pairs.append((path, start, goal))
                break
        else:
            raise NoPairFound(_MOST_DRAWS, path.name, (SHORTEST, longest))
    return pairs


def bare_factor(robot: Robot, duration: float) -> float:
    """Measure how much faster than real time the bare physics of a standing robot are."""
    simulator = make_simulator(AUTO, robot, None)
    joints = robot.initial_joint_angles.reshape(-1)
    still = np.zeros_like(joints)
    began = time.perf_counter()
    while time.perf_counter() - began < duration:
        for _ in range(100):
            simulator.step(joints, still)
    factor = simulator.time / (time.perf_counter() - began)
    simulator.close()
    return factor


def _random_pose(grid: OccupancyGrid, rng: np.random.Generator) -> Pose2D:
    cell = rng.uniform((0.0, 0.0), (grid.width, grid.height))
    x, y = grid.map_to_world(cell)
    return Pose2D(round(float(x), 3), round(float(y), 3), float(rng.uniform(-math.pi, math.pi)))


def _plan_length(planner: Planner[InflatedMap], start: Pose2D, goal: Pose2D) -> float:
    try:
        return planner.plan(start, goal).length
    except PlannerError:
        return 0.0


def _bars(results: list[WalkResult], bare: float, records: list[WalkRecord]) -> list[Criterion]:
    wall = sum(result.wall_time for result in results)
    simulated = sum(result.walking_time or 0.0 for result in results)
    factor = simulated / wall if wall > 0.0 else None
    physics = sum(record.seconds_in_physics for record in records)
    publishing = sum(record.seconds_publishing for record in records)
    return [
        at_least(
            'walks that arrived',
            sum(r.arrived for r in results),
            f'of {len(results)}',
            len(results),
        ),
        at_most('largest final position error', _worst(results, 'position_error'), 'm', 0.05),
        at_most('largest final heading error', _worst(results, 'heading_error'), 'deg', 5.0),
        at_most(
            'largest distance from the path', _worst(results, 'largest_path_distance'), 'm', 0.10
        ),
        at_most('walks with contacts', sum(bool(r.contacts) for r in results), '', 0),
        at_most('falls', sum(r.fallen for r in results), '', 0),
        at_least('least planned stability margin', _least_margin(results), 'm', 0.0),
        at_least('speed, wired by topics', factor, 'x real time', 10.0),
        figure('speed of bare physics steps', bare, 'x real time'),
        figure('fraction of the bare speed', factor / bare if factor else None, ''),
        figure('wall time: physics', physics / wall if wall else None, 'fraction'),
        figure(
            'wall time: observing and publishing', publishing / wall if wall else None, 'fraction'
        ),
        figure(
            'wall time: receiving, waiting',
            1.0 - (physics + publishing) / wall if wall else None,
            'fraction',
        ),
        at_most('trajectories that came late', sum(r.late_trajectories for r in results), '', 0),
        figure('walked', sum(r.walked_distance for r in results), 'm'),
        figure('mean walking speed along the path', _speed(results), 'm/s'),
    ]


def _worst(results: list[WalkResult], name: str) -> float | None:
    values = [getattr(result, name) for result in results]
    return None if not values or None in values else max(values)


def _least_margin(results: list[WalkResult]) -> float | None:
    values = [result.least_stability_margin for result in results]
    known = [value for value in values if value is not None]
    return min(known) if len(known) == len(values) and known else None


def _speed(results: list[WalkResult]) -> float | None:
    length = sum(result.path_length or 0.0 for result in results)
    duration = sum(result.walking_time or 0.0 for result in results)
    return length / duration if duration > 0.0 else None


def _say(console: Console, number: int, count: int, name: str, result: WalkResult) -> None:
    outcome = 'arrived' if result.arrived else f'did not arrive: {result.problem}'
    console.print(
        f'{number}/{count} {name}: {outcome}, {result.path_length or 0.0:.1f} m in '
        f'{result.walking_time or 0.0:.0f} s simulated, {result.wall_time:.0f} s on the wall clock',
        highlight=False,
    )


def _print_walks(console: Console, walks: list[tuple[str, WalkRecord, WalkResult]]) -> None:
    table = Table(
        'map',
        'arrived',
        'path [m]',
        'turning points',
        'time [s]',
        'position error [m]',
        'heading error [deg]',
        'from path [m]',
        'least margin [m]',
        'contacts',
        'x real time',
    )
    for name, _, r in walks:
        numbers = (
            r.position_error,
            r.heading_error,
            r.largest_path_distance,
            r.least_stability_margin,
        )
        table.add_row(
            name,
            'yes' if r.arrived else 'NO',
            f'{r.path_length or 0.0:.1f}',
            str(r.turning_points),
            f'{r.walking_time or 0.0:.0f}',
            *('-' if n is None else f'{n:.3f}' for n in numbers),
            r.contacts or 'none',
            f'{r.real_time_factor or 0.0:.1f}',
        )
    console.print(table)
