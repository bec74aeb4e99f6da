"""
S4's figures 4 to 11: the wave gait, its sway, and its proper initial posture.

The paper gives neither duty factor nor weights of the sway nor lengths of links; those of the
wave gait and of Genibo's data file are chosen. Its legs are numbered 1 left front, 2 right front,
3 left hind, 4 right hind.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.footholds import steady_ends
from quad_gait.cycle.gait_generator import generate_steady_cycle
from quad_gait.cycle.stability import support_polygon
from quad_lab.papers.comparison import (
    Exhibit,
    Part,
    at_least,
    at_most,
    same,
    words,
)
from quad_lab.papers.drawing import (
    COLORS,
    LEG_NAMES,
    LEG_NUMBERS,
    draw_body,
    draw_stance,
    name_axes,
    panels,
)
from quad_lab.papers.s4_posture import ranges_exhibit, strides_exhibit
from quad_lab.papers.s4_walks import SPIN, STRIDE, walk_exhibits, wave, without_sway

Array = NDArray[np.float64]

EXHIBITS = ('Fig. 4', 'Fig. 5', 'Fig. 6', 'Fig. 7', 'Fig. 8', 'Fig. 9', 'Fig. 10', 'Fig. 11')
"""Those that show a result; the others are sketches of coordinates."""


def planned_exhibits() -> list[Exhibit]:
    """Plan cycles for figures 4 to 8."""
    return [_diagram(), _gaits(), _sway(), ranges_exhibit(), strides_exhibit()]


def _diagram() -> Exhibit:
    _, gait = wave()
    edges = [0.0]
    for swing in gait.swings:
        edges += [swing.liftoff, swing.touchdown]
    pauses = [edges[k + 1] - edges[k] for k in range(0, len(edges) - 1, 2)]
    pauses[0] += gait.cycle_period - edges[-1]
    order = ' '.join(LEG_NUMBERS[swing.leg] for swing in gait.swings)
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
        axes.set_yticks(range(4), [f'{LEG_NUMBERS[leg]}, {n}' for leg, n in zip(LEGS, LEG_NAMES)])
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
            at_most(
                f'{name}: posture after a period, off', 'the posture is kept', moved, 'mm', 0.005, 2
            )
        )
    own = _own_advance(cycles)
    rows.append(
        at_most(
            'motion that a leg contributes, off the others', 'the same amount', own, '%', 0.01, 2
        )
    )
    return Exhibit(
        'S4',
        'Fig. 5',
        'body and next footholds of several gaits',
        tuple(rows),
        'All six are one generator, which differs in the motion of the body alone.',
        partial(_draw_gaits, cycles),
    )


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
            axes.text(
                float(first[k, 0]),
                float(first[k, 1]),
                f' {LEG_NUMBERS[leg]}',
                fontsize=7,
                va='bottom',
            )
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
        'S4',
        'Fig. 6',
        'sway of the body towards centroids',
        rows,
        'Before each swing the body moves towards the centroid of the next support polygon; the '
        'weights mu are lost, and chosen: 0.5 forward and 0.25 sideways.',
        partial(_draw_sway, swaying),
    )


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
    figure.set_size_inches(7.6, 1.9)
    for axes, swing in zip(panels(figure, 1, 4, shared_y=True), cycle.gait.swings):
        k = cycle.sample((swing.liftoff + swing.touchdown) / 2.0)
        feet, down = 1e3 * cycle.feet[k, :, :2], cycle.in_contact[k]
        draw_stance(axes, feet, down, support_polygon(feet, down))
        draw_body(axes, cycle.body[k] * (1e3, 1e3, 1.0), 75.0, 45.0)
        axes.plot(*feet[down].mean(axis=0), 'x', color='black', markersize=6)
        path = 1e3 * cycle.center_of_mass
        axes.plot(*path.T, color='0.5', linewidth=0.8)
        axes.plot(*path[k], '*', color=COLORS[1], markersize=8)
        axes.set_xlim(-90.0, 150.0)
        axes.set_ylim(-72.0, 72.0)
        axes.set_title(f'leg {LEG_NUMBERS[swing.leg]} swings', fontsize=8)
    figure.supxlabel('forward [mm]; star: center of mass, cross: centroid', fontsize=8)
    figure.supylabel('left [mm]', fontsize=8)


PARTS: Sequence[Part] = (
    Part('S4', 'planned cycles', planned_exhibits),
    Part('S4', 'walks', walk_exhibits, needs_physics=True),
)
"""What is measured, in the order of the figures."""
