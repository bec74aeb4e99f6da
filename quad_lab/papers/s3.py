"""
S3's figures 8 to 10: the postures of a planar pair of legs while one of its three inputs varies.

What is lost, and chosen here: the paper states neither lengths of links nor places of hips
and feet, nor what its constant inputs are; the pictures are not in its text. Its captions give
the inputs that vary: hip i's x at -2.6 and -0.76, its z at 0.818 and 0.978, and u1 of leg j at
0.18, 0.3 and -0.16. Chosen are the body's hips at lambda = -1 and +1, all links 0.7 long, feet 2
apart so that the postures lie about symmetrically over them, and for the constant inputs the
middle between the captions' values, x = -1.68 and z = 0.898, and u1 = 0.18. All of the
captions' postures exist with these. Lengths have the unit of the paper's captions, which it does
not name: metres are taken here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.planar_pair.active_pair import with_knee_held
from quad_common.planar_pair.planar_pair import ActivePair, PairPosture, PlanarLeg, points_of
from quad_lab.papers.comparison import Exhibit, Part, Row, at_most, same
from quad_lab.papers.drawing import name_axes, panels

EXHIBITS = ('Fig. 8', 'Fig. 9', 'Fig. 10')
"""Those that show a result; the others are sketches and block diagrams."""

PAIR = ActivePair(PlanarLeg(0.7, 0.7), PlanarLeg(0.7, 0.7), lambda_i=-1.0, lambda_j=1.0)
FOOT_I, FOOT_J = -1.7 + 0.0j, 0.3 + 0.0j
HIP_I = -1.68 + 0.898j
U1_J = 0.18
"""The initial state (S3 fig. 8)."""

_FAINT = 9
"""Postures between the ends of a sweep."""

_SIZE = (7.6, 3.1)
"""Size of one picture [inches]."""

_COLORS = ('#1f4fd8', '#d62728', '#2a9d2a')


@dataclass(frozen=True)
class Sweep:
    """One input that varies."""

    title: str
    """Title of the picture."""
    what: str
    """Input that varies."""
    unit: str
    """Unit of the input."""
    values: tuple[float, ...]
    """Values of the paper's captions."""
    ends: tuple[float, float]
    """Ends between which it is swept."""
    hip_by_value: complex
    """Direction in which the input moves hip i; 0 if it does not."""

    def posture(self, values: NDArray[np.float64]) -> PairPosture:
        """Work out the postures."""
        at_rest = (HIP_I * self.hip_by_value.conjugate()).real
        hip_i = HIP_I + (values - at_rest) * self.hip_by_value
        u1_j = values if self.hip_by_value == 0 else np.full_like(values, U1_J)
        return with_knee_held(PAIR, hip_i, FOOT_I, FOOT_J, u1_j, branch='down', knee_i='up')


SWEEPS = (
    Sweep(
        'Hip i moves along x',
        'hip i x',
        'm',
        (-2.6, -0.76),
        (-2.6, -0.76),
        1.0 + 0.0j,
    ),
    Sweep('Hip i moves along z', 'hip i z', 'm', (0.818, 0.978), (0.6, 1.2), 1.0j),
    Sweep('Knee j turns', 'u1 j', 'rad', (0.18, 0.3, -0.16), (-1.2, 1.2), 0.0j),
)
"""Hip i's x (S3 figs. 9 and 10), its z, and u1 of leg j (S3 fig. 10)."""


def postures_exhibits() -> list[Exhibit]:
    """Find the postures of the captions, and draw the sweeps between them."""
    initial = with_knee_held(PAIR, HIP_I, FOOT_I, FOOT_J, U1_J, branch='down', knee_i='up')
    along_x, along_z, of_knee = SWEEPS
    first, *rest = [_row(along_x, value) for value in along_x.values]
    rest += [_row(sweep, value) for sweep in (along_z, of_knee) for value in sweep.values]
    closed = at_most(
        'feet by the found angles, off their places',
        'the chain is closed',
        1e3 * _gap(initial),
        'mm',
        1e-6,
        6,
    ).because(_told(initial))
    return [
        Exhibit(
            'S3', 'Fig. 8', 'initial state', (closed,), _CHOSEN, partial(_draw_initial, initial)
        ),
        Exhibit(
            'S3', 'Fig. 9', 'hip i moves along x', (first,), '', partial(_draw_sweeps, (along_x,))
        ),
        Exhibit(
            'S3',
            'Fig. 10',
            'hip i moves, knee j turns',
            tuple(rest),
            'Six figures of the paper have this number; x = -0.76 m is drawn with figure 9.',
            partial(_draw_sweeps, (along_z, of_knee)),
        ),
    ]


_CHOSEN = (
    'Lengths, places of hips and feet, and what is constant are lost. Chosen are links of 0.7 m, '
    'hips 2 m apart, and feet at x = -1.7 and 0.3 m. Behind a verdict stands the posture that is '
    'found.'
)


