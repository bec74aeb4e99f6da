"""
S1's tables II and III and figures 8 to 10: one leg that steps.
"""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.robot.leg_builds import LegLengths, LegPlace, yaw_pitch_pitch_leg
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.foot_tracking import DEFAULT_GAIN, step_response
from quad_lab.papers.comparison import Exhibit, at_most, same
from quad_lab.papers.drawing import COLORS, name_axes, panels

Array = NDArray[np.float64]

STEP = 0.02
"""Length of a step, r [m]."""


_BETA = math.pi / 4.0


_SECONDS = 2.0
"""Time after which the foot's error is zero in S1 fig. 10 [s]."""


def leg_step() -> tuple[Array, Array, Array]:
    """
    Bring one leg to the next foothold by backstepping (S1 figs. 8 to 10).

    Returns
    -------
    tuple of ndarray
        Times (n,) [s], joint angles (n, 3) [rad] and the foot's error (n, 3) [m].
    """
    robot = load_robot('pukyong')
    leg, start = robot.legs[0], robot.initial_joint_angles[0]
    across = np.array([math.sin(_BETA), math.cos(_BETA), 0.0])
    target = leg.forward(start) + STEP * across
    return step_response(leg, start, target, DEFAULT_GAIN, _SECONDS, 0.01)


def leg_exhibits() -> list[Exhibit]:
    """Compare the leg of tables II and III, and let it step as in figures 8 to 10."""
    times, angles, errors = leg_step()
    return [
        _leg_table(),
        _posture_table(),
        _step_exhibit(angles),
        _angles_exhibit(times, angles),
        _error_exhibit(times, errors),
    ]


def _leg_table() -> Exhibit:
    leg = load_robot('pukyong').legs[0]
    rows = (
        same('beta', math.pi / 4.0, _BETA, 'rad', 0.0, 4),
        same('r', 2.0, 1e2 * STEP, 'cm', 1e-9),
        same('a1', 2.0, 1e2 * float(leg.radial_offset), 'cm', 1e-9),
        same('a2', 6.0, 1e2 * float(leg.thigh_length), 'cm', 1e-9),
        same('a3', 10.0, 1e2 * float(leg.calf_length), 'cm', 1e-9),
    )
    return Exhibit('S1', 'Table II', 'one leg', rows)


def _posture_table() -> Exhibit:
    half = yaw_pitch_pitch_leg(LegPlace('lf', np.zeros(3), 1), LegLengths(0.01, 0.0, 0.03, 0.05))
    angles = load_robot('pukyong').initial_joint_angles[0]
    # x outward, y forward and z up of this leg, in centimetres.
    forward, out, up = 1e2 * half.forward(angles)
    start = np.array([out, forward, up])
    end = start + 1e2 * STEP * np.array([math.sin(_BETA), math.cos(_BETA), 0.0])
    misprint = (
        "a misprint: the table's own angles and lengths give 2.879, as S1 eq. 9 has it, which the "
        'first coordinate confirms'
    )
    # The paper's z axis is downward: its pitch angles have the other sign.
    theta = np.degrees(angles) * (1.0, -1.0, -1.0)
    rows = (
        *(
            same(name, there, here, 'cm', 0.0006, 3).because(
                misprint if name.startswith('z') else ''
            )
            for name, there, here in (
                *zip(('x_e0', 'y_e0', 'z_e0'), (3.121, 0.0, -2.829), start.tolist()),
                *zip(('x_d', 'y_d', 'z_d'), (4.535, 1.414, -2.829), end.tolist()),
                *zip(('e_x', 'e_y', 'e_z'), (1.414, 1.414, 0.0), (end - start).tolist()),
            )
        ),
        *(
            same(f'theta{k + 1}', there, float(theta[k]), 'deg', 0.05)
            for k, there in enumerate((0.0, 45.0, -135.0))
        ),
    )
    return Exhibit(
        'S1',
        'Table III',
        'initial values',
        rows,
        'These values belong to a leg half as long as that of table II, which is taken here.',
    )


