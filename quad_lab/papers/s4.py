"""
S4's figures 4 to 11: the wave gait, its sway, and its proper initial posture.

The paper gives neither duty factor nor weights of the sway nor lengths of links; those of the
wave gait and of Genibo's data file are chosen. Its legs are numbered 1 left front, 2 right front,
3 left hind, 4 right hind.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.errors import FootTargetUnreachable, GaitError
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.footholds import steady_ends
from quad_gait.cycle.gait import Gait, Swing, load_gait
from quad_gait.cycle.gait_check import DIRECTIONS
from quad_gait.cycle.gait_generator import generate_steady_cycle
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.stability import support_polygon
from quad_lab.closed_loop.calibration import measure_motion
from quad_lab.closed_loop.gait_measures import SteadyWalk, recorded_steady_walk
from quad_lab.closed_loop.loop_record import Record
from quad_lab.papers.comparison import (
    Exhibit,
    Part,
    at_least,
    at_most,
    less,
    more,
    same,
    words,
)
from quad_lab.papers.drawing import (
    COLORS,
    LEG_NAMES,
    draw_body,
    draw_legs,
    draw_stance,
    name_axes,
    panels,
)
from quad_lab.papers.s0 import without_balls

Array = NDArray[np.float64]

EXHIBITS = ('Fig. 4', 'Fig. 5', 'Fig. 6', 'Fig. 7', 'Fig. 8', 'Fig. 9', 'Fig. 10', 'Fig. 11')
"""Those that show a result; the others are sketches of coordinates."""

STRIDE = BodyMotion(forward=0.065)
"""Motion of a cycle of S4 fig. 10."""

SPIN = BodyMotion(turn=math.radians(15.0))
"""Motion of a cycle of S4 fig. 11."""

_NUMBERS = {'lf': '1', 'rf': '2', 'lh': '3', 'rh': '4'}
"""The paper's numbers of the legs."""


def wave() -> tuple[Robot, Gait]:
    """Return Genibo and its wave gait."""
    robot = load_robot('genibo')
    return robot, load_gait('wave', robot)


def with_equal_feet(gait: Gait) -> Gait:
    """Return the gait whose feet begin alike under the body, as S4 fig. 7 (a) has them."""
    return replace(gait, footholds='initial_posture')


def without_sway(gait: Gait) -> Gait:
    """Return the gait whose body does not sway."""
    return replace(gait, sway_weight=(0.0, 0.0))


@dataclass(frozen=True)
class LongestStrides:
    """What legs reach (S4 fig. 8), however fast the joints must be."""

    without: float
    """Without the proper initial posture [m]."""
    proper: float
    """With it [m]."""


def longest_strides() -> LongestStrides:
    """Find the longest strides; how fast the joints of 2008 were is not told."""
    robot, gait = wave()
    tireless = replace(robot, velocity=1e3 * robot.velocity)
    return LongestStrides(
        *(
            MotionLimits(tireless, one, reserve=1.0).largest_scale(BodyMotion(forward=1.0))
            for one in (with_equal_feet(gait), gait)
        )
    )


def tilting_walk(sways: bool, duration: float) -> tuple[SteadyWalk, Record]:
    """Walk ahead for a time [s] in physics, with or without sway (S4 fig. 9)."""
    robot, gait = wave()
    chosen, least = (gait, 0.005) if sways else (without_sway(gait), -math.inf)
    return recorded_steady_walk(robot, chosen, DIRECTIONS['forward'], duration, STRIDE, least)


def planned_exhibits() -> list[Exhibit]:
    """Plan cycles for figures 4 to 8."""
    return [_diagram(), _gaits(), _sway(), _ranges(), _strides()]


