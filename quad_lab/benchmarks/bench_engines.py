"""
``quadwalk bench engines``: the same robots in PyBullet and in MuJoCo, side by side.
"""

from __future__ import annotations

import importlib
import math
import warnings
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_check import DIRECTIONS
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.slip_compensation import (
    Calibration,
    calibration_file,
    load_compensation,
)
from quad_lab.benchmarks.engine_speed import (
    BACKENDS,
    Bars,
    loop_speed,
    step_times,
    topic_speed,
)
from quad_lab.benchmarks.ground.bench_joint_failure import (
    FailureOutcome,
    random_cases,
    walk_and_fail,
)
from quad_lab.closed_loop.calibration import (
    MeasuredMotion,
    measure_motion,
    motion_error,
    motion_size,
)
from quad_lab.closed_loop.gait_measures import SteadyWalk, steady_walk
from quad_lab.closed_loop.terrain_walk import TerrainOutcome, make_course, walk_course
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import ENGINES, make_simulator, preferred
from quad_sim.engines.simulator import Simulator
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import World

Array = NDArray[np.float64]
Result = TypeVar('Result')

_GAITS = ('crawl', 'wave', 'trot')

_STANDING, _QUICK_STANDING = 60.0, 4.0
"""Time for which a robot stands [s]."""

_SETTLING = 2.0
"""Time after which it is looked at first [s]."""

_SLOPE = 0.15
"""Slope on which it stands [rad]."""

_WALK, _QUICK_WALK = 60.0, 6.0
"""Time of a steady walk [s]."""

_LEAST_TILT = math.radians(0.05)
"""Tilts below this are alike, whatever their ratio [rad]."""

_CASES = 6
"""Joint failures of each robot."""


