"""
Part of ``quadwalk bench faults``: sound robots that walk on a busy machine, and are called sound.

Every robot, gait, direction and kind of ground, with trajectories that come late or never and
joints that are received late. Each walk follows from its seed and number alone.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from itertools import count, islice
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_check import DIRECTIONS
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.reference_path import circle_pieces
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_lab.closed_loop.disturbed_walk import UNDISTURBED, Disturbance, DisturbedWalk
from quad_lab.closed_loop.terrain_walk import COURSES, make_course
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import AUTO, ENGINES, engines_with

HOURS, QUICK_WALKS = 10.0, 4
"""Simulated time of the whole campaign [h], and number of walks of the quick one."""

WALK, QUICK_WALK = 60.0, 12.0
"""Simulated time of one walk [s]."""

_LINE_EVERY = 10
"""Number of walks between two lines of progress."""

_SLOW_ROUNDS = 4
"""Number of rounds of all robots of which one is walked in each other engine than the fastest."""

_FASTEST = 'mujoco'
"""Engine whose steps take the least time, if it is installed."""

_GAITS = ('crawl', 'crab', 'wave', 'trot')
_TURNINGS = ('in_place', 'crab', 'arc')
_BEGIN = 0.5
"""Time for which the robot stands at first [s]."""

_TURNS = 3
"""Number of pieces of a plan."""

_SMALL = 0.25
"""Relative size of robots for which the bumps of the courses would be too small."""

_CHANGE = 8.0
"""Time after which a robot that is steered gets another wish [s]."""


@dataclass(frozen=True)
class WatchedWalk:
    """What one walk of the campaign is."""

    robot: str
    gait: str
    kind: str
    """``steered``, ``circle``, ``plan``, or a course of uneven ground."""
    turning: str
    """How a plan is followed."""
    is_disturbed: bool
    """Whether the machine is busy."""
    seed: tuple[int, int]
    """Seed and number of the walk."""
    duration: float
    """Longest time that it takes [s]."""
    backend: str = AUTO
    """Physics."""


@dataclass(frozen=True)
class WatchedOutcome:
    """What became of one walk."""

    walk: WatchedWalk
    duration: float
    """Simulated time [s]."""
    false_alarm: str
    """Why a sound robot was called lame; empty if it was not."""
    unfollowed: bool
    """Whether it was said that the trajectories are not executed."""
    has_fallen: bool
    activity: str
    """What the robot did last."""
    late: int
    """Number of trajectories that came late."""
    lost: int
    """Number of trajectories that did not come, or too late to be of use."""


def attack_by_load(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk sound robots on a busy machine, and count false alarms.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A few short walks, in place of ten simulated hours.
    seed : int
        Of everything that is drawn.

    Returns
    -------
    tuple
        The bars, and details for JSON: the walks with a false alarm.
    """
    console.print('sound robots walk without topics, on a machine that is busy')
    number, simulated = 0, 0.0

    def say(outcome: WatchedOutcome) -> None:
        nonlocal number, simulated
        number, simulated = number + 1, simulated + outcome.duration
        if outcome.false_alarm:
            console.print(f'false alarm: {outcome}', highlight=False)
        if not number % _LINE_EVERY:
            whole = '' if quick else f' of {HOURS:g}'
            console.print(
                f'{number} walks, {simulated / 3600.0:.2f}{whole} h simulated', highlight=False
            )

    hours = math.inf if quick else HOURS
    walks = islice(drawn_walks(seed, QUICK_WALK if quick else WALK), QUICK_WALKS if quick else None)
    outcomes = campaign(walks, hours, say)
    bars = _bars_of(outcomes)
    return bars, {'false_alarms': [asdict(o) for o in outcomes if o.false_alarm]}


def _bars_of(outcomes: list[WatchedOutcome]) -> list[Criterion]:
    """Work out the bars."""
    simulated = sum(outcome.duration for outcome in outcomes) / 3600.0
    alarms = sum(bool(outcome.false_alarm) for outcome in outcomes)
    quiet = [outcome for outcome in outcomes if not outcome.walk.is_disturbed]
    return [
        figure('sound robots walk, simulated', simulated, 'h'),
        figure('sound robots: trajectories that came late', sum(o.late for o in outcomes), ''),
        figure('sound robots: trajectories that were lost', sum(o.lost for o in outcomes), ''),
        at_most('sound robots called lame', alarms, '', 0),
        at_most(
            'sound robots on a quiet machine said not to follow',
            sum(outcome.unfollowed for outcome in quiet),
            '',
            0,
        ),
    ]


def campaign(
    walks: Iterator[WatchedWalk],
    hours: float,
    on_outcome: Callable[[WatchedOutcome], None] = lambda outcome: None,
    processes: int = 2,
) -> list[WatchedOutcome]:
    """
    Walk until so much time has been simulated.

    Parameters
    ----------
    walks : iterator of WatchedWalk
        What to walk.
    hours : float
        Simulated time [h]; the walks may end before.
    on_outcome : callable
        Called after each walk.
    processes : int
        Number of walks at one time.

    Returns
    -------
    list of WatchedOutcome
        In the order of the walks.
    """
    outcomes: list[WatchedOutcome] = []
    simulated = 0.0
    with worker_pool(processes) as pool:
        running = deque(pool.submit(walk_watched, walk) for walk in islice(walks, 2 * processes))
        while running and simulated < 3600.0 * hours:
            outcome = running.popleft().result()
            simulated += outcome.duration
            outcomes.append(outcome)
            on_outcome(outcome)
            running.extend(pool.submit(walk_watched, walk) for walk in islice(walks, 1))
        for later in running:
            later.cancel()
    return outcomes


