"""
Part of ``quadwalk bench faults``: on uneven ground trajectories come late or never.

A foot that feels for the ground is told bit by bit how far to go, and each bit begins on arrival.
Where one comes late, or is lost, the next must begin from where the joints are: the robot goes on
to its goal, the last gate stops it nowhere, and it does not fall.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from itertools import product

import numpy as np
from rich.console import Console

from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_lab.closed_loop.disturbed_walk import Disturbance, DisturbedWalk
from quad_lab.closed_loop.terrain_walk import make_course
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import AUTO

_ROBOTS, _COURSES = ('titan_viii', 'genibo'), ('kerb', 'boxes')

_LATENESS = (0.2, 0.5)
"""Largest lateness of every fourth trajectory, and longest silence of the joints [s]."""

_JITTERS = (0.03, 0.15, 0.4)
"""Largest lateness of the other trajectories [s]."""

_WALKS = 2
"""Walks of each kind."""

_STAND, _TIMEOUT = 0.5, 800.0
"""Time before the plan is given, and after which a walk is given up [s]."""


@dataclass(frozen=True)
class LateCase:
    """A walk, and how late its trajectories come."""

    robot: str
    course: str
    disturbance: Disturbance
    seed: int
    """Seed of what comes late."""
    backend: str = AUTO
    timeout: float = _TIMEOUT
    """Time after which it is over, however far the robot is [s]."""


@dataclass(frozen=True)
class LateOutcome:
    """What became of a walk."""

    case: LateCase
    late: int
    """Number of trajectories that came late."""
    lost: int
    """Number of trajectories that never came."""
    duration: float
    """Simulated time [s]."""
    has_arrived: bool
    has_fallen: bool
    refused: str
    """What the last gate said when it stopped the robot; empty if it did not."""
    said: str
    """What the gait said last."""
    tilt: float
    """Largest tilt of the body [rad]."""


def _disturbance(lateness: float, jitter: float) -> Disturbance:
    return Disturbance(lateness=lateness, lost=0.01, staleness=lateness, jitter=jitter)


QUICK_CASES = (
    # The last gate stopped this one when it did not know that trajectories are late.
    LateCase('titan_viii', 'kerb', _disturbance(0.5, 0.15), 4, timeout=32.0),
)


def attack_by_lateness(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Let trajectories come late; return bars, and the walks that did not end well."""
    outcomes: list[LateOutcome] = []
    with worker_pool() as pool:
        for outcome in pool.map(walk_with_lateness, QUICK_CASES if quick else all_cases(seed)):
            outcomes.append(outcome)
            if _is_bad(outcome, quick):
                console.print(f'{outcome}', highlight=False)
    bars = [
        figure('trajectories that came late', sum(o.late for o in outcomes), ''),
        figure('trajectories that were lost', sum(o.lost for o in outcomes), ''),
        at_most('walks that the last gate stopped', sum(bool(o.refused) for o in outcomes), '', 0),
        at_most('falls', sum(o.has_fallen for o in outcomes), '', 0),
    ]
    if not quick:
        arrived = sum(o.has_arrived for o in outcomes)
        bars.append(at_least(f'arrived, of {len(outcomes)}', arrived, '', len(outcomes)))
    return bars, {'not well': [asdict(o) for o in outcomes if _is_bad(o, quick)]}


def _is_bad(outcome: LateOutcome, quick: bool) -> bool:
    # Quick walks are too short to arrive.
    return outcome.has_fallen or bool(outcome.refused) or not (quick or outcome.has_arrived)


def all_cases(seed: int) -> list[LateCase]:
    """Return every robot, course and lateness."""
    kinds = product(_ROBOTS, _COURSES, _LATENESS, _JITTERS, range(_WALKS))
    return [
        LateCase(robot, course, _disturbance(lateness, jitter), seed + more + 1)
        for robot, course, lateness, jitter, more in kinds
    ]


def walk_with_lateness(case: LateCase) -> LateOutcome:
    """Walk once."""
    robot = load_robot(case.robot)
    options = for_uneven_ground(SupervisorOptions())
    controller = controller_for(robot, load_gait('crawl', robot), options)
    course = make_course(robot, case.course, 1)
    controller.set_height_map(course.height_map)
    walk = DisturbedWalk(
        robot,
        controller,
        case.disturbance,
        np.random.default_rng(case.seed),
        backend=case.backend,
        world=course.world,
        start=course.start,
    )

    def is_over() -> bool:
        # Where trajectories are lost for long the robot says so, and tries again.
        activity = controller.activity
        return activity.is_terminal and activity is not Activity.NOT_EXECUTED

    try:
        walk.run(_STAND)
        controller.set_plan(course.plan)
        walk.run(case.timeout, is_over)
        is_stopped = controller.activity is Activity.STOPPED
        is_refused = is_stopped and controller.reason.endswith('the robot stops')
        return LateOutcome(
            case,
            walk.late,
            walk.lost,
            walk.time,
            controller.activity is Activity.ARRIVED,
            walk.simulation.has_fallen,
            controller.reason if is_refused else '',
            controller.reason,
            float(walk.record.tilts.max()),
        )
    finally:
        walk.close()