@dataclass(frozen=True)
class Case:
    """A robot, and how it walks."""

    robot: str
    gait: str
    direction: str
    """One of :data:`quad_gait.cycle.gait_check.DIRECTIONS`."""

    def __str__(self) -> str:
        return f'{self.robot} {self.gait} {self.direction}'


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = ()
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Compare the engines, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress and tables go.
    quick : bool
        A sample that is drawn with the seed.
    seed : int
        Of the sample, the ground and the failures.
    only : tuple of str
        Parts to run; all if empty.

    Returns
    -------
    tuple
        The bars, and details for JSON by part.

    Raises
    ------
    MissingOptionalDependency
        If one of the engines is not installed.
    """
    for backend in BACKENDS:
        importlib.import_module(ENGINES[backend].module)
    bars: list[Criterion] = []
    details: dict[str, object] = {'quick': quick, 'seed': seed}
    for name, part in PARTS.items():
        if only and name not in only:
            continue
        console.rule(name)
        part_bars, details[name] = part(console, quick, seed)
        bars += part_bars
    return bars, details


def in_engine(backend: str, work: Callable[..., Result], *given: Any) -> tuple[Result, int]:
    """Do some work in a worker; return what came of it, and how many warnings."""
    with preferred(backend), warnings.catch_warnings(record=True) as said:
        warnings.simplefilter('always')
        result = work(*given)
    return result, sum(issubclass(warning.category, RuntimeWarning) for warning in said)


def _in_both(
    pool: Executor, work: Callable[..., Result], jobs: Sequence[tuple[Any, ...]]
) -> list[tuple[tuple[Result, int], tuple[Result, int]]]:
    """Do each job in both engines, and return pairs of results, each with its warnings."""
    futures = [[pool.submit(in_engine, b, work, *job) for b in BACKENDS] for job in jobs]
    return [(first.result(), second.result()) for first, second in futures]


def _sample(jobs: list[Result], count: int, quick: bool, seed: int) -> list[Result]:
    """Draw some of the jobs for the quick run."""
    if not quick:
        return jobs
    chosen = np.random.default_rng(seed).choice(len(jobs), min(count, len(jobs)), replace=False)
    return [jobs[index] for index in sorted(chosen)]


def _creep(console: Console, quick: bool, seed: int) -> Bars:
    """Let robots stand, level and on a slope, and see how they creep."""
    jobs = list(product(available_robots(), (0.0, _SLOPE)))
    duration = _QUICK_STANDING if quick else _STANDING
    with worker_pool() as pool:
        results = _in_both(pool, standing_creep, [(*job, duration) for job in jobs])
    bars, details = [], {}
    for index, backend in enumerate(BACKENDS):
        creeps = {job: result[index][0] for job, result in zip(jobs, results)}
        details[backend] = {f'{name} {slope:g}': creep for (name, slope), creep in creeps.items()}
        for label, wanted in (('level', 0.0), (f'on a slope of {_SLOPE:g} rad', _SLOPE)):
            chosen = [creep for (_, slope), creep in creeps.items() if slope == wanted]
            speed, turn = (max(values) for values in zip(*chosen))
            bars += [
                at_most(f'{backend}: creep, {label}', 1e3 * speed, 'mm/s', 0.01),
                at_most(f'{backend}: turn, {label}', math.degrees(turn), 'deg/s', 0.01),
            ]
    return bars, details


def standing_creep(name: str, slope: float, duration: float) -> tuple[float, float]:
    """
    Let a robot stand, and measure how it creeps.

    Parameters
    ----------
    name : str
        Robot.
    slope : float
        Slope of the ground [rad].
    duration : float
        Time that it stands [s].

    Returns
    -------
    tuple of float
        Mean speeds of the body, after it has settled [m/s, rad/s].
    """
    robot = load_robot(name)
    world = None
    if slope:
        text = f'slope:angle={slope}'
        bounds, start = (-3.0, -3.0, 3.0, 3.0), Pose2D(0.0, 0.0, 0.0)
        terrain = make_terrain(specs_from_text(text), bounds, start)
        world = World(np.empty((0, 4, 2)), terrain=terrain)
    simulator = make_simulator('auto', robot, world)
    try:
        simulator.reset(Pose2D(1.0 if slope else 0.0, 0.0, 0.0))
        began, before = _stood(simulator, robot.initial_joint_angles, _SETTLING)
        ended, after = _stood(simulator, robot.initial_joint_angles, duration)
    finally:
        simulator.close()
    moved, elapsed = before.inverse() @ after, ended - began
    return math.hypot(moved.x, moved.y) / elapsed, abs(moved.yaw) / elapsed


def _stood(simulator: Simulator, posture: Array, duration: float) -> tuple[float, Pose2D]:
    """Let a robot stand; return the time, and where it is."""
    joints, still = posture.reshape(-1), np.zeros(12)
    for _ in range(round(duration / simulator.time_step)):
        simulator.step(joints, still)
    return simulator.time, simulator.observe().pose


def _walks(console: Console, quick: bool, seed: int) -> Bars:
    """Walk every gait of every robot in every direction, and compare."""
    cases = _sample(
        [Case(*job) for job in product(available_robots(), _GAITS, DIRECTIONS)], 4, quick, seed
    )
    duration = _QUICK_WALK if quick else _WALK
    with worker_pool() as pool:
        pairs = _in_both(pool, _walked, [(case, duration) for case in cases])
    table = Table('robot, gait, direction', *(f'{b}: {w}' for b in BACKENDS for w in _COLUMNS))
    ratios, lost = [], []
    for case, ((a, _), (b, _)) in zip(cases, pairs):
        table.add_row(str(case), *_described(a), *_described(b))
        ratios.append(max(b.tilt_rms, _LEAST_TILT) / max(a.tilt_rms, _LEAST_TILT))
        lost += [_off(a), _off(b)]
    console.print(table)
    walks: list[tuple[SteadyWalk, int]] = [result for pair in pairs for result in pair]
    worst = int(np.argmax(ratios))
    details = {str(case): [asdict(a), asdict(b)] for case, ((a, _), (b, _)) in zip(cases, pairs)}
    return [
        figure('walks in each engine', len(cases), f'of {duration:g} s'),
        at_most('falls in both', sum(walk.has_fallen for walk, _ in walks), '', 0),
        at_most('warnings of solvers', sum(said for _, said in walks), '', 0),
        at_most(f'tilt, MuJoCo over PyBullet, at most ({cases[worst]})', max(ratios), 'times', 1.5),
        figure('tilt, MuJoCo over PyBullet, median', float(np.median(ratios)), 'times'),
        figure('largest error of a cycle', 1e2 * max(lost), '% of what was asked'),
    ], details


_COLUMNS = ('advance', 'tilt rms')


def _walked(case: Case, duration: float) -> SteadyWalk:
    robot = load_robot(case.robot)
    gait = load_gait(case.gait, robot)
    seconds = max(duration, 5.0 * gait.cycle_period)
    return steady_walk(robot, gait, DIRECTIONS[case.direction], seconds)


def _off(walk: SteadyWalk) -> float:
    """Return by what fraction a cycle's motion is off what was asked."""
    size = math.hypot(walk.asked.forward, walk.asked.left, 0.2 * walk.asked.turn)
    error = walk.done.minus(walk.asked)
    return math.hypot(error.forward, error.left, 0.2 * error.turn) / size


def _described(walk: SteadyWalk) -> tuple[str, str]:
    fell = ', FELL' if walk.has_fallen else ''
    return f'{1e2 * (1.0 - _off(walk)):.2f} %', f'{math.degrees(walk.tilt_rms):.3f} deg{fell}'


