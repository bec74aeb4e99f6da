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
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.planar_pair.active_pair import with_knee_held
from quad_common.planar_pair.planar_pair import ActivePair, PairPosture, PlanarLeg, points_of

PAIR = ActivePair(PlanarLeg(0.7, 0.7), PlanarLeg(0.7, 0.7), lambda_i=-1.0, lambda_j=1.0)
FOOT_I, FOOT_J = -1.7 + 0.0j, 0.3 + 0.0j
HIP_I = -1.68 + 0.898j
U1_J = 0.18
"""The initial state (S3 fig. 8)."""

_FAINT = 9
"""Postures between the ends of a sweep."""

_COLORS = ('#1f4fd8', '#d62728', '#2a9d2a')


@dataclass(frozen=True)
class Sweep:
    """One input that varies."""

    name: str
    """Of the picture's file."""
    title: str
    what: str
    """The input."""
    unit: str
    values: tuple[float, ...]
    """Those of the paper's captions."""
    ends: tuple[float, float]
    """Between which it is swept."""
    hip_by_value: complex
    """How hip i moves with the input."""

    def posture(self, values: NDArray[np.float64]) -> PairPosture:
        """Work out the postures."""
        at_rest = (HIP_I * self.hip_by_value.conjugate()).real
        hip_i = HIP_I + (values - at_rest) * self.hip_by_value
        u1_j = values if self.hip_by_value == 0 else np.full_like(values, U1_J)
        return with_knee_held(PAIR, hip_i, FOOT_I, FOOT_J, u1_j, branch='down', knee_i='up')


SWEEPS = (
    Sweep(
        'figs_9_and_10_hip_x',
        'Hip i moves along x',
        'hip i x',
        'm',
        (-2.6, -0.76),
        (-2.6, -0.76),
        1.0 + 0.0j,
    ),
    Sweep('fig_10_hip_z', 'Hip i moves along z', 'hip i z', 'm', (0.818, 0.978), (0.6, 1.2), 1.0j),
    Sweep('fig_10_u1', 'Knee j turns', 'u1 j', 'rad', (0.18, 0.3, -0.16), (-1.2, 1.2), 0.0j),
)
"""Hip i's x (S3 figs. 9 and 10), its z, and u1 of leg j (S3 fig. 10)."""


@dataclass(frozen=True)
class Reproduction:
    """What came out."""

    summary: str
    """In a few sentences."""
    rows: list[dict[str, str | float]]
    """A posture each: what was given, and what was found."""
    pictures: list[Path]


def reproduce(output: Path) -> Reproduction:
    """
    Draw the initial state and the three sweeps, and list the postures of the captions.

    Parameters
    ----------
    output : Path
        Folder for the pictures.

    Returns
    -------
    Reproduction
        Rows in degrees and metres.
    """
    output.mkdir(parents=True, exist_ok=True)
    initial = with_knee_held(PAIR, HIP_I, FOOT_I, FOOT_J, U1_J, branch='down', knee_i='up')
    rows = [_row('initial: u1 j [rad]', U1_J, initial)]
    pictures = [output / 'fig_8_initial.png']
    figure, axes = _figure('Initial state')
    _draw(axes, initial, _COLORS[0], 1.0, f'u1 j = {U1_J:g} rad')
    _name_points(axes, initial)
    _write(figure, axes, pictures[0])
    for sweep in SWEEPS:
        figure, axes = _figure(sweep.title)
        shades = np.linspace(0.75, 0.35, _FAINT)
        postures = sweep.posture(np.linspace(*sweep.ends, _FAINT, dtype=np.float64))
        for index, shade in enumerate(shades):
            _draw(axes, postures[index], str(shade), 0.8)
        axes.plot(
            [], [], color='0.55', label=f'{sweep.ends[0]:g} (faint) to {sweep.ends[1]:g} (dark)'
        )
        _track(axes, sweep)
        for value, color in zip(sweep.values, _COLORS):
            posture = sweep.posture(np.array(value))
            _draw(axes, posture, color, 1.0, f'{sweep.what} = {value:g} {sweep.unit}')
            rows.append(_row(f'{sweep.what} [{sweep.unit}]', value, posture))
        pictures.append(output / f'{sweep.name}.png')
        _write(figure, axes, pictures[-1])
    return Reproduction(
        'S3: postures of a pair of legs with knee j held and three joints free.\n'
        'Links 0.7 m, hips 2 m apart, feet at x = -1.7 and 0.3 m: chosen, as the paper has lost '
        'its own.',
        rows,
        pictures,
    )


def _row(what: str, value: float, posture: PairPosture) -> dict[str, str | float]:
    return {
        'input': what,
        'value': value,
        'theta [deg]': round(math.degrees(posture.theta), 3),
        'hip j x [m]': round(float(posture.hip_j.real), 4),
        'hip j z [m]': round(float(posture.hip_j.imag), 4),
        'u2 j [deg]': round(math.degrees(posture.u2_j), 3),
        'u1 i [deg]': round(math.degrees(posture.u1_i), 3),
        'u2 i [deg]': round(math.degrees(posture.u2_i), 3),
    }


def _figure(title: str) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(8.6, 3.7))
    FigureCanvasAgg(figure)
    axes = figure.add_axes((0.07, 0.13, 0.7, 0.79))
    axes.axhspan(-10.0, 0.0, color='#eee8dc', zorder=0)
    axes.axhline(0.0, color='#8a7f6a', linewidth=1.0, zorder=1)
    axes.set_title(title, fontsize=10)
    return figure, axes


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


def _write(figure: Figure, axes: Axes, path: Path) -> None:
    axes.plot(
        [FOOT_I.real, FOOT_J.real],
        [FOOT_I.imag, FOOT_J.imag],
        '^',
        color='black',
        markersize=8,
        zorder=5,
        label='feet',
    )
    axes.plot([], [], 's', color='0.3', markersize=5, label='hips')
    axes.set_aspect('equal')
    axes.set_xlim(-2.95, 1.75)
    axes.set_ylim(-0.25, 1.75)
    axes.set_xticks(np.arange(-2.5, 2.0, 0.5))
    axes.set_yticks(np.arange(0.0, 2.0, 0.5))
    axes.set_xlabel('x [m]')
    axes.set_ylabel('z [m]')
    axes.legend(fontsize=7, loc='upper left', bbox_to_anchor=(1.0, 1.0), borderaxespad=0.5)
    figure.savefig(path, dpi=110)
