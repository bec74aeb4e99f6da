"""
S2's tables I to IV and figures 8 to 10: a trot on circles.

Lengths are in millimetres and angles in degrees, as in the paper. The circles that are walked are
in :mod:`quad_lab.papers.s2_circles`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import CycleOptions, generate_steady_cycle
from quad_lab.papers.comparison import Exhibit, Part, Row, same
from quad_lab.papers.drawing import COLORS, name_axes, panels
from quad_lab.papers.s2_circles import CIRCLES, PublishedCircle, circle_exhibits

Array = NDArray[np.float64]

EXHIBITS = ('Table I', 'Table II', 'Fig. 8', 'Table III', 'Table IV', 'Fig. 9', 'Fig. 10')
"""Those that show a result; the others are sketches."""


def planned_circle(published: PublishedCircle, is_pendulum: bool = True) -> Cycle:
    """Plan a cycle in the midst of a circle, of a body that leans into it as a pendulum, or not."""
    robot = load_robot('cuhk')
    gait = load_gait('trot', robot)
    if not is_pendulum:
        gait = replace(gait, pendulum_rate=0.0)
    options = CycleOptions(gait.cycle_period / 400.0)
    return generate_steady_cycle(robot, gait, published.motion, options)


def planned_exhibits() -> list[Exhibit]:
    """Compare the robot, its kinematics, and steps as they are planned."""
    return [_sizes(), _kinematics(), _foot_path(), _steps_table()]


def _sizes() -> Exhibit:
    robot = load_robot('cuhk')
    leg = robot.legs[0]
    feet = 1e3 * robot.neutral_feet
    rows = (
        same('width W', 115.0, float(feet[0, 1] - feet[1, 1]), 'mm', 0.05),
        same('length L', 230.0, float(feet[0, 0] - feet[2, 0]), 'mm', 0.05),
        same('pendulum l1', 22.0, 1e3 * float(leg.radial_offset), 'mm', 0.05),
        same('thigh l2', 53.0, 1e3 * float(leg.thigh_length), 'mm', 0.05),
        same('calf l3', 42.0, 1e3 * float(leg.calf_length), 'mm', 0.05),
    )
    return Exhibit('S2', 'Table I', 'dimensions of the robot', rows)


_DH = ((0.0, 0.0), (math.pi / 2.0, 0.022), (0.0, 0.053), (0.0, 0.042))
"""alpha_(i-1) [rad] and a_(i-1) [m] of S2 table II; its d are zero."""


def _place_by_dh(angles: Array) -> Array:
    """Place the foot in the paper's leg frame by S2 table II and eq. 7."""
    pose = np.eye(4)
    for (alpha, a), theta in zip(_DH, (*angles, 0.0)):
        c, s, ca, sa = math.cos(theta), math.sin(theta), math.cos(alpha), math.sin(alpha)
        pose = pose @ np.array(
            [
                [c, -s, 0.0, a],
                [s * ca, c * ca, -sa, 0.0],
                [s * sa, c * sa, ca, 0.0],
                [0.0, 0.0, 0.0, 1.0],
            ]
        )
    place: Array = pose[:3, 3]
    return place


def _kinematics() -> Exhibit:
    postures = np.random.default_rng(0).uniform(-1.5, 1.5, (200, 3))
    paper = np.array([_place_by_dh(posture) for posture in postures])
    rows = []
    for leg in load_robot('cuhk').legs:
        # The paper's leg frame: x down, y to the left, z backward.
        forward, left, up = (leg.forward(postures) - leg.hip).T
        off = 1e3 * np.abs(np.stack([-up, left, -forward], axis=-1) - paper).max()
        rows.append(same(f'foot {leg.name}, largest difference', 0.0, float(off), 'mm', 5e-7, 6))
    return Exhibit(
        'S2',
        'Table II',
        'Denavit-Hartenberg parameters',
        tuple(rows),
        "Over 200 random postures, the foot by the table's parameters and by this code.",
    )


_SHORT_SWING = (
    'all feet are down for a moment at each change, so that the pair that lands bears the body '
    'before the other one leaves'
)


