"""
Part of ``quadwalk bench faults``: sensors tell seldom, late, always the same, or nothing.

However bad they are, the robot must not fall, nor be called lame; and once they are good again it
walks on by itself.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from itertools import product
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.planar_pose import Twist2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_lab.attacks.walks.sensor_streams import SENSORS, StreamedLoop, StreamFault
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground, largest_speed
from quad_lab.closed_loop.terrain_walk import make_course
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool

_SELDOM, _LATE = StreamFault(period=0.1), StreamFault(delay=0.15)

FAULTS: dict[str, Mapping[str, StreamFault]] = {
    **{f'{sensor} at 10 Hz': {sensor: _SELDOM} for sensor in SENSORS},
    **{f'{sensor} 0.15 s late': {sensor: _LATE} for sensor in SENSORS},
    **{f'{sensor} silent': {sensor: StreamFault(is_silent=True)} for sensor in SENSORS},
    'odometry at 25 Hz': {'odometry': StreamFault(period=0.04)},
    'imu stuck': {'imu': StreamFault(is_stuck=True)},
    'all 0.15 s late': dict.fromkeys(SENSORS, _LATE),
}
"""What is wrong, of each of the sensors."""

FLAT = 'flat'

WALKERS = (
    ('titan_viii', 'crawl', FLAT, False),
    ('titan_viii', 'trot', FLAT, False),
    ('titan_viii', 'crawl', 'bumps', False),
    ('genibo', 'crawl', 'bumps', False),
    ('genibo', 'trot', FLAT, True),
    ('cuhk', 'trot', FLAT, True),
)
"""Robot, gait, ground, and whether it keeps its balance."""

_QUICK = ((WALKERS[2], 'imu stuck'), (WALKERS[4], 'imu at 10 Hz'))
"""Each fell before it was noticed how old readings are, and that an imu is stuck."""

_STAND, _SOUND, _DISTURBED, _AFTER = 1.0, 4.0, 20.0, 12.0
"""Times for which the robot stands, walks, is disturbed, and is not any more [s]."""

_STEERING = 0.2
"""Time from one wish to the next [s]."""

_SPEED = 0.5
"""Of the most that the gait does."""

_LEAST = 0.25
"""Fraction of the distance it was to go afterwards, at which a robot has gone on."""


@dataclass(frozen=True)
class SensorCase:
    """Who walks, and what is wrong with the sensors."""

    robot: str
    gait: str
    ground: str
    """A course of uneven ground, or `FLAT`."""
    has_balance: bool
    """Whether it keeps its balance."""
    fault: str
    """One of :data:`FAULTS`."""
    seed: int
    """Seed of what disturbs when."""


@dataclass(frozen=True)
class SensorOutcome:
    """What became of it."""

    case: SensorCase
    has_fallen: bool
    """Whether it fell."""
    is_called_lame: bool
    """Whether a joint was said to have failed, or all of them."""
    goes_on: bool
    """Whether it walks once its sensors are good again."""
    tilt: float
    """Largest tilt of the body [rad]."""
    said: str
    """What the gait said last."""


def attack_by_sensors(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Disturb the sensors of walking robots; return bars, and the walks that did not end well."""
    cases = [SensorCase(*walker, fault, seed) for walker, fault in _QUICK]
    if not quick:
        cases = [SensorCase(*walker, fault, seed) for walker, fault in product(WALKERS, FAULTS)]
    outcomes: list[SensorOutcome] = []
    with worker_pool() as pool:
        for outcome in pool.map(walk_with_bad_sensors, cases):
            outcomes.append(outcome)
            if outcome.has_fallen or outcome.is_called_lame or not outcome.goes_on:
                console.print(f'{outcome}')
    count = len(outcomes)
    console.print(f'{count} walks with bad sensors')
    bars = [
        at_most('falls', sum(o.has_fallen for o in outcomes), '', 0),
        at_most('sound robots called lame', sum(o.is_called_lame for o in outcomes), '', 0),
        at_least(f'goes on afterwards, of {count}', sum(o.goes_on for o in outcomes), '', count),
        figure('largest tilt', math.degrees(max(o.tilt for o in outcomes)), 'deg'),
    ]
    return bars, {'walks': [asdict(outcome) for outcome in outcomes]}


def walk_with_bad_sensors(case: SensorCase) -> SensorOutcome:
    """Walk straight on, with bad sensors for a while."""
    robot = load_robot(case.robot)
    gait = load_gait(case.gait, robot)
    balance = BalanceOptions(steps_in_place=True) if case.has_balance else None
    options = SupervisorOptions(least_margin=-math.inf, balance=balance)
    place: dict[str, Any] = {}
    if case.ground == FLAT:
        controller = controller_for(robot, gait, options)
    else:
        course = make_course(robot, case.ground, case.seed)
        place = {'world': course.world, 'start': course.start}
        controller = controller_for(robot, gait, for_uneven_ground(options))
        controller.set_height_map(course.height_map)
    speed = _SPEED * largest_speed(robot, gait, BodyMotion(forward=1.0)).scale
    loop = StreamedLoop(robot, controller, **place)
    lame = False

    def steer(duration: float) -> None:
        nonlocal lame
        end = loop.time + duration
        while loop.time < end and not loop.record.has_fallen:
            controller.set_twist(Twist2D(speed))
            loop.run(_STEERING)
            lame = lame or controller.activity in (Activity.LAME, Activity.NOT_EXECUTED)

    try:
        loop.run(_STAND)
        steer(_SOUND + float(np.random.default_rng(case.seed).uniform(0.0, gait.cycle_period)))
        loop.disturb(FAULTS[case.fault])
        steer(_DISTURBED)
        loop.disturb({})
        steer(_AFTER / 2.0)
        before = loop.record.poses[-1]
        steer(_AFTER / 2.0)
        went = before.distance_to(loop.record.poses[-1])
        return SensorOutcome(
            case,
            loop.record.has_fallen,
            lame,
            went > _LEAST * speed * _AFTER / 2.0,
            float(loop.record.tilts.max()),
            controller.reason,
        )
    finally:
        loop.close()
