"""
Walks by height maps as real ones are: shifted, with holes, or none; and by odometry that drifts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.ground_walk import (
    TERRAINS,
    GroundOutcome,
    Knowledge,
    Scene,
    make_scene,
    walk_scene,
)
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.simulated_localisation import LocalisationOptions

WRONG_MAP = 'wrong_map'
"""Part of ``quadwalk bench ground`` that walks by wrong maps."""

FAULTS = ('shifted', 'holes', 'none')
"""What is wrong with a map; odometry drifts with each."""

_SAID = {
    'shifted': 'map shifted, odometry drifts',
    'holes': 'map with holes, odometry drifts',
    'none': 'no height map, odometry drifts',
}
"""The same in words."""

_SHIFT = 0.02
"""Distance by which a shifted map is off along x, y and z [m, of TITAN-VIII]."""

_DRIFT = 0.03
"""Drift of odometry, which nothing corrects [1]."""

_HOLE, _UNKNOWN = 0.12, 0.2
"""Radius of holes [m, of TITAN-VIII], and fraction of the ground that they cover."""

_WALKS = {'shifted': 100, 'holes': 30, 'none': 30}
"""Walks of each robot; the terrains take turns."""

_NEEDED = 0.95
"""Fraction of them that is to arrive."""

_QUICK = ('titan_viii', 'boxes', 'shifted')
"""The walk of the quick run."""


@dataclass(frozen=True)
class _Walk:
    """One walk, and how it went."""

    robot: str
    terrain: str
    fault: str
    seed: int
    outcome: GroundOutcome


def walk_by_wrong_maps(
    console: Console, quick: bool, seed: int, robots: tuple[str, ...], terrains: tuple[str, ...]
) -> tuple[list[Criterion], list[dict[str, Any]]]:
    """
    Walk between random places over random ground, by maps that are wrong.

    Parameters
    ----------
    console : Console
        Where progress is shown.
    quick : bool
        One walk only.
    seed : int
        Seed of the first walk on each terrain; the next ones follow it.
    robots, terrains : tuple of str
        Who walks over what.

    Returns
    -------
    bars : list of Criterion
        What was measured.
    walks : list of dict
        Every walk.
    """
    jobs = list(_jobs(robots, terrains, seed))
    if quick:
        jobs = [(*_QUICK, seed)] if _QUICK[0] in robots and _QUICK[1] in terrains else []
    walks: list[_Walk] = []
    if jobs:
        with worker_pool() as pool:
            for walk in pool.map(_walked, *zip(*jobs)):
                walks.append(walk)
                said = f'wrong map, walk {len(walks)} of {len(jobs)}, {_described(walk)}'
                console.print(said, highlight=False)
    bars = []
    for robot in robots:
        for fault in FAULTS:
            chosen = [w.outcome for w in walks if (w.robot, w.fault) == (robot, fault)]
            bars += _bars(f'{robot}, {_SAID[fault]}', chosen) if chosen else []
    return bars, [asdict(walk) for walk in walks]


def _jobs(
    robots: tuple[str, ...], terrains: tuple[str, ...], seed: int
) -> Iterator[tuple[str, str, str, int]]:
    kinds = list(TERRAINS)
    for fault, count in _WALKS.items():
        for number in range(count):
            terrain = kinds[number % len(kinds)]
            if terrain in terrains:
                yield from (
                    (robot, terrain, fault, seed + number // len(kinds)) for robot in robots
                )


def _walked(robot: str, terrain: str, fault: str, seed: int) -> _Walk:
    loaded = load_robot(robot)
    scene = make_scene(loaded, terrain, seed)
    knowledge = faulty_knowledge(loaded, scene, fault)
    outcome = walk_scene(loaded, scene, knowledge=knowledge)
    return _Walk(robot, terrain, fault, seed, outcome)


def _bars(name: str, outcomes: list[GroundOutcome]) -> list[Criterion]:
    count = len(outcomes)
    arrived, needed = sum(o.arrived for o in outcomes), math.ceil(count * _NEEDED - 1e-9)
    return [
        at_least(f'{name}: arrived, of {count}', arrived, '', needed),
        at_most(f'{name}: falls', sum(o.has_fallen for o in outcomes), '', 0),
        figure(
            f'{name}: walks with contacts of anything but feet',
            sum(bool(o.contacts) for o in outcomes),
            '',
        ),
        figure(f'{name}: walks with false alarms', sum(bool(o.alarms) for o in outcomes), ''),
        figure(f'{name}: largest tilt', math.degrees(max(o.largest_tilt for o in outcomes)), 'deg'),
        figure(
            f'{name}: truly off its goal, at most', 1e3 * max(o.distance for o in outcomes), 'mm'
        ),
    ]


def _described(walk: _Walk) -> str:
    outcome = walk.outcome
    end = f'arrived in {outcome.duration:.0f} s' if outcome.arrived else outcome.problem
    parts = (end, 'FELL' if outcome.has_fallen else '', '; '.join(outcome.contacts))
    said = ', '.join(part for part in parts if part)
    return f'{walk.robot} over {walk.terrain}, {_SAID[walk.fault]} (seed {walk.seed}): {said}'


def faulty_knowledge(robot: Robot, scene: Scene, fault: str) -> Knowledge:
    """
    Spoil what a robot knows of a scene.

    Parameters
    ----------
    robot : Robot
        The robot; lengths are in proportion to it.
    scene : Scene
        The scene; its seed decides on signs, holes and drift.
    fault : str
        One of :data:`FAULTS`.

    Returns
    -------
    Knowledge
    """
    rng = np.random.default_rng((scene.seed, FAULTS.index(fault)))
    localisation = LocalisationOptions(drift=_DRIFT, seed=scene.seed)
    heights: HeightMap | None = scene.height_map
    if fault == 'shifted':
        heights = shifted(scene.height_map, robot.relative_size * _SHIFT, rng)
    elif fault == 'holes':
        heights = with_holes(scene.height_map, robot.relative_size * _HOLE, rng)
    else:
        heights = None
    return Knowledge(heights, localisation)


def shifted(heights: HeightMap, distance: float, rng: np.random.Generator) -> HeightMap:
    """Return a map that is off by a distance along x, y and z, each to one side or the other."""
    dx, dy, dz = (distance * rng.choice((-1.0, 1.0), 3)).tolist()
    x, y = heights.origin
    return HeightMap(heights.heights + dz, heights.resolution, (x + dx, y + dy))


def with_holes(heights: HeightMap, radius: float, rng: np.random.Generator) -> HeightMap:
    """Return a map that lacks discs of a radius [m], a fifth of its ground altogether."""
    x_min, y_min, x_max, y_max = heights.bounds
    area = (x_max - x_min) * (y_max - y_min)
    # Discs that overlap cover less: each leaves the same part of what the others left.
    count = math.ceil(-math.log(1.0 - _UNKNOWN) * area / (math.pi * radius * radius))
    holes = rng.uniform((x_min, y_min), (x_max, y_max), (count, 2))
    known = heights.heights.copy()
    reach = math.ceil(radius / heights.resolution)
    steps = np.arange(-reach, reach + 1)
    around = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    around = around[np.hypot(*around.T) * heights.resolution < radius]
    cells = ((holes - heights.origin) / heights.resolution).astype(int)
    columns, rows = np.clip(
        (cells[:, None] + around).reshape(-1, 2), 0, (heights.columns - 1, heights.rows - 1)
    ).T
    known[rows, columns] = math.nan
    return heights.with_heights(known)
