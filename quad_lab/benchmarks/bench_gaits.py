"""
``quadwalk bench gaits``: every gait on every robot in physics, and the papers' figures.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict

import numpy as np
from rich.console import Console
from rich.table import Table

from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait, load_gait
from quad_gait.cycle.gait_check import DIRECTIONS
from quad_lab.benchmarks.gait_speed import speed_bars
from quad_lab.benchmarks.odometry_error import leg_odometry_error
from quad_lab.benchmarks.paper_figures import (
    circles_of_s2,
    figures_of_s0,
    figures_of_s1,
    figures_of_s4,
)
from quad_lab.closed_loop.gait_measures import (
    SteadyWalk,
    steady_walk,
)
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure

WALKING_GAITS = ('crawl', 'crab', 'wave', 'trot', 'walk')

_WALK = 60.0
_QUICK_WALK = 8.0
"""How long each gait is walked in each direction [s]."""


def measure(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk every gait, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress and tables go.
    quick : bool
        A sample that is drawn with the seed.
    seed : int
        Of the quick sample; the full measurement has nothing random.

    Returns
    -------
    tuple
        The bars, and details for JSON.
    """
    details: dict[str, object] = {'quick': quick, 'seed': seed}
    bars: list[Criterion] = []
    parts: tuple[Callable[[], list[Criterion]], ...] = (
        lambda: speed_bars(quick),
        lambda: figures_of_s0(quick),
        lambda: figures_of_s1(quick),
        lambda: circles_of_s2(console, quick, seed, details),
        lambda: figures_of_s4(quick),
        lambda: _odometry(quick),
        lambda: _every_gait(console, quick, seed, details),
    )
    for part in parts:
        began = time.monotonic()
        bars += part()
        console.print(f'{bars[-1].name}: done in {time.monotonic() - began:.0f} s')
    return bars, details


def _odometry(quick: bool) -> list[Criterion]:
    """Leg odometry with the imu's yaw rate, walking an arc, sideways and turning."""
    bars = []
    for gait_name, robot_name in (('crawl', 'titan_viii'), ('wave', 'genibo'), ('trot', 'cuhk')):
        robot = load_robot(robot_name)
        gait = load_gait(gait_name, robot)
        duration = {'crawl': 60.0, 'wave': 48.0, 'trot': 15.0}[gait_name]
        arc = 1.0 / (4.0 * robot.footprint_radius)
        directions = [
            BodyMotion(forward=1.0),
            BodyMotion(forward=1.0, turn=arc),
            BodyMotion(left=1.0),
            BodyMotion(turn=1.0),
        ]
        if quick:
            directions, duration = directions[1:2], duration / 2.0
        errors = [leg_odometry_error(robot, gait, d, duration) for d in directions]
        walking = [e for e, d in zip(errors, directions) if d.forward or d.left]
        bars.append(
            at_most(
                f'leg odometry: {gait_name} of {robot_name}, of the distance',
                1e2 * max(position for position, _ in walking),
                '%',
                3.0,
            )
        )
        bars.append(
            at_most(
                f'leg odometry: {gait_name} of {robot_name}, per turn',
                math.degrees(max(heading for _, heading in errors)),
                'deg',
                2.0,
            )
        )
    return bars


def _every_gait(
    console: Console, quick: bool, seed: int, details: dict[str, object]
) -> list[Criterion]:
    """Every gait that a robot's data name, in six directions."""
    cases = list(_cases())
    duration = _WALK
    if quick:
        rng = np.random.default_rng(seed)
        cases = [cases[k] for k in rng.choice(len(cases), 8, replace=False)]
        duration = _QUICK_WALK
    table = Table(
        'robot', 'gait', 'direction', 'asked', 'done', 'drift', 'veer [deg/m]', 'slip [mm]',
        'margin [mm]', 'tilt rms [deg]', 'torque rms [N m]', 'cost of transport', 'wrong',
    )  # fmt: skip
    walks: list[SteadyWalk] = []
    noted = []
    for robot, gait, name in cases:
        seconds = duration if not gait.is_static else max(duration, 4.0 * gait.cycle_period)
        walk = steady_walk(robot, gait, DIRECTIONS[name], seconds)
        walks.append(walk)
        console.print(f'{robot.name}, {gait.name}, {name}: {_wrong(walk) or "good"}')
        noted.append({'robot': robot.name, 'gait': gait.name, 'direction': name, **asdict(walk)})
        table.add_row(
            robot.name,
            gait.name,
            name,
            _amount(walk.asked),
            _amount(walk.done),
            f'{1e2 * walk.drift:.1f} %',
            f'{math.degrees(walk.veer):.1f}',
            f'{1e3 * walk.slip:.1f}',
            f'{1e3 * walk.least_margin:.1f}',
            f'{math.degrees(walk.tilt_rms):.2f}',
            f'{walk.torque_rms:.2f}',
            '' if math.isnan(walk.transport_cost) else f'{walk.transport_cost:.2f}',
            _wrong(walk),
        )
    console.print(table)
    details['walks'] = noted
    static = [w for w, (_, gait, _) in zip(walks, cases) if gait.is_static]
    return [
        figure('walks of every robot, gait and direction', len(walks), f'of {duration:g} s'),
        at_most('falls', sum(walk.has_fallen for walk in walks), '', 0),
        at_most(
            'walks with numbers that are not finite', sum(not w.is_finite for w in walks), '', 0
        ),
        at_most(
            'walks with a joint out of range', sum(not w.joints_in_range for w in walks), '', 0
        ),
        figure('worst advance or turn of a cycle, off what was asked', 1e2 * _worst(walks), '%'),
        at_least(
            'least measured margin of the static gaits',
            1e3 * min(walk.least_margin for walk in static) if static else None,
            'mm',
            0.0,
        ),
        figure('walks with contacts of other parts', sum(bool(w.contacts) for w in walks), ''),
    ]


def _cases() -> Iterator[tuple[Robot, Gait, str]]:
    for robot_name in available_robots():
        robot = load_robot(robot_name)
        for gait_name in WALKING_GAITS:
            if gait_name in robot.gaits:
                gait = load_gait(gait_name, robot)
                for direction in DIRECTIONS:
                    yield robot, gait, direction


def _worst(walks: list[SteadyWalk]) -> float:
    """Largest fraction by which a cycle's motion is off what was asked."""
    return max(
        math.hypot(
            w.done.forward - w.asked.forward,
            w.done.left - w.asked.left,
            0.2 * (w.done.turn - w.asked.turn),
        )
        / math.hypot(w.asked.forward, w.asked.left, 0.2 * w.asked.turn)
        for w in walks
    )


def _amount(motion: BodyMotion) -> str:
    if abs(motion.turn) * 0.2 > math.hypot(motion.forward, motion.left):
        return f'{math.degrees(motion.turn):.2f} deg'
    return f'{1e3 * math.hypot(motion.forward, motion.left):.1f} mm'


def _wrong(walk: SteadyWalk) -> str:
    wrongs = [
        text
        for text, is_so in (
            ('fallen', walk.has_fallen),
            ('not finite', not walk.is_finite),
            ('joint out of range', not walk.joints_in_range),
        )
        if is_so
    ]
    return ', '.join([*wrongs, *walk.contacts])
