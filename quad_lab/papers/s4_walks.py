"""
S4's figures 9 to 11, walked in physics, and what they are walked by.
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait import Gait, load_gait
from quad_gait.cycle.gait_check import DIRECTIONS
from quad_gait.cycle.gait_generator import generate_steady_cycle
from quad_gait.cycle.stability import support_polygon
from quad_lab.closed_loop.calibration import measure_motion
from quad_lab.closed_loop.gait_measures import SteadyWalk, recorded_steady_walk
from quad_lab.closed_loop.loop_record import Record
from quad_lab.papers.comparison import (
    Exhibit,
    at_least,
    at_most,
    same,
)
from quad_lab.papers.drawing import (
    COLORS,
    draw_body,
    draw_stance,
    name_axes,
    panels,
)

Array = NDArray[np.float64]

STRIDE = BodyMotion(forward=0.065)
"""Motion of a cycle of S4 fig. 10."""


SPIN = BodyMotion(turn=math.radians(15.0))
"""Motion of a cycle of S4 fig. 11."""

_START = 10.0
"""Time within which the walk has set off [s]."""


def wave() -> tuple[Robot, Gait]:
    """Return Genibo and its wave gait."""
    robot = load_robot('genibo')
    return robot, load_gait('wave', robot)


def without_sway(gait: Gait) -> Gait:
    """Return the gait whose body does not sway."""
    return replace(gait, sway_weight=(0.0, 0.0))


def tilting_walk(sways: bool, duration: float) -> tuple[SteadyWalk, Record]:
    """Walk ahead for a time [s] in physics, with or without sway (S4 fig. 9)."""
    robot, gait = wave()
    chosen, least = (gait, 0.005) if sways else (without_sway(gait), -math.inf)
    return recorded_steady_walk(robot, chosen, DIRECTIONS['forward'], duration, STRIDE, least)


def walk_exhibits() -> list[Exhibit]:
    """Walk and spin in physics, as figures 9 to 11 have it."""
    robot, gait = wave()
    swaying, with_sway = tilting_walk(True, 60.0)
    _, without = tilting_walk(False, 60.0)
    forward = measure_motion(robot, gait, STRIDE, 12)
    spin = measure_motion(robot, gait, SPIN, 6)
    return [
        _tilts_exhibit(without, with_sway, swaying.least_margin),
        Exhibit(
            'S4',
            'Fig. 10',
            'the forward gait',
            (
                same('period', 4.0, gait.cycle_period, 's', 0.05),
                same('walked in a period, in physics', 65.0, 1e3 * forward.mean.forward, 'mm', 0.5),
            ),
            '',
            _drawn_cycle(robot, gait, STRIDE, 1),
        ),
        Exhibit(
            'S4',
            'Fig. 11',
            'the rotation gait',
            (
                same(
                    'turned by a step, in physics', 15.0, math.degrees(spin.mean.turn), 'deg', 0.5
                ),
                same('turned by six steps', 90.0, 6.0 * math.degrees(spin.mean.turn), 'deg', 0.5),
            ),
            '',
            _drawn_cycle(robot, gait, SPIN, 6),
        ),
    ]


def _tilts_exhibit(without: Record, with_sway: Record, margin: float) -> Exhibit:
    """Compare tilts without and with sway; the margin with it is in metres."""
    whole = [math.degrees(record.tilt_rms) for record in (without, with_sway)]
    later = [_steady_tilt(record) for record in (without, with_sway)]
    first = math.degrees(float(without.tilts.max()))
    return Exhibit(
        'S4',
        'Fig. 9',
        'tilt of the body, without and with sway',
        (
            at_most(
                'tilt rms with sway, of that without',
                'much more stable',
                1e2 * whole[1] / whole[0],
                '%',
                50.0,
                0,
            ),
            at_most(
                f'tilt rms with sway, of that without, after the first {_START:g} s',
                'much more stable',
                1e2 * later[1] / later[0],
                '%',
                50.0,
                0,
            ).because(
                'once it walks this robot hardly tilts without the sway either: its joints have no '
                'play, and at this stride its margin is small but positive'
            ),
            at_least('least measured margin with sway', 'stable', 1e3 * margin, 'mm', 0.0),
        ),
        f'The curves are lost. Without the sway the body tilts by {first:.1f} degrees as it sets '
        f'off, and by {later[0]:.2f} degrees rms later; with it by {later[1]:.2f}. The setting off '
        'is not drawn.',
        partial(_draw_tilts, without, with_sway),
    )


def _steady_tilt(record: Record) -> float:
    """Return the root mean square of the tilt after the start [deg]."""
    later = record.tilts[np.asarray(record.times) > _START]
    return math.degrees(float(np.sqrt(np.mean(np.square(later)))))


def _draw_tilts(without: Record, with_sway: Record, figure: Figure) -> None:
    for axes, record, title in zip(
        panels(figure, 1, 2, shared_y=True), (without, with_sway), ('without sway', 'with sway')
    ):
        times = np.asarray(record.times)
        later = times > _START
        tilts = np.degrees(record.rolls_and_pitches)[later]
        for k, name in enumerate(('about x (roll)', 'about y (pitch)')):
            axes.plot(times[later], tilts[:, k], color=COLORS[k], linewidth=0.9, label=name)
        name_axes(axes, 'time [s]', 'inclination [deg]', title)
    figure.axes[0].legend(fontsize=6)


def _drawn_cycle(robot: Robot, gait: Gait, motion: BodyMotion, count: int) -> partial[None]:
    """Return what draws the stance before and after so many cycles, from above."""
    return partial(_draw_stances, generate_steady_cycle(robot, gait, motion), count)


def _draw_stances(cycle: Cycle, count: int, figure: Figure) -> None:
    body = np.zeros(3)
    end = cycle.body[-1]
    feet = cycle.feet[0, :, :2]
    poses, stances = [body], [feet]
    for _ in range(count):
        cos, sin = math.cos(body[2]), math.sin(body[2])
        turn = np.array([[cos, -sin], [sin, cos]])
        stances.append(body[:2] + cycle.feet[-1, :, :2] @ turn.T)
        body = np.array([*(body[:2] + turn @ end[:2]), body[2] + end[2]])
        poses.append(body)
    titles = ('at the beginning', f'after {count} period{"s" if count > 1 else ""}')
    for axes, k, title in zip(panels(figure, 1, 2, shared_y=True), (0, -1), titles):
        down = np.ones(4, dtype=bool)
        points = 1e3 * stances[k]
        draw_stance(axes, points, down, support_polygon(points, down))
        draw_body(axes, poses[k] * (1e3, 1e3, 1.0), 75.0, 45.0)
        axes.set_xlim(-170.0, 200.0)
        axes.set_ylim(-140.0, 140.0)
        name_axes(axes, 'forward [mm]', 'to the left [mm]', title)
