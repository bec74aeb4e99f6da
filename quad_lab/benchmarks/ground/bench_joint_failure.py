"""
Part of ``quadwalk bench terrain``: joints that fail in mid-walk, in physics.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_lab.closed_loop.terrain_walk import make_course
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.simulator import FAILURES, JointFailure, Observation

Array = NDArray[np.float64]

_CASES, _QUICK_CASES = 20, 2

_WALKS = (
    ('titan_viii', 'crawl', 'flat'),
    ('titan_viii', 'crawl', 'bumps'),
    ('titan_viii', 'trot', 'flat'),
    ('genibo', 'crawl', 'flat'),
    ('genibo', 'crawl', 'bumps'),
    ('genibo', 'trot', 'flat'),
)
"""Robot, gait and ground of each series."""

_BEGIN = {'flat': 2.0, 'bumps': 6.0}
"""The robot has walked for so long before a joint may fail [s]."""

_SPEED = {'crawl': 0.2, 'trot': 0.6}
"""Of the largest stride per second."""

_WATCHED = 10.0
"""From the word that a joint has failed, at most so long [s]."""

_UNNOTICED = 12.0
"""A joint may fail and not be missed before its leg is needed, for so long at most [s]."""

_PLACE, _TILT = 0.005, math.radians(0.5)
"""A robot stands still when nothing moves it farther any more [m] of TITAN-VIII, [rad]."""

_ASKED = 0.0075
"""A joint that jams, and whose command never goes farther from there, does what it is commanded
[rad]: it moves like a sound one, to the last digit."""

_LARGEST_TILT = math.radians(30.0)
"""A body tilted farther has fallen [rad]."""


@dataclass(frozen=True)
class FailureCase:
    """A joint that fails at a time."""

    robot: str
    gait: str
    ground: str
    """``flat``, or one of :data:`quad_lab.closed_loop.terrain_walk.COURSES`."""
    joint: int
    kind: str
    time: float
    """[s]"""
    seed: int
    """Of the ground."""


@dataclass(frozen=True)
class FailureOutcome:
    """What became of it."""

    case: FailureCase
    has_fallen: bool
    largest_tilt: float
    """After the failure [rad]."""
    has_touched: bool
    """Whether body or hips have touched the ground."""
    is_named: bool
    """Whether the robot says which joint it is."""
    noticed: float
    """After the failure [s]; infinite if never."""
    still: float
    """When it stands still, after the failure [s]; infinite if never."""
    period: float
    """Of a cycle, by the clock where the ground is uneven [s]."""
    reason: str
    is_asked: bool
    """Whether a joint that jams was commanded to leave its place; one that is free always is."""


def joint_failure_bars(quick: bool, seed: int) -> list[Criterion]:
    """
    Let joints fail in mid-walk.

    Parameters
    ----------
    quick : bool
        Two cases of each series, in place of 20.
    seed : int
        Of joints, kinds and times.

    Returns
    -------
    list of Criterion
    """
    count = _QUICK_CASES if quick else _CASES
    cases = [
        case
        for k, walk in enumerate(_WALKS)
        for case in random_cases(*walk, count, np.random.default_rng((seed, k)))
    ]
    with worker_pool() as pool:
        outcomes = list(pool.map(walk_and_fail, cases))
    bars = []
    for walk in _WALKS:
        series = [
            outcome
            for outcome in outcomes
            if (outcome.case.robot, outcome.case.gait, outcome.case.ground) == walk
        ]
        bars += _bars_of(' '.join(walk), series)
    return bars


def _bars_of(name: str, series: list[FailureOutcome]) -> list[Criterion]:
    name = f'a joint fails, {name}'
    count = len(series)
    asked = [outcome for outcome in series if outcome.is_asked]
    fallen = sum(outcome.has_fallen for outcome in series)
    still = sum(outcome.still <= 2.0 * outcome.period for outcome in asked)
    named = sum(outcome.is_named for outcome in asked)
    bars = [
        at_most(f'{name}: falls, of {count}', fallen, '', 0.0),
        at_least(
            f'{name}: stands still within two cycles, of {len(asked)} asked',
            still,
            '',
            len(asked),
        ),
        at_least(f'{name}: says which joint, of {len(asked)} asked', named, '', len(asked)),
        figure(f'{name}: jams where it is held all the time', count - len(asked), ''),
    ]
    touched = sum(outcome.has_touched for outcome in series)
    tilt = math.degrees(max(outcome.largest_tilt for outcome in series))
    noticed = float(np.median([outcome.noticed for outcome in series]))
    return [
        *bars,
        figure(f'{name}: body or hip touches the ground, of {count}', touched, ''),
        figure(f'{name}: largest tilt', tilt, 'degrees'),
        figure(f'{name}: noticed after, median', noticed, 's'),
    ]


def random_cases(
    robot: str, gait: str, ground: str, count: int, rng: np.random.Generator
) -> list[FailureCase]:
    """Draw joints, kinds and times over a cycle and more."""
    period = load_gait(gait, load_robot(robot)).cycle_period
    return [
        FailureCase(
            robot,
            gait,
            ground,
            int(rng.integers(12)),
            str(rng.choice(FAILURES)),
            float(_BEGIN[ground] + rng.uniform(0.0, max(2.0, 1.5 * period))),
            int(rng.integers(1000)),
        )
        for _ in range(count)
    ]


def walk_and_fail(case: FailureCase) -> FailureOutcome:
    """
    Walk, let a joint fail, and see what the robot makes of it.

    Parameters
    ----------
    case : FailureCase
        Which joint, how and when.

    Returns
    -------
    FailureOutcome
    """
    walk, is_uneven = _begun(case), case.ground != 'flat'
    robot, controller = walk.robot, walk.controller
    name = robot.joint_names[case.joint]
    walk.simulation.plan_failure(JointFailure(name, case.kind, case.time))
    seen, commands = _watched(walk, case.joint)
    speed = _SPEED[case.gait] * robot.largest_stride

    # On uneven ground new footholds tell when a cycle begins.
    begun: list[float] = []
    planned: Array = np.empty((0, 2))

    def is_over() -> bool:
        nonlocal planned
        footholds = controller.footholds()[:, :2]
        if len(footholds) and not np.array_equal(footholds, planned):
            planned = footholds
            begun.append(walk.time)
        if not is_uneven:
            controller.set_twist(Twist2D(speed, 0.0, 0.0))
        return controller.activity.is_disabled

    try:
        is_noticed = walk.run(case.time + _UNNOTICED, is_over)
        noticed = walk.time - case.time if is_noticed else math.inf
        if is_noticed:
            walk.run(_WATCHED)
    finally:
        walk.close()
    after = [observation for observation in seen if observation.time >= case.time]
    tilts = np.array(walk.record.tilts[-len(after) :])
    still = _still_after(after, tilts, robot.relative_size) - case.time if is_noticed else math.inf
    away = np.abs(np.array(commands[-len(after) :]) - after[0].joint_positions[case.joint])
    return FailureOutcome(
        case,
        bool(tilts.max() > _LARGEST_TILT) or controller.activity is Activity.FALLEN,
        float(tilts.max()),
        any(observation.has_fallen for observation in after),
        name in controller.reason,
        noticed,
        float(still),
        float(np.median(np.diff(begun)))
        if is_uneven and len(begun) > 1
        else controller.gait.cycle_period,
        controller.reason,
        case.kind == 'free' or bool(away.max() > _ASKED),
    )


def _begun(case: FailureCase) -> ClosedLoop:
    """Put the robot on its ground, where that is uneven with a plan over it."""
    robot = load_robot(case.robot)
    gait = load_gait(case.gait, robot)
    options = SupervisorOptions(least_margin=0.01 * robot.relative_size)
    if case.ground == 'flat':
        return ClosedLoop(robot, controller_for(robot, gait, options))
    course = make_course(robot, case.ground, case.seed)
    controller = controller_for(robot, gait, for_uneven_ground(options))
    controller.set_height_map(course.height_map)
    controller.set_plan(course.plan)
    return ClosedLoop(robot, controller, world=course.world, start=course.start)


def _watched(walk: ClosedLoop, joint: int) -> tuple[list[Observation], list[float]]:
    """Keep what is observed, and what a joint is commanded then [rad]."""
    seen: list[Observation] = []
    commands: list[float] = []

    def keep(observation: Observation) -> None:
        seen.append(observation)
        commands.append(float(walk.simulation.commanded[joint]))

    walk.on_observation.append(keep)
    return seen, commands


def _still_after(seen: list[Observation], tilts: Array, scale: float) -> float:
    """Return when the body has come to rest for good [s]; infinite if it has not."""
    places = np.array([observation.position for observation in seen])
    moves = (np.linalg.norm(places - places[-1], axis=1) > scale * _PLACE) | (
        np.abs(tilts - tilts[-1]) > _TILT
    )
    last = int(np.flatnonzero(moves).max(initial=-1))
    return seen[last + 1].time if last + 1 < len(seen) else math.inf