def _open_loop(console: Console, quick: bool, seed: int) -> Bars:
    """Walk without a correction, by the same joint commands."""
    jobs = _sample(list(product(available_robots(), _GAITS)), 3, quick, seed)
    with worker_pool() as pool:
        pairs = _in_both(pool, open_loop, [(*job, 4 if quick else 12) for job in jobs])
    bars, details = [], {}
    for (name, gait), ((a, _), (b, _)) in zip(jobs, pairs):
        apart = abs(b.mean.forward / a.mean.forward - 1.0)
        limit = 4.0 if gait == 'trot' else 1.0
        bars.append(at_most(f'{name} {gait} open loop: advance apart', 1e2 * apart, '%', limit))
        details[f'{name} {gait}'] = [asdict(a), asdict(b)]
    return bars, details


def open_loop(name: str, gait_name: str, cycles: int) -> MeasuredMotion:
    """Walk straight on at half the largest stride, and measure so many cycles."""
    robot = load_robot(name)
    gait = load_gait(gait_name, robot)
    ahead = BodyMotion(forward=1.0)
    asked = ahead.scaled(0.5 * MotionLimits(robot, gait).largest_scale(ahead))
    return measure_motion(robot, gait, asked, cycles)


def _calibrations(console: Console, quick: bool, seed: int) -> Bars:
    """See how far calibrations that were made in the first engine hold in both."""
    jobs = _sample(
        [
            (name, calibration)
            for name in available_robots()
            for calibration in load_compensation(calibration_file(name)).calibrations
        ],
        4,
        quick,
        seed,
    )
    cycles = 4 if quick else 8
    with worker_pool() as pool:
        raw = _in_both(pool, calibration_error, [(*job, False, cycles) for job in jobs])
        compensated = _in_both(pool, calibration_error, [(*job, True, cycles) for job in jobs])
    bars, details = [], {}
    for label, pairs in (('as they are', raw), ('compensated', compensated)):
        for index, backend in enumerate(BACKENDS):
            errors = [1e2 * pair[index][0] for pair in pairs]
            name = f'{backend}: motions {label}, off what is wanted'
            bars += [
                figure(f'{name}, median', float(np.median(errors)), '%'),
                figure(f'{name}, at most', max(errors), '%'),
            ]
            details[f'{backend}, {label}'] = errors
    return bars, details


def calibration_error(
    name: str, calibration: Calibration, is_compensated: bool, cycles: int
) -> float:
    """Return by what fraction of it a motion misses what was wanted, open loop."""
    robot = load_robot(name)
    gait = load_gait(calibration.gait, robot)
    wanted = calibration.wanted
    asked = calibration.asked if is_compensated else wanted
    return motion_error(measure_motion(robot, gait, asked, cycles), wanted) / motion_size(wanted)


def _ground(console: Console, quick: bool, seed: int) -> Bars:
    """Walk over uneven ground, and let joints fail."""
    courses = _sample(list(product(('titan_viii', 'genibo'), _COURSES)), 1, quick, seed)
    rng = np.random.default_rng(seed)
    count = 1 if quick else _CASES
    failures = [
        case
        for name in ('titan_viii', 'genibo')
        for case in random_cases(name, 'crawl', 'flat', count, rng)
    ]
    with worker_pool() as pool:
        walks = _in_both(pool, _crossed, [(*course, seed) for course in courses])
        failed = _in_both(pool, walk_and_fail, [(case,) for case in failures])
    bars: list[Criterion] = []
    for index, backend in enumerate(BACKENDS):
        crossed: list[TerrainOutcome] = [pair[index][0] for pair in walks]
        outcomes: list[FailureOutcome] = [pair[index][0] for pair in failed]
        arrived = sum(outcome.arrived for outcome in crossed)
        named = sum(outcome.is_named for outcome in outcomes)
        falls = sum(walk.has_fallen for walk in crossed) + sum(o.has_fallen for o in outcomes)
        tilt = max(math.degrees(outcome.largest_tilt) for outcome in crossed)
        bars += [
            at_least(f'{backend}: courses crossed, of {len(crossed)}', arrived, '', len(crossed)),
            at_most(f'{backend}: falls over courses and by failed joints', falls, '', 0),
            figure(f'{backend}: failed joints that are named, of {len(outcomes)}', named, ''),
            figure(f'{backend}: largest tilt over courses', tilt, 'deg'),
        ]
    return bars, {
        'courses': {
            ' '.join(job): [asdict(a), asdict(b)] for job, ((a, _), (b, _)) in zip(courses, walks)
        },
        'failures': [[asdict(a), asdict(b)] for (a, _), (b, _) in failed],
    }


_COURSES = ('bumps', 'slope', 'kerb', 'boxes')


def _crossed(name: str, course: str, seed: int) -> TerrainOutcome:
    robot = load_robot(name)
    return walk_course(robot, make_course(robot, course, seed))


PARTS: dict[str, Callable[[Console, bool, int], Bars]] = {
    'steps': step_times,
    'creep': _creep,
    'walks': _walks,
    'open_loop': _open_loop,
    'calibrations': _calibrations,
    'ground': _ground,
    'loop': loop_speed,
    'topics': topic_speed,
}
"""What is compared, by the name for ``--only``."""