def _diagram() -> Exhibit:
    _, gait = wave()
    edges = [0.0]
    for swing in gait.swings:
        edges += [swing.liftoff, swing.touchdown]
    pauses = [edges[k + 1] - edges[k] for k in range(0, len(edges) - 1, 2)]
    pauses[0] += gait.cycle_period - edges[-1]
    order = ' '.join(_NUMBERS[swing.leg] for swing in gait.swings)
    factors = [gait.duty_factor(leg) for leg in LEGS]
    rows = (
        words('order of the legs', '4 2 3 1', order),
        at_least('duty factor beta', 'more than 0.75', min(factors), '', 0.7501, 2),
        at_least('shortest time with all feet down', 'long enough', min(pauses), 's', 0.05, 2),
        same('such intervals in a cycle', 4, len(pauses), '', 0.0, 0),
    )

    def draw(figure: Figure) -> None:
        (axes,) = panels(figure, 1, 1)
        for k, leg in enumerate(LEGS):
            swing = gait.swing(leg)
            for start, end in ((0.0, swing.liftoff), (swing.touchdown, gait.cycle_period)):
                axes.barh(k, end - start, left=start, height=0.5, color=COLORS[k])
        axes.set_yticks(range(4), [f'{_NUMBERS[leg]}, {n}' for leg, n in zip(LEGS, LEG_NAMES)])
        axes.invert_yaxis()
        name_axes(axes, 'time [s]; bars: on the ground', '')

    return Exhibit('S4', 'Fig. 4', 'diagram of the wave gait', rows, '', draw)


_DRAWN = {
    'forward': BodyMotion(forward=0.04),
    'backward': BodyMotion(forward=-0.04),
    'crab': BodyMotion(forward=0.025, left=0.025),
    'sideways': BodyMotion(left=0.03),
    'spin': SPIN,
    'arc': BodyMotion(forward=0.04, turn=math.radians(12.0)),
}
"""Motions of figure 5; how large its own are is lost."""


def _gaits() -> Exhibit:
    robot, gait = wave()
    cycles = {name: generate_steady_cycle(robot, gait, m) for name, m in _DRAWN.items()}
    rows = []
    for name, cycle in cycles.items():
        ends = steady_ends(robot, gait, cycle.motion).start_feet
        assert ends is not None
        moved = 1e3 * float(np.abs(cycle.end_feet - ends).max())
        rows.append(
            at_most(f'{name}: posture after a period, off', 'the posture is kept', moved, 'mm', 0.005, 2)
        )
    own = _own_advance(cycles)
    rows.append(
        at_most('motion that a leg contributes, off the others', 'the same amount', own, '%', 0.01, 2)
    )
    return Exhibit(
        'S4', 'Fig. 5', 'body and next footholds of several gaits', tuple(rows),
        'All six are one generator, which differs in the motion of the body alone.',
        partial(_draw_gaits, cycles),
    )  # fmt: skip


def _own_advance(cycles: dict[str, Cycle]) -> float:
    """Return how much the steps of legs differ where the body only translates [%]."""
    steps = [
        np.linalg.norm((c.feet[-1] - c.feet[0])[:, :2], axis=1)
        for c in cycles.values()
        if not c.motion.turn
    ]
    return max(1e2 * float(np.ptp(step) / step.mean()) for step in steps)


def _draw_gaits(cycles: dict[str, Cycle], figure: Figure) -> None:
    figure.set_size_inches(7.0, 4.4)
    for axes, (name, cycle) in zip(panels(figure, 2, 3), cycles.items()):
        first, last = 1e3 * cycle.feet[0, :, :2], 1e3 * cycle.feet[-1, :, :2]
        for k, leg in enumerate(LEGS):
            axes.annotate(
                '', last[k], first[k], arrowprops={'arrowstyle': '->', 'color': COLORS[k]}
            )
            axes.plot(*first[k], 'o', color=COLORS[k], markersize=5)
            axes.plot(*last[k], 'o', color=COLORS[k], markerfacecolor='white', markersize=5)
            axes.text(*first[k], f' {_NUMBERS[leg]}', fontsize=7, va='bottom')
        body = cycle.body * (1e3, 1e3, 1.0)
        axes.plot(body[:, 0], body[:, 1], color='0.2', linewidth=1.0)
        draw_body(axes, body[0], 75.0, 45.0)
        axes.set_aspect('equal', adjustable='datalim')
        axes.set_title(name, fontsize=8)
    figure.supxlabel('forward [mm]', fontsize=8)
    figure.supylabel('to the left [mm]', fontsize=8)


