"""
``quadwalk bench ground``: random walks over random ground, as users ask for them.

Without topics; starts, goals and ground are drawn, and the planner decides where to turn.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from rich.console import Console
from rich.table import Table

from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.ground_walk import TERRAINS, GroundOutcome, make_scene, walk_scene
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool

ROBOTS = ('titan_viii', 'genibo')

PARTS = (*ROBOTS, *TERRAINS)
"""Robots and terrains to which ``--only`` limits it; of what is not named all are walked."""

PREFERRED_BACKEND = 'mujoco'
"""Physics unless ``--backend`` says otherwise: five times as fast, and the walks are long."""

_WALKS = 100
"""Of each robot; the terrains take turns."""

_QUICK = (('titan_viii', 'noise+boxes'), ('genibo', 'boxes'))
"""In the quick run, with one seed each."""


@dataclass(frozen=True)
class _Walk:
    """One walk, and how it went."""

    robot: str
    terrain: str
    seed: int
    map_name: str
    outcome: GroundOutcome


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = ()
) -> tuple[list[Criterion], dict[str, Any]]:
    """
    Walk between random places over random ground.

    Parameters
    ----------
    console : Console
        Where progress and the table of walks are shown.
    quick : bool
        One walk of each robot.
    seed : int
        Seed of the first walk on each terrain; the next ones follow it.
    only : tuple of str
        Robots and terrains to walk; all of those of which none is named.

    Returns
    -------
    bars : list of Criterion
        What was measured.
    details : dict
        Every walk.
    """
    jobs = [(*job, seed) for job in _QUICK] if quick else list(_jobs(seed))
    wanted = set(only or PARTS)
    robots = wanted & set(ROBOTS) or set(ROBOTS)
    terrains = wanted & set(TERRAINS) or set(TERRAINS)
    jobs = [job for job in jobs if job[0] in robots and job[1] in terrains]
    walks: list[_Walk] = []
    with worker_pool() as pool:
        for walk in pool.map(_walked, *zip(*jobs)):
            walks.append(walk)
            console.print(f'walk {len(walks)} of {len(jobs)}, {_described(walk)}', highlight=False)
    console.print(_table(walks))
    bars = [bar for robot in ROBOTS for bar in _bars(robot, walks)]
    return bars, {'walks': [asdict(walk) for walk in walks]}


def _jobs(seed: int) -> Iterator[tuple[str, str, int]]:
    kinds = list(TERRAINS)
    for number in range(_WALKS):
        for robot in ROBOTS:
            yield robot, kinds[number % len(kinds)], seed + number // len(kinds)


def _walked(robot: str, terrain: str, seed: int) -> _Walk:
    loaded = load_robot(robot)
    scene = make_scene(loaded, terrain, seed)
    return _Walk(robot, terrain, seed, scene.map_name, walk_scene(loaded, scene))


def _bars(robot: str, walks: list[_Walk]) -> list[Criterion]:
    outcomes = [walk.outcome for walk in walks if walk.robot == robot]
    if not outcomes:
        return []
    count = len(outcomes)
    return [
        at_least(f'{robot}: arrived, of {count}', sum(o.arrived for o in outcomes), '', count),
        at_most(f'{robot}: falls', sum(o.has_fallen for o in outcomes), '', 0),
        at_most(
            f'{robot}: walks with contacts of anything but feet',
            sum(bool(o.contacts) for o in outcomes),
            '',
            0,
        ),
        at_most(f'{robot}: false alarms', sum(bool(o.alarms) for o in outcomes), '', 0),
        figure(
            f'{robot}: walks that needed a way out', sum(bool(o.ways_out) for o in outcomes), ''
        ),
        figure(f'{robot}: farthest from the goal', 1e3 * max(o.distance for o in outcomes), 'mm'),
    ]


def _table(walks: list[_Walk]) -> Table:
    table = Table('robot', 'ground', 'arrived', 'falls', 'contacts', 'false alarms', 'ways out')
    table.title = 'random walks over random ground'
    for robot in ROBOTS:
        for terrain in TERRAINS:
            chosen = [w.outcome for w in walks if (w.robot, w.terrain) == (robot, terrain)]
            if chosen:
                table.add_row(
                    robot,
                    terrain,
                    f'{sum(o.arrived for o in chosen)} of {len(chosen)}',
                    str(sum(o.has_fallen for o in chosen)),
                    str(sum(bool(o.contacts) for o in chosen)),
                    str(sum(bool(o.alarms) for o in chosen)),
                    str(sum(bool(o.ways_out) for o in chosen)),
                )
    return table


def _described(walk: _Walk) -> str:
    outcome = walk.outcome
    end = [
        f'arrived in {outcome.duration:.0f} s' if outcome.arrived else outcome.problem,
        'FELL' if outcome.has_fallen else '',
        f'CONTACTS: {"; ".join(outcome.contacts)}' if outcome.contacts else '',
        f'ALARMS: {"; ".join(outcome.alarms)}' if outcome.alarms else '',
        f'{len(outcome.ways_out)} ways out' if outcome.ways_out else '',
    ]
    said = ', '.join(part for part in end if part)
    return f'{walk.robot} over {walk.terrain} on {walk.map_name} (seed {walk.seed}): {said}'