def _row(sweep: Sweep, value: float) -> Row:
    """Compare a caption's value with that of the posture that is found, by its points."""
    posture = sweep.posture(np.array(value))
    points = points_of(PAIR, posture)
    # The input is not looked up but worked out from what was found: from foot i along leg i, or
    # between the links of leg j.
    leg_i = posture.hip_i - points.foot_i
    hip_i = FOOT_I + leg_i
    lower, upper = points.foot_j - points.knee_j, points.knee_j - points.hip_j
    turned = float(np.angle(lower / upper))
    along = float((hip_i * sweep.hip_by_value.conjugate()).real)
    here = turned if sweep.hip_by_value == 0 else along
    off = math.inf if _gap(posture) > 1e-9 else here
    return same(sweep.what, value, off, sweep.unit, 0.0005, 3).because(_told(posture))


def _gap(posture: PairPosture) -> float:
    """Return how far a posture's feet are from where they stand [m]."""
    points = points_of(PAIR, posture)
    return float(max(abs(points.foot_i - FOOT_I), abs(points.foot_j - FOOT_J)))


def _told(posture: PairPosture) -> str:
    """Write a posture down."""
    hip = posture.hip_j
    angles = [math.degrees(u) for u in (posture.theta, posture.u2_j, posture.u1_i, posture.u2_i)]
    theta, u2_j, u1_i, u2_i = (f'{angle:.1f}' for angle in angles)
    return (
        f'theta {theta}, hip j at {hip.real:.3f}, {hip.imag:.3f} m, u2 of j {u2_j}, '
        f'u1 and u2 of i {u1_i} and {u2_i} degrees'
    )


def _draw_initial(initial: PairPosture, figure: Figure) -> None:
    figure.set_size_inches(_SIZE)
    (axes,) = panels(figure, 1, 1)
    _draw(axes, initial, _COLORS[0], 1.0, f'u1 j = {U1_J:g} rad')
    _name_points(axes, initial)
    _finish(axes, 'Initial state')


def _draw_sweeps(sweeps: tuple[Sweep, ...], figure: Figure) -> None:
    figure.set_size_inches(_SIZE[0], len(sweeps) * _SIZE[1])
    for axes, sweep in zip(panels(figure, len(sweeps), 1), sweeps):
        shades = np.linspace(0.75, 0.35, _FAINT)
        postures = sweep.posture(np.linspace(*sweep.ends, _FAINT, dtype=np.float64))
        for index, shade in enumerate(shades):
            _draw(axes, postures[index], str(shade), 0.8)
        axes.plot([], [], color='0.55', label=f'from {sweep.ends[0]:g} to {sweep.ends[1]:g}')
        _track(axes, sweep)
        for value, color in zip(sweep.values, _COLORS):
            label = f'{sweep.what} = {value:g} {sweep.unit}'
            _draw(axes, sweep.posture(np.array(value)), color, 1.0, label)
        _finish(axes, sweep.title)


def _draw(
    axes: Axes, posture: PairPosture, color: str, strength: float, label: str | None = None
) -> None:
    """Draw body and legs; those of the paper's values stand in front."""
    points = points_of(PAIR, posture)
    front = 3.0 if label is not None else 2.0
    body = np.array([points.hip_i, points.hip_j])
    axes.plot(body.real, body.imag, color=color, linewidth=3.5 * strength, zorder=front)
    for chain in (points[:3], points[3:]):
        leg = np.array(chain)
        axes.plot(
            leg.real,
            leg.imag,
            '-o',
            color=color,
            linewidth=1.6 * strength,
            markersize=3.5 * strength,
            zorder=front + 0.1,
            solid_capstyle='round',
        )
    axes.plot(body.real, body.imag, 's', color=color, markersize=5.5 * strength, zorder=front + 0.2)
    if label is not None:
        axes.plot([], [], color=color, label=label)


def _track(axes: Axes, sweep: Sweep) -> None:
    """Draw the path of hip j over the whole sweep."""
    path = sweep.posture(np.linspace(*sweep.ends, 200, dtype=np.float64)).hip_j
    axes.plot(
        path.real, path.imag, ':', color='#ff8c00', linewidth=1.4, zorder=4, label='path of hip j'
    )


def _name_points(axes: Axes, posture: PairPosture) -> None:
    points = points_of(PAIR, posture)._asdict()
    for name, point in points.items():
        below = name.startswith('foot')
        axes.annotate(
            name.replace('_', ' '),
            (float(point.real), float(point.imag)),
            textcoords='offset points',
            xytext=(-34, -4) if name == 'hip_i' else (9, -14 if below else 4),
            fontsize=8,
        )


def _finish(axes: Axes, title: str) -> None:
    axes.axhspan(-10.0, 0.0, color='#eee8dc', zorder=0)
    axes.axhline(0.0, color='#8a7f6a', linewidth=1.0, zorder=1)
    feet = np.array([FOOT_I, FOOT_J])
    axes.plot(feet.real, feet.imag, '^', color='black', markersize=8, zorder=5, label='feet')
    axes.plot([], [], 's', color='0.3', markersize=5, label='hips')
    axes.set_aspect('equal')
    axes.set_xlim(-2.95, 1.75)
    axes.set_ylim(-0.25, 1.75)
    axes.set_xticks(np.arange(-2.5, 2.0, 0.5))
    axes.set_yticks(np.arange(0.0, 2.0, 0.5))
    name_axes(axes, 'x [m]', 'z [m]', title)
    axes.legend(fontsize=7, loc='upper left', bbox_to_anchor=(1.0, 1.0), borderaxespad=0.5)


PARTS: Sequence[Part] = (Part('S3', 'postures', postures_exhibits),)
"""What is measured."""