def _sway() -> Exhibit:
    robot, gait = wave()
    swaying = generate_steady_cycle(robot, gait, STRIDE)
    stiff = generate_steady_cycle(robot, without_sway(gait), STRIDE)
    rows = (
        at_most(
            'mean distance from the centroid at liftoffs, of that without sway',
            'moves to the centroid',
            1e2 * _mean_distance(swaying) / _mean_distance(stiff),
            '%',
            100.0,
            0,
        ),
        at_least(
            'least planned margin, more than without sway',
            'ensures stability',
            1e3 * (swaying.least_margin - stiff.least_margin),
            'mm',
            0.0,
        ),
    )
    return Exhibit(
        'S4', 'Fig. 6', 'sway of the body towards centroids', rows,
        'Before each swing the body moves towards the centroid of the next support polygon; the '
        'weights mu are lost, and chosen: 0.5 forward and 0.25 sideways.',
        partial(_draw_sway, swaying),
    )  # fmt: skip


def _mean_distance(cycle: Cycle) -> float:
    """Return how far the center of mass is from the support triangle's centroid at liftoffs [m]."""
    distances = []
    for swing in cycle.gait.swings:
        k = cycle.sample(swing.liftoff)
        others = [n for n, leg in enumerate(LEGS) if leg != swing.leg]
        centroid = cycle.feet[k, others, :2].mean(axis=0)
        distances.append(float(np.linalg.norm(cycle.center_of_mass[k] - centroid)))
    return float(np.mean(distances))


def _draw_sway(cycle: Cycle, figure: Figure) -> None:
    figure.set_size_inches(7.2, 2.3)
    for axes, swing in zip(panels(figure, 1, 4, shared_y=True), cycle.gait.swings):
        k = cycle.sample((swing.liftoff + swing.touchdown) / 2.0)
        feet, down = 1e3 * cycle.feet[k, :, :2], cycle.in_contact[k]
        draw_stance(axes, feet, down, support_polygon(feet, down))
        draw_body(axes, cycle.body[k] * (1e3, 1e3, 1.0), 75.0, 45.0)
        axes.plot(*feet[down].mean(axis=0), 'x', color='black', markersize=6)
        path = 1e3 * cycle.center_of_mass
        axes.plot(*path.T, color='0.5', linewidth=0.8)
        axes.plot(*path[k], '*', color=COLORS[1], markersize=8)
        axes.set_title(f'leg {_NUMBERS[swing.leg]} swings', fontsize=8)
    figure.supxlabel('forward [mm]; star: center of mass, cross: centroid', fontsize=8)
    figure.supylabel('left [mm]', fontsize=8)


def _evenly_timed(gait: Gait) -> Gait:
    """Return the gait with swings that begin where S4 eq. 5 has them, (beta - 0.75) T first."""
    beta, period = gait.duty_factor('lf'), gait.cycle_period
    lift = [(beta - 0.75 + 0.25 * k) * period for k in range(4)]
    swings = [
        Swing(swing.leg, at, at + (1.0 - beta) * period - 1e-9)
        for swing, at in zip(gait.swings, lift)
    ]
    return replace(gait, swings=tuple(swings), sway_weight=(0.0, 0.0))


def _offsets(robot: Robot, gait: Gait) -> Array:
    """Return the feet at the start, ahead of their neutral places, in order of the swings [m]."""
    start = steady_ends(robot, gait, STRIDE).start_feet
    assert start is not None
    ahead = (start - robot.neutral_feet)[:, 0]
    order = [LEGS.index(swing.leg) for swing in gait.swings]
    result: Array = ahead[order]
    return result


