"""
``quadwalk bench ground``: random walks over random ground, as users ask for them.

Starts, goals and ground are drawn, and the planner decides where to turn; without topics, but in
one part. Staircases and stepping stones are crossed straight on, and footsteps planned over them.
The same walks are made by height maps that are wrong.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

from rich.console import Console
from rich.table import Table

from quad_common.errors import RobotModelError
from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.ground.foothold_courses import (
    COURSES,
    PlannedFootsteps,
    foothold_course,
    plan_footsteps,
)
from quad_lab.benchmarks.ground.wrong_maps import WRONG_MAP, walk_by_wrong_maps
from quad_lab.closed_loop.ground_walk import TERRAINS, GroundOutcome, make_scene, walk_scene
from quad_lab.closed_loop.terrain_walk import TerrainOutcome, walk_course
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool

ROBOTS = ('titan_viii', 'genibo')
"""Robots that walk between random places."""

CLIMBER = 'a1'
"""Robot that climbs stairs beside TITAN-VIII, and walks between random places too; it is imported
from a package of descriptions."""

WAVE = 'wave'
"""Part that walks by the wave gait."""

FOOTSTEPS = 'footsteps'
"""Part that plans footsteps, and walks nowhere."""

TOPICS = 'topics'
"""Part that walks by topics, as fast as the nodes go."""

PARTS = (*ROBOTS, CLIMBER, *TERRAINS, *COURSES, FOOTSTEPS, WAVE, WRONG_MAP, TOPICS)
"""Robots and terrains to which ``--only`` limits it; of what is not named all are walked."""

PREFERRED_BACKEND = 'mujoco'
"""Physics unless ``--backend`` says otherwise: five times as fast, and the walks are long."""

_USUAL = 'crawl'
"""Gait of the walks, but for those of their own part."""

_WALKS = {'titan_viii': 100, 'genibo': 100, CLIMBER: 30}
"""Walks of each robot; the terrains take turns."""

_WAVES = 30
"""Walks of each robot by the wave gait."""

_CROSSINGS = 20
"""Walks over each course by each robot, and plans of footsteps."""

_NEEDED = {
    ('titan_viii', 'stairs'): 20,
    (CLIMBER, 'stairs'): 18,
    ('titan_viii', 'stones'): 18,
    (CLIMBER, 'stones'): 18,
}
"""Walks that are to arrive, of 20."""

_LEAST_STEPS, _LONGEST_PLANNING = 30, 125.0
"""Number of footsteps that are planned in so many milliseconds."""

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
    gait: str

    @property
    def walker(self) -> str:
        """The robot, and its gait where that is not the usual one."""
        return self.robot if self.gait == _USUAL else f'{self.robot}, {self.gait}'


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
    wanted = set(only or PARTS)
    bars, details = _cross(console, quick, seed, wanted)
    robots = [robot for robot in _WALKS if robot in wanted] or list(_WALKS)
    terrains = [terrain for terrain in TERRAINS if terrain in wanted] or list(TERRAINS)
    randomly = {WRONG_MAP: walk_by_wrong_maps, TOPICS: _walk_by_topics}
    for part in (part for part in randomly if part in wanted and (only or not quick)):
        usual = tuple(robot for robot in ROBOTS if robot in robots)
        more, details[part] = randomly[part](console, quick, seed, usual, tuple(terrains))
        bars += more
    jobs = [job for gait in _gaits(set(only), quick) for job in _jobs(gait, quick, seed)]
    jobs = [job for job in jobs if job[0] in robots and job[1] in terrains]
    missing = [robot for robot in robots if not _is_there(robot, console)] if jobs else []
    bars += [at_least(f'{robot}: arrived', None, '', _WALKS[robot]) for robot in missing]
    jobs = [job for job in jobs if job[0] not in missing]
    if not jobs:
        return bars, details
    walks: list[_Walk] = []
    with worker_pool() as pool:
        for walk in pool.map(_walked, *zip(*jobs)):
            walks.append(walk)
            console.print(f'walk {len(walks)} of {len(jobs)}, {_described(walk)}', highlight=False)
    walkers = list(dict.fromkeys(walk.walker for walk in walks))
    console.print(_table(walkers, walks))
    bars += [bar for walker in walkers for bar in _bars(walker, walks)]
    return bars, {**details, 'walks': [asdict(walk) for walk in walks]}


def _walk_by_topics(
    console: Console, quick: bool, seed: int, robots: tuple[str, ...], terrains: tuple[str, ...]
) -> tuple[list[Criterion], list[dict[str, Any]]]:
    """Walk by topics where ROS is installed."""
    if importlib.util.find_spec('rclpy') is None:
        console.print('by topics: rclpy is not installed')
        return [at_least('by topics: arrived', None, '', 1)], []
    # The other walks need no ROS.
    from quad_lab.benchmarks.ground.uneven_topic_walks import walk_by_topics

    return walk_by_topics(console, quick, seed, robots, terrains)


def _gaits(named: set[str], quick: bool) -> list[str]:
    """Return the gaits of the random walks, by the parts that are named."""
    others = named & {*COURSES, FOOTSTEPS, WAVE, WRONG_MAP, TOPICS}
    crawls = not others or (named & set(TERRAINS) and not others & {WAVE, WRONG_MAP, TOPICS})
    waves = WAVE in named or not (named or quick)
    return [_USUAL] * bool(crawls) + [WAVE] * waves


def _cross(
    console: Console, quick: bool, seed: int, wanted: set[str]
) -> tuple[list[Criterion], dict[str, Any]]:
    """Cross staircases and stepping stones, and plan footsteps."""
    seeds = range(seed, seed + (1 if quick else _CROSSINGS))
    robots = wanted & {*ROBOTS, CLIMBER} or {*ROBOTS, CLIMBER}
    courses = [case for case in _NEEDED if case[0] in robots and case[1] in wanted]
    bars: list[Criterion] = []
    crossings: list[dict[str, Any]] = []
    with worker_pool() as pool:
        for robot, course in courses:
            if not _is_there(robot, console):
                bars.append(at_least(f'{robot} over {course}: arrived', None, '', len(seeds)))
                continue
            outcomes: list[TerrainOutcome] = []
            for each in pool.map(_crossed, *zip(*((robot, course, one) for one in seeds))):
                outcomes.append(each)
                number = seeds[len(outcomes) - 1]
                said = 'arrived' if each.arrived else each.problem
                told = f'{said}, {"FELL, " if each.has_fallen else ""}{"; ".join(each.contacts)}'
                console.print(f'{robot} over {course} (seed {number}): {told}', highlight=False)
                crossings.append({'robot': robot, 'course': course, 'seed': number, **asdict(each)})
            bars += _crossing_bars(robot, course, outcomes)
        if FOOTSTEPS in wanted:
            plans = [plan_footsteps(load_robot('titan_viii'), one) for one in seeds]
            bars += _planning_bars(plans)
            crossings += [{'course': FOOTSTEPS, **asdict(plan)} for plan in plans]
    return bars, {'crossings': crossings}


def _is_there(robot: str, console: Console) -> bool:
    """Return whether a robot can be loaded; say why not."""
    try:
        load_robot(robot)
    except RobotModelError as error:
        console.print(f'{robot}: {error}', highlight=False)
        return False
    return True


def _crossed(robot: str, course: str, seed: int) -> TerrainOutcome:
    loaded = load_robot(robot)
    return walk_course(loaded, foothold_course(loaded, course, seed), footsteps=course == 'stones')


def _crossing_bars(robot: str, course: str, outcomes: list[TerrainOutcome]) -> list[Criterion]:
    count = len(outcomes)
    needed = math.ceil(count * _NEEDED[robot, course] / _CROSSINGS - 1e-9)
    name = f'{robot} over {course}'
    return [
        at_least(f'{name}: arrived, of {count}', sum(o.arrived for o in outcomes), '', needed),
        at_most(f'{name}: falls', sum(o.has_fallen for o in outcomes), '', count - needed),
        figure(
            f'{name}: walks with contacts of anything but feet',
            sum(bool(o.contacts) for o in outcomes),
            '',
        ),
        figure(f'{name}: largest tilt', math.degrees(max(o.largest_tilt for o in outcomes)), 'deg'),
    ]


def _planning_bars(plans: list[PlannedFootsteps]) -> list[Criterion]:
    found = [plan for plan in plans if plan.steps]
    long = [plan for plan in found if plan.steps >= _LEAST_STEPS]
    return [
        at_least(f'footsteps over stones: found, of {len(plans)}', len(found), '', len(plans)),
        at_most(
            f'the slowest plan of {_LEAST_STEPS} footsteps or more, of {len(long)}',
            max((1e3 * plan.duration for plan in long), default=None),
            'ms',
            _LONGEST_PLANNING,
        ),
        figure('footsteps of the longest plan', max((p.steps for p in found), default=None), ''),
    ]


def _jobs(gait: str, quick: bool, seed: int) -> Iterator[tuple[str, str, int, str]]:
    if quick:
        yield from ((*job, seed, gait) for job in (_QUICK if gait == _USUAL else _QUICK[:1]))
        return
    kinds = list(TERRAINS)
    counts = _WALKS if gait == _USUAL else dict.fromkeys(ROBOTS, _WAVES)
    for number in range(max(counts.values())):
        for robot, count in counts.items():
            if number < count:
                yield robot, kinds[number % len(kinds)], seed + number // len(kinds), gait


def _walked(robot: str, terrain: str, seed: int, gait: str) -> _Walk:
    loaded = load_robot(robot)
    scene = make_scene(loaded, terrain, seed)
    outcome = walk_scene(loaded, scene, gait_name=gait)
    return _Walk(robot, terrain, seed, scene.map_name, outcome, gait)


def _bars(walker: str, walks: list[_Walk]) -> list[Criterion]:
    outcomes = [walk.outcome for walk in walks if walk.walker == walker]
    if not outcomes:
        return []
    count = len(outcomes)
    return [
        at_least(f'{walker}: arrived, of {count}', sum(o.arrived for o in outcomes), '', count),
        at_most(f'{walker}: falls', sum(o.has_fallen for o in outcomes), '', 0),
        at_most(
            f'{walker}: walks with contacts of anything but feet',
            sum(bool(o.contacts) for o in outcomes),
            '',
            0,
        ),
        at_most(f'{walker}: false alarms', sum(bool(o.alarms) for o in outcomes), '', 0),
        figure(
            f'{walker}: walks that needed a way out', sum(bool(o.ways_out) for o in outcomes), ''
        ),
        figure(f'{walker}: farthest from the goal', 1e3 * max(o.distance for o in outcomes), 'mm'),
    ]


def _table(walkers: list[str], walks: list[_Walk]) -> Table:
    table = Table('robot', 'ground', 'arrived', 'falls', 'contacts', 'false alarms', 'ways out')
    table.title = 'random walks over random ground'
    for walker in walkers:
        for terrain in TERRAINS:
            chosen = [w.outcome for w in walks if (w.walker, w.terrain) == (walker, terrain)]
            if chosen:
                table.add_row(
                    walker,
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
    return f'{walk.walker} over {walk.terrain} on {walk.map_name} (seed {walk.seed}): {said}'