def _step_exhibit(angles: Array) -> Exhibit:
    leg = load_robot('pukyong').legs[0]
    feet = 1e2 * (leg.forward(angles) - leg.hip)
    target = feet[0] + 1e2 * STEP * np.array([math.sin(_BETA), math.cos(_BETA), 0.0])
    rows = (
        at_most(
            'foot at the end, off the desired point',
            'reaches the desired point',
            float(np.linalg.norm(feet[-1] - target)),
            'cm',
            0.02,
            4,
        ),
        at_most(
            'change of height on the path',
            'the desired point has the same z',
            float(np.abs(feet[:, 2] - feet[0, 2]).max()),
            'cm',
            0.02,
            4,
        ),
    )

    def draw(figure: Figure) -> None:
        figure.set_size_inches(5.0, 4.0)
        axes = figure.add_subplot(projection='3d')
        for k, (color, name) in enumerate(((COLORS[0], 'initial'), (COLORS[1], 'desired'))):
            chain = [leg.hip, *leg.chain(angles[-k])]
            points = 1e2 * (np.array(chain) - leg.hip)
            axes.plot(points[:, 1], points[:, 0], points[:, 2], '-o', color=color, label=name)
        axes.plot(feet[:, 1], feet[:, 0], feet[:, 2], color=COLORS[2], label='path of the foot')
        axes.set_xlabel('outward [cm]', fontsize=8)
        axes.set_ylabel('forward [cm]', fontsize=8)
        axes.set_zlabel('up [cm]', fontsize=8)
        axes.tick_params(labelsize=6)
        axes.view_init(22.0, -60.0)
        axes.legend(fontsize=7)

    return Exhibit(
        'S1',
        'Fig. 8',
        'a step of one leg',
        rows,
        'Figures 8 to 10 are of the leg of table II. The gain is lost; it is '
        f'{DEFAULT_GAIN:g} 1/s here.',
        draw,
    )


def _angles_exhibit(times: Array, angles: Array) -> Exhibit:
    leg = load_robot('pukyong').legs[0]
    across = np.array([math.sin(_BETA), math.cos(_BETA), 0.0])
    wanted = leg.inverse(leg.forward(angles[0]) + STEP * across)
    shown = np.degrees(angles) * (1.0, -1.0, -1.0)
    rows = (
        *(
            same(f'theta{k + 1} at the start', there, float(shown[0, k]), 'deg', 0.05)
            for k, there in enumerate((0.0, 45.0, -135.0))
        ),
        at_most(
            'joints at the end, off those of the desired point by inverse kinematics',
            'to move one step',
            float(np.degrees(np.abs(angles[-1] - wanted)).max()),
            'deg',
            0.05,
            3,
        ),
    )

    def draw(figure: Figure) -> None:
        for k, axes in enumerate(panels(figure, 1, 3)):
            axes.plot(times, shown[:, k], color=COLORS[k])
            name_axes(axes, 'time [s]', 'angle [deg]' if k == 0 else '', f'theta{k + 1}')

    return Exhibit('S1', 'Fig. 9', 'joint angles in one step', rows, '', draw)


def _error_exhibit(times: Array, errors: Array) -> Exhibit:
    sizes = np.linalg.norm(errors, axis=1)
    rows = (
        same(
            'first error, each of two axes', 1.414, 1e2 * float(abs(errors[0, 0])), 'cm', 0.0005, 3
        ),
        at_most(
            f'error after {_SECONDS:g} s, of the first',
            'converges to zero',
            1e2 * float(sizes[-1] / sizes[0]),
            '%',
            1.0,
            2,
        ),
    )

    def draw(figure: Figure) -> None:
        (axes,) = panels(figure, 1, 1)
        for k, (name, style) in enumerate((('e_x', '-'), ('e_y', '--'), ('e_z', '-'))):
            axes.plot(times, 1e2 * errors[:, k], style, color=COLORS[k], label=name)
        axes.legend(fontsize=8)
        name_axes(axes, 'time [s]', 'error [cm]')

    return Exhibit('S1', 'Fig. 10', "error of the foot's place", rows, '', draw)