def drawn_walks(seed: int, duration: float) -> Iterator[WatchedWalk]:
    """
    Draw walks without end.

    Parameters
    ----------
    seed : int
        Of all walks.
    duration : float
        Of each of them [s].
    """
    robots = [load_robot(name) for name in available_robots()]
    engines = [name for name in engines_with('has_world') if ENGINES[name].is_installed]
    for number in count():
        rng = np.random.default_rng((seed, number))
        robot = robots[number % len(robots)]
        gait = str(rng.choice([name for name in _GAITS if name in robot.gaits]))
        kinds = ['steered', 'steered', 'circle', 'plan']
        if gait in ('crawl', 'crab'):
            kinds += ['uneven'] * 3
        kind = str(rng.choice(kinds))
        if kind == 'uneven':
            kind = str(rng.choice(_courses_of(robot)))
        turning = str(rng.choice(_TURNINGS))
        is_disturbed = bool(rng.random() < 0.8)
        backend = _engine_of(number // len(robots), engines)
        key = (seed, number)
        yield WatchedWalk(robot.name, gait, kind, turning, is_disturbed, key, duration, backend)


def _engine_of(turn: int, engines: list[str]) -> str:
    """Return the engine of one round of all robots: each now and then, the fastest most often."""
    others = [name for name in engines if name != _FASTEST]
    if _FASTEST not in engines or (others and turn % _SLOW_ROUNDS == 0):
        return others[turn // (_SLOW_ROUNDS if _FASTEST in engines else 1) % len(others)]
    return _FASTEST


def walk_watched(walk: WatchedWalk) -> WatchedOutcome:
    """Walk once with a sound robot."""
    robot = load_robot(walk.robot)
    rng = np.random.default_rng((*walk.seed, 1))
    gait = load_gait(walk.gait, robot)
    is_uneven = walk.kind in COURSES
    options = SupervisorOptions(
        least_margin=0.005,
        twist_timeout=math.inf,
        follower=FollowerOptions(turning=walk.turning),
    )
    if is_uneven:
        options = for_uneven_ground(options)
    controller = controller_for(robot, gait, options)
    disturbance = Disturbance() if walk.is_disturbed else UNDISTURBED
    place: dict[str, Any] = {}
    if is_uneven:
        course = make_course(robot, walk.kind, int(rng.integers(1000)))
        controller.set_height_map(course.height_map)
        place = {'world': course.world, 'start': course.start}
    walked = DisturbedWalk(robot, controller, disturbance, rng, backend=walk.backend, **place)
    unfollowed = False

    def is_over() -> bool:
        nonlocal unfollowed
        unfollowed = unfollowed or controller.activity is Activity.NOT_EXECUTED
        return controller.activity.is_disabled

    try:
        walked.run(_BEGIN)
        if is_uneven:
            controller.set_plan(course.plan)
        while walked.time < walk.duration and not controller.activity.is_disabled:
            if not is_uneven:
                _wish(walk.kind, controller, walked.record.poses[-1], rng)
            walked.run(_CHANGE, is_over)
    finally:
        walked.close()
    return WatchedOutcome(
        walk,
        walked.time,
        controller.reason if controller.activity is Activity.LAME else '',
        unfollowed,
        controller.activity is Activity.FALLEN,
        controller.activity.value,
        walked.late,
        walked.lost,
    )


def _wish(kind: str, controller: Supervisor, pose: Pose2D, rng: np.random.Generator) -> None:
    """Wish for something new, if what was wished for is done."""
    if kind == 'steered':
        direction = DIRECTIONS[str(rng.choice(sorted(DIRECTIONS)))]
        gear = controller.gait_pair.of_twist(direction.rate(1.0))
        wanted = direction.scaled(rng.uniform(0.3, 1.0) * gear.largest_scale(direction))
        controller.set_twist(wanted.rate(gear.period))
    elif controller.activity not in (Activity.WALKING, Activity.TURNING):
        size = 8.0 * controller.gait_pair.walking.largest_scale(BodyMotion(forward=1.0))
        if kind == 'circle':
            pieces = circle_pieces(pose, rng.uniform(0.3, 1.0) * size, 2.0 * math.pi)
            controller.set_plan(Plan((pose, pieces[-1].end)), pieces)
        else:
            points = np.cumsum(rng.uniform(-size, size, (_TURNS, 2)), axis=0)
            line = [(pose.x, pose.y), *(points + (pose.x, pose.y))]
            controller.set_plan(Plan.through(line, float(rng.uniform(-math.pi, math.pi))))


def _courses_of(robot: Robot) -> list[str]:
    """Return the courses that there are for a robot of its size."""
    return list(COURSES) if robot.relative_size > _SMALL else ['boxes']