def _ranges() -> Exhibit:
    robot, gait = wave()
    timed = _evenly_timed(gait)
    beta = timed.duty_factor('lf')
    stroke = beta * STRIDE.forward
    offsets = _offsets(robot, timed) / stroke
    published = (
        -(0.5 - (beta - 0.75) / beta), -(0.5 - (beta - 0.5) / beta), (beta - 0.25) / beta - 0.5, 0.5,
    )  # fmt: skip
    proper, equal = _centers(robot, gait), _centers(robot, with_equal_feet(gait))
    rows = (
        *(
            same(f'foot of swing {k + 1} at the start, S4 eq. 5', 1e2 * there, 1e2 * float(here), '% of the stroke', 0.5)
            for k, (there, here) in enumerate(zip(published, offsets))
        ),
        at_most(
            'middles of the ranges, apart: proper posture', 'even', 1e3 * float(np.ptp(proper)),
            'mm', 0.1,
        ),
        at_least(
            'middles of the ranges, apart: feet begin alike', 'different',
            1e3 * float(np.ptp(equal)), 'mm', 1.0,
        ),
    )  # fmt: skip

    def draw(figure: Figure) -> None:
        for axes, one, title in zip(
            panels(figure, 1, 2, shared_y=True),
            (with_equal_feet(gait), gait),
            ('feet begin alike', 'proper initial posture'),
        ):
            ahead, times = _feet_ahead(robot, one)
            draw_legs(axes, times, 1e3 * ahead)
            name_axes(axes, 'time [s]', 'foot ahead of the shoulder [mm]', title)
        figure.axes[0].legend(fontsize=6)

    return Exhibit(
        'S4', 'Fig. 7', 'work ranges of the feet', rows,
        "Rows of S4 eq. 5 are with swings at its times; its lambda is what a foot moves while it "
        'stands, the stroke.', draw,
    )  # fmt: skip


def _feet_ahead(robot: Robot, gait: Gait) -> tuple[Array, Array]:
    """Return how far feet are ahead of their neutral places, (n, 4) [m], and times (n,) [s]."""
    # A ball rolls under its foot, which blurs the ranges by a millimetre or two.
    robot = without_balls(robot)
    cycle = generate_steady_cycle(robot, without_sway(gait), STRIDE)
    feet = robot.foot_positions(cycle.joint_positions)[..., 0]
    return feet - robot.neutral_feet[:, 0], cycle.times


def _centers(robot: Robot, gait: Gait) -> Array:
    """Return the middle of each foot's range [m]."""
    ahead, _ = _feet_ahead(robot, gait)
    middle: Array = (ahead.max(axis=0) + ahead.min(axis=0)) / 2.0
    return middle


def _strides() -> Exhibit:
    robot, gait = wave()
    longest = longest_strides()
    tireless = replace(robot, velocity=1e3 * robot.velocity)
    at_limit = BodyMotion(forward=longest.without)
    limit = generate_steady_cycle(tireless, with_equal_feet(gait), at_limit)
    proper = generate_steady_cycle(tireless, gait, at_limit)
    bend = math.degrees(float(np.abs(proper.joint_positions[..., 2]).min()))
    chosen = 'lengths of links are lost; those that are chosen reach farther'
    rows = (
        more('longest stride, feet begin alike', 60.0, 1e3 * longest.without, 'mm', 0, chosen),
        more('longest stride, proper initial posture', 75.0, 1e3 * longest.proper, 'mm', 0, chosen),
        more('longer by', 25.0, 1e2 * (longest.proper / longest.without - 1.0), '%', 0),
        words(
            'what forbids more, feet begin alike', 'singularity',
            _what_forbids(tireless, with_equal_feet(gait), at_limit.scaled(1.02)),
        ),
        at_least(
            'straightest knee at that stride, proper initial posture', 'smooth', bend, 'deg', 10.0, 0
        ),
    )  # fmt: skip

    def draw(figure: Figure) -> None:
        for axes, cycle, title in zip(
            panels(figure, 1, 2, shared_y=True), (limit, proper), ('feet begin alike', 'proper posture')
        ):
            _draw_knees(axes, cycle, f'{title}: stride of {1e3 * longest.without:.0f} mm')
        figure.axes[0].legend(fontsize=6)

    return Exhibit('S4', 'Fig. 8', 'longer strides by the initial posture', rows, '', draw)


