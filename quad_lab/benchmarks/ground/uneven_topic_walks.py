"""
Random walks over random ground by topics, each node a process of its own, as fast as they go.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from quad_common.maps.height_map_file import save_height_map
from quad_common.process.temporary_folder import temporary_folder
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.ground_walk import TERRAINS, make_scene
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.walk import WalkOptions, walk
from quad_lab.topic_walk.walk_record import WalkResult

_WALKS = 10
"""Walks of each robot; the terrains take turns."""

_SPEED = 10.0
"""Simulated over real time that a walk is to reach."""


@dataclass(frozen=True)
class TopicWalk:
    """One walk by topics, and how it went."""

    robot: str
    terrain: str
    seed: int
    map_name: str
    result: WalkResult


def walk_by_topics(
    console: Console, quick: bool, seed: int, robots: tuple[str, ...], terrains: tuple[str, ...]
) -> tuple[list[Criterion], list[dict[str, Any]]]:
    """
    Walk between random places over random ground, by topics, one walk at a time.

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
    count = 1 if quick else _WALKS
    jobs = [
        (robot, terrains[number % len(terrains)], seed + number // len(terrains))
        for number in range(count)
        for robot in (robots[:1] if quick else robots)
    ]
    walks: list[TopicWalk] = []
    with temporary_folder() as folder:
        for job in jobs:
            walks.append(_walked(*job, folder))
            console.print(
                f'by topics, walk {len(walks)} of {len(jobs)}, {_described(walks[-1])}',
                highlight=False,
            )
    console.print(_table(walks))
    return _bars(walks), [
        {'robot': w.robot, 'terrain': w.terrain, 'seed': w.seed, **w.result.as_dict()}
        for w in walks
    ]


def _walked(robot: str, terrain: str, seed: int, folder: Path) -> TopicWalk:
    scene = make_scene(load_robot(robot), terrain, seed)
    ground = folder / f'{robot}_{list(TERRAINS).index(terrain)}_{seed}.yaml'
    save_height_map(scene.height_map, ground)
    options = WalkOptions(
        map_file=sample_map(scene.map_name),
        start=scene.start,
        goal=scene.goal,
        robot=robot,
        seed=seed,
        terrain=str(ground),
    )
    return TopicWalk(robot, terrain, seed, scene.map_name, walk(options).result())


def _bars(walks: list[TopicWalk]) -> list[Criterion]:
    results = [each.result for each in walks]
    count = len(results)
    simulated = sum(result.walking_time or 0.0 for result in results)
    wall = sum(result.wall_time for result in results)
    errors = [r.position_error for r in results if r.position_error is not None]
    return [
        at_least(f'by topics: arrived, of {count}', sum(r.arrived for r in results), '', count),
        at_most('by topics: falls', sum(r.fallen for r in results), '', 0),
        at_most(
            'by topics: walks with contacts of anything but feet',
            sum(bool(r.contacts) for r in results),
            '',
            0,
        ),
        at_most('by topics: late trajectories', sum(r.late_trajectories for r in results), '', 0),
        at_least('by topics: speed', simulated / wall if wall else None, 'x real time', _SPEED),
        figure('by topics: farthest from the goal', 1e3 * max(errors, default=0.0), 'mm'),
    ]


def _table(walks: list[TopicWalk]) -> Table:
    table = Table('robot', 'ground', 'map', 'seed', 'path [m]', 'time [s]', 'late', 'x real time')
    table.title = 'random walks over random ground, by topics'
    for each in walks:
        result = each.result
        table.add_row(
            each.robot,
            each.terrain,
            each.map_name,
            str(each.seed),
            f'{result.path_length or 0.0:.1f}',
            f'{result.walking_time or 0.0:.0f}',
            str(result.late_trajectories),
            f'{result.real_time_factor or 0.0:.1f}',
        )
    return table


def _described(each: TopicWalk) -> str:
    result = each.result
    end = [
        'arrived' if result.arrived else f'did not arrive: {result.problem}',
        'FELL' if result.fallen else '',
        f'CONTACTS: {result.contacts}' if result.contacts else '',
        f'{result.late_trajectories} late trajectories' if result.late_trajectories else '',
        f'{result.real_time_factor or 0.0:.1f} x real time',
    ]
    said = ', '.join(part for part in end if part)
    return f'{each.robot} over {each.terrain} on {each.map_name} (seed {each.seed}): {said}'
