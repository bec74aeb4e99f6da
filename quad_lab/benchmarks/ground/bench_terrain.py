"""
``quadwalk bench terrain``: walks over uneven ground in physics, and what they rest on.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.ground.bench_active_pair import active_pair_bars
from quad_lab.benchmarks.ground.bench_joint_failure import joint_failure_bars
from quad_lab.closed_loop.terrain_walk import COURSES, TerrainOutcome, make_course, walk_course
from quad_lab.tools.criterion import Criterion, at_least, at_most
from quad_lab.tools.workers import worker_pool

_ROBOTS = ('titan_viii', 'genibo')

_SEEDS = 20

_QUICK = (('titan_viii', 'bumps', 'uneven'), ('titan_viii', 'bumps', 'flat'))
"""In the quick run, with one seed each."""

_MODES = {
    'uneven': ('uneven', True),
    'blind': ('uneven', False),
    'flat': ('flat', True),
}
"""What the gait takes the ground for, and whether it has the height map."""

_FEWER = 5
"""Seeds where there is no bar: without a height map, and by the gait for flat ground but on
bumps, where tilts are compared."""

_COMPARED = ('flat', 'bumps')

_BLIND = ('bumps', 'slope', 'cross_slope', 'kerb')
"""Courses that the first robot also walks without a height map."""


@dataclass(frozen=True)
class _Walk:
    """One walk, and how it went."""

    robot: str
    course: str
    mode: str
    """One of :data:`_MODES`."""
    seed: int
    outcome: TerrainOutcome


def measure(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, Any]]:
    """
    Walk all courses with both robots, by the gait for uneven ground and by that for flat.

    Parameters
    ----------
    console : Console
        Where progress and the table of walks are shown.
    quick : bool
        One walk over bumps by each gait.
    seed : int
        Of the first course.

    Returns
    -------
    bars : list of Criterion
        What was measured.
    details : dict
        Every walk.
    """
    if quick:
        jobs = [(*job, seed) for job in _QUICK]
    else:
        jobs = [
            (robot, course, mode, seed + k)
            for robot in _ROBOTS
            for course in COURSES
            for mode in _MODES
            if mode != 'blind' or (robot == _ROBOTS[0] and course in _BLIND)
            for k in range(_SEEDS if mode == 'uneven' or (mode, course) == _COMPARED else _FEWER)
        ]
    walks: list[_Walk] = []
    with worker_pool() as pool:
        for walk in pool.map(_walked, *zip(*jobs)):
            walks.append(walk)
            outcome = walk.outcome
            end = 'arrived' if outcome.arrived else outcome.problem
            console.print(
                f'walk {len(walks)} of {len(jobs)}, {walk.robot} over {walk.course} '
                f'({walk.mode}, seed {walk.seed}): {end}'
            )
    groups: dict[tuple[str, str, str], list[TerrainOutcome]] = {}
    for walk in walks:
        groups.setdefault((walk.robot, walk.course, walk.mode), []).append(walk.outcome)
    console.print(_table(groups))
    bars = _walk_bars(groups) + joint_failure_bars(quick, seed) + active_pair_bars(quick, seed)
    return bars, {'walks': [_described(walk) for walk in walks]}


def _walked(robot: str, course: str, mode: str, seed: int) -> _Walk:
    loaded = load_robot(robot)
    ground, sees = _MODES[mode]
    outcome = walk_course(loaded, make_course(loaded, course, seed), ground, sees)
    return _Walk(robot, course, mode, seed, outcome)


def _walk_bars(groups: dict[tuple[str, str, str], list[TerrainOutcome]]) -> list[Criterion]:
    bars = []
    for (robot, course, mode), outcomes in groups.items():
        name = f'{robot}, {course}' + (', without a height map' if mode == 'blind' else '')
        if mode == 'flat':
            continue
        arrived = sum(outcome.arrived for outcome in outcomes)
        bars += [
            at_least(f'{name}: arrived, of {len(outcomes)}', arrived, '', len(outcomes)),
            at_most(f'{name}: falls', sum(outcome.has_fallen for outcome in outcomes), '', 0),
        ]
        if course == 'boxes':
            touches = sum(outcome.touches_large for outcome in outcomes)
            bars.append(at_most(f'{name}: walks that touched a large one', touches, '', 0))
        flat = groups.get((robot, course, 'flat'))
        if course == 'bumps' and mode == 'uneven' and flat is not None:
            fraction = _tilt_rms(outcomes) / _tilt_rms(flat)
            bars.append(
                at_most(f'{name}: tilt, rms, over that of the flat gait', fraction, '', 0.5)
            )
    return bars


def _tilt_rms(outcomes: list[TerrainOutcome]) -> float:
    return math.sqrt(float(np.mean([outcome.tilt_rms**2 for outcome in outcomes])))


def _table(groups: dict[tuple[str, str, str], list[TerrainOutcome]]) -> Table:
    """Set the gait for uneven ground beside that for flat ground."""
    table = Table(
        'robot', 'course', 'gait', 'arrived', 'falls', 'tilt rms', 'largest', 'least margin',
        'time', 'with shins on the ground', title='walks over uneven ground',
    )  # fmt: skip
    for (robot, course, mode), outcomes in groups.items():
        table.add_row(
            robot,
            course,
            {'uneven': 'uneven', 'blind': 'uneven, no map', 'flat': 'flat'}[mode],
            f'{sum(outcome.arrived for outcome in outcomes)} of {len(outcomes)}',
            str(sum(outcome.has_fallen for outcome in outcomes)),
            f'{math.degrees(_tilt_rms(outcomes)):.2f} deg',
            f'{math.degrees(max(outcome.largest_tilt for outcome in outcomes)):.1f} deg',
            f'{1e3 * min(outcome.least_margin for outcome in outcomes):.0f} mm',
            f'{np.median([outcome.duration for outcome in outcomes]):.0f} s',
            str(sum(bool(outcome.contacts) for outcome in outcomes)),
        )
    return table


def _described(walk: _Walk) -> dict[str, Any]:
    given = {'robot': walk.robot, 'course': walk.course, 'gait': walk.mode, 'seed': walk.seed}
    return {**given, **asdict(walk.outcome)}