def _what_forbids(robot: Robot, gait: Gait, motion: BodyMotion) -> str:
    """Say what forbids a motion: a leg that is straight is singular."""
    try:
        generate_steady_cycle(robot, gait, motion)
    except FootTargetUnreachable:
        return 'singularity'
    except GaitError as error:
        return str(error)
    return 'nothing'


def _draw_knees(axes: Axes, cycle: Cycle, title: str) -> None:
    draw_legs(axes, cycle.times, np.degrees(np.abs(cycle.joint_positions[..., 2])))
    name_axes(axes, 'time [s]', 'bend of the knee [deg]', title)


def walk_exhibits() -> list[Exhibit]:
    """Walk and spin in physics, as figures 9 to 11 have it."""
    robot, gait = wave()
    swaying, with_sway = tilting_walk(True, 60.0)
    stiff, without = tilting_walk(False, 60.0)
    forward = measure_motion(robot, gait, STRIDE, 12)
    spin = measure_motion(robot, gait, SPIN, 6)
    tilts = [math.degrees(walk.tilt_rms) for walk in (stiff, swaying)]
    return [
        Exhibit(
            'S4', 'Fig. 9', 'tilt of the body, without and with sway',
            (
                at_most(
                    'tilt with sway, rms, of that without', 'much more stable', tilts[1] / tilts[0],
                    '', 0.5, 2,
                ),
                at_least(
                    'least measured margin with sway', 'stable', 1e3 * swaying.least_margin, 'mm', 0.0
                ),
            ),
            f'The curves are lost. Here the tilt is {tilts[0]:.2f} degrees rms without the sway, and '
            f'{tilts[1]:.2f} with it.',
            partial(_draw_tilts, without, with_sway),
        ),
        Exhibit(
            'S4', 'Fig. 10', 'the forward gait',
            (
                same('period', 4.0, gait.cycle_period, 's', 0.05),
                same('walked in a period, in physics', 65.0, 1e3 * forward.mean.forward, 'mm', 0.5),
            ),
            '', _drawn_cycle(robot, gait, STRIDE, 1),
        ),
        Exhibit(
            'S4', 'Fig. 11', 'the rotation gait',
            (
                same('turned by a step, in physics', 15.0, math.degrees(spin.mean.turn), 'deg', 0.5),
                same('turned by six steps', 90.0, 6.0 * math.degrees(spin.mean.turn), 'deg', 0.5),
            ),
            '', _drawn_cycle(robot, gait, SPIN, 6),
        ),
    ]  # fmt: skip


def _draw_tilts(without: Record, with_sway: Record, figure: Figure) -> None:
    for axes, record, title in zip(
        panels(figure, 1, 2, shared_y=True), (without, with_sway), ('without sway', 'with sway')
    ):
        tilts = np.degrees(record.rolls_and_pitches)
        for k, name in enumerate(('about x (roll)', 'about y (pitch)')):
            axes.plot(record.times, tilts[:, k], color=COLORS[k], linewidth=0.9, label=name)
        axes.set_xlim(20.0, 40.0)
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


PARTS: Sequence[Part] = (
    Part('S4', 'planned cycles', planned_exhibits),
    Part('S4', 'walks', walk_exhibits, needs_physics=True),
)
"""What is measured, in the order of the figures."""