def _foot_path() -> Exhibit:
    robot = load_robot('cuhk')
    gait = load_gait('trot', robot)
    cycle = planned_circle(CIRCLES[0])
    foot = 1e3 * robot.foot_positions(cycle.joint_positions)[:, 0]
    down = cycle.in_contact[:, 0]
    swing = gait.swing('lf')
    level = float(foot[down, 2].max())
    lift = 1e3 * float(np.ptp(cycle.feet[:, 0, 2]))
    half_axis = 0.5 * float(np.linalg.norm(_swing_in_body(cycle, 0)))
    rows = (
        same('height of the swing, h_step', 8.0, lift, 'mm', 0.05, 2).because(
            f'over the ground; in the frame of the body {float(foot[:, 2].max()) - level:.1f} mm, '
            'as the standing feet lift it meanwhile'
        ),
        same(
            'depth of the support, rho h_step', 2.0, level - float(foot[:, 2].min()), 'mm', 0.05, 2
        ),
        same(
            'half of the path, of the step', 25.0, 1e5 * half_axis / CIRCLES[0].short_step, '%', 0.5
        ).because(_SHORT_SWING),
        same(
            'time of the swing over that of the support',
            1.0,
            (swing.touchdown - swing.liftoff) / (gait.duty_factor('lf') * gait.cycle_period),
            '',
            0.005,
            2,
        ).because(_SHORT_SWING),
    )

    def draw(figure: Figure) -> None:
        left, right = panels(figure, 1, 2)
        for part, color, name in ((~down, COLORS[0], 'swing'), (down, COLORS[1], 'support')):
            left.plot(foot[part, 0], foot[part, 2], '.', color=color, markersize=2, label=name)
            right.plot(foot[part, 0], foot[part, 1], '.', color=color, markersize=2)
        left.legend(fontsize=7)
        name_axes(left, 'forward [mm]', 'up [mm]', 'from the side')
        name_axes(right, 'forward [mm]', 'to the left [mm]', 'from above')
        right.set_aspect('equal', adjustable='datalim')

    return Exhibit(
        'S2',
        'Fig. 8',
        'path of the left front foot',
        rows,
        f'In the frame of the body, on the circle of {CIRCLES[0]}.',
        draw,
    )


def _swing_in_body(cycle: Cycle, leg: int) -> Array:
    """Return the vector from liftoff to touchdown of a foot, in the frame of the body [m]."""
    feet = load_robot('cuhk').foot_positions(cycle.joint_positions)[:, leg, :2]
    first, last = np.flatnonzero(~cycle.in_contact[:, leg])[[0, -1]]
    swing: Array = feet[last] - feet[first]
    return swing


def _deflections(circle: PublishedCircle, cycle: Cycle) -> list[float]:
    """Return the angles between the chords of the front feet and that of the body [deg]."""
    angles = []
    for leg in range(2):
        # A chord is square to the foot's ray from the circle's center in mid-stance, and the body
        # turns between mid-stance and the cycle's start.
        x, y = cycle.feet[0, leg, :2]
        ray = math.degrees(math.atan2(x, circle.radius - y))
        swing = cycle.gait.swing(LEGS[leg])
        middle = (swing.liftoff + swing.touchdown) / (2.0 * cycle.period)
        angles.append(ray - circle.degrees * (middle - 0.5))
    return angles


def _steps_table() -> Exhibit:
    gait = load_gait('trot', load_robot('cuhk'))
    rows: list[Row] = [
        same('h_step', 8.0, 1e3 * gait.swing_height, 'mm', 0.05),
        same('rho', 0.25, gait.support_depth, '', 0.005, 2),
    ]
    for circle in CIRCLES:
        cycle = planned_circle(circle, is_pendulum=False)
        steps = (cycle.feet[-1] - cycle.feet[0])[:2, :2]
        lengths = 1e3 * np.hypot(steps[:, 0], steps[:, 1])
        angles = _deflections(circle, cycle)
        rows += (
            same(f'{circle}: short step', circle.short_step, float(lengths[0]), 'mm', 0.06),
            same(f'{circle}: long step', circle.long_step, float(lengths[1]), 'mm', 0.06),
            *(
                same(
                    f"{circle}: theta{k + 1}, with the paper's lambda",
                    circle.angles[k],
                    circle.compensation * angles[k],
                    'deg',
                    0.1,
                )
                for k in range(2)
            ),
        )
    return Exhibit(
        'S2',
        'Table III',
        'steps and deflections',
        tuple(rows),
        'Steps are measured between footholds as the paper plans them, whose body does not lean '
        'into the circle; those that are walked are up to 0.5 % longer.',
    )


PARTS: Sequence[Part] = (
    Part('S2', 'planned steps', planned_exhibits),
    Part('S2', 'circles', circle_exhibits, needs_physics=True),
)
"""What is measured, in the order of the figures."""
