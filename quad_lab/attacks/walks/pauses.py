"""
Part of ``quadwalk bench faults``: the gait is not given the processor, again and again.

A machine that is busy, or writes to a slow disk, stops a process for a moment at any instant. The
robot goes on with what it was given last, and must not fall, on uneven ground either.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.plan import Plan
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_lab.closed_loop.paused_walk import PausedWalk, Pauses
from quad_lab.closed_loop.terrain_walk import COURSES, make_course
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool

FLAT = 'flat'
"""A level floor, besides the courses."""

_GAITS = ('crawl', 'wave', 'trot')

_ON_COURSES = ('titan_viii', 'genibo')
"""Robots that walk the courses, as in ``quadwalk bench terrain``."""

_LONGEST = (0.3, 1.0)
"""Longest pauses [s]."""

_SEEDS = 3

_LENGTH, _SIDE = 2.0, 1.0
"""A walk over the floor: so far straight on, and so far to the side [lengths of TITAN-VIII]."""

_STAND, _TIMEOUT = 1.0, 400.0
"""Time before the plan is given, and after which a walk is given up [s]."""


@dataclass(frozen=True)
class PausingCase:
    """A walk, and how its gait pauses."""

    robot: str
    gait: str
    ground: str
    """A course of uneven ground, or `FLAT`."""
    sees: bool
    """Whether the gait has the height map."""
    longest: float
    """Longest pause [s]."""
    seed: int
    """Seed of the pauses."""
    timeout: float = _TIMEOUT
    """Time after which it is over, however far the robot is [s]."""


QUICK_CASES = (
    # Each of them fell within this time while a foot was lifted whatever the others stood on.
    PausingCase('titan_viii', 'crawl', 'kerb', False, 1.0, seed=2, timeout=20.0),
    PausingCase('titan_viii', 'crawl', 'bumps', False, 0.3, seed=1, timeout=22.0),
)


@dataclass(frozen=True)
class PausingOutcome:
    """What became of a walk."""

    case: PausingCase
    pauses: int
    """Number of pauses."""
    has_fallen: bool
    """Whether it fell."""
    has_ended: bool
    """Whether it arrived, or says why it does not."""
    tilt: float
    """Largest tilt of the body [rad]."""
    said: str
    """What the gait said last."""


def attack_by_pauses(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Let gaits pause; return bars, and the walks that did not end well."""
    outcomes: list[PausingOutcome] = []
    with worker_pool() as pool:
        for outcome in pool.map(walk_with_pauses, QUICK_CASES if quick else all_cases(seed)):
            outcomes.append(outcome)
            if outcome.has_fallen or not outcome.has_ended:
                console.print(f'{outcome}')
    console.print(f'{len(outcomes)} walks paused {sum(o.pauses for o in outcomes)} times')
    arrived = sum(outcome.said.startswith('the goal') for outcome in outcomes)
    bars = [
        figure('walks that arrived', arrived, f'of {len(outcomes)}'),
        at_most('falls', sum(o.has_fallen for o in outcomes), '', 0),
    ]
    if not quick:
        ended = sum(outcome.has_ended for outcome in outcomes)
        words = f'arrives, or says why not, of {len(outcomes)}'
        bars.append(at_least(words, ended, '', len(outcomes)))
    bad = [asdict(o) for o in outcomes if o.has_fallen or not o.has_ended]
    return bars, {'not well': [] if quick else bad}


def all_cases(seed: int) -> Iterator[PausingCase]:
    """Return every robot and gait on the floor, and every course with its map and without."""
    for name, gait, longest in product(available_robots(), _GAITS, _LONGEST):
        yield PausingCase(name, gait, FLAT, False, longest, seed)
    for name, course, sees in product(_ON_COURSES, COURSES, (True, False)):
        # Between large obstacles there is no walking without a map.
        if sees or course != 'boxes':
            for longest, more in product(_LONGEST, range(_SEEDS)):
                yield PausingCase(name, 'crawl', course, sees, longest, seed + more)


def walk_with_pauses(case: PausingCase) -> PausingOutcome:
    """Walk once."""
    robot = load_robot(case.robot)
    options = SupervisorOptions(least_margin=-math.inf)
    place: dict[str, Any] = {}
    size = robot.relative_size
    plan = Plan.through([(0.0, 0.0), (size * _LENGTH, 0.0), (size * _LENGTH, size * _SIDE)], 0.0)
    if case.ground == FLAT:
        controller = controller_for(robot, load_gait(case.gait, robot), options)
    else:
        course = make_course(robot, case.ground, 1)
        plan = course.plan
        place = {'world': course.world, 'start': course.start}
        controller = controller_for(robot, load_gait(case.gait, robot), for_uneven_ground(options))
        if case.sees:
            controller.set_height_map(course.height_map)
    rng = np.random.default_rng(case.seed)
    walk = PausedWalk(robot, controller, Pauses(longest=case.longest), rng, **place)
    try:
        walk.run(_STAND)
        controller.set_plan(plan)
        has_ended = walk.run(case.timeout, lambda: controller.activity.is_terminal)
        return PausingOutcome(
            case,
            walk.count,
            walk.simulation.has_fallen,
            has_ended,
            float(walk.record.tilts.max()),
            controller.reason,
        )
    finally:
        walk.close()
