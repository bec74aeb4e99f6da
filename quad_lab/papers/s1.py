"""
S1's figures 5 to 10 and tables I to III: a path along a potential, and one leg that steps.

What is lost: the place of the third obstacle, all radii, and the gain of the controller. Chosen
are radii of 0.5 m, a third obstacle at (4.5, 3), which leaves a path, and a gain of 4 1/s. Lengths
are in centimetres, as in the paper.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.ndimage import label, minimum_filter

from quad_common.plan import Plan
from quad_common.planar_pose import distance_to_polyline
from quad_common.robot.leg_builds import LegLengths, LegPlace, yaw_pitch_pitch_leg
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.foot_tracking import DEFAULT_GAIN, step_response
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.gait_measures import PlanWalk, plan_walk
from quad_lab.papers.comparison import Exhibit, Part, at_least, at_most, same
from quad_lab.papers.drawing import COLORS, name_axes, panels
from quad_planner.potential.path_steps import steps_along
from quad_planner.potential.potential_field import PotentialField, RoundObstacle

Array = NDArray[np.float64]

EXHIBITS = (
    'Table I', 'Fig. 5', 'Fig. 6', 'Fig. 7', 'Table II', 'Table III', 'Fig. 8', 'Fig. 9', 'Fig. 10',
)  # fmt: skip
"""Those that show a result; the others are sketches."""

STEP = 0.02
"""Length of a step, r [m]."""

FIELD = PotentialField(
    (8.0, 8.0),
    (RoundObstacle(1.0, 3.0, 0.5), RoundObstacle(5.0, 7.0, 0.5), RoundObstacle(4.5, 3.0, 0.5)),
)
"""The potential of S1 fig. 5, with the constants of S1 table I."""

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


def walk_potential(points: Array) -> PlanWalk:
    """Follow a path (n, 2) [m] in the crab gait, in physics."""
    robot = load_robot('pukyong')
    plan = Plan.through([(float(x), float(y)) for x, y in points], 0.0)
    return plan_walk(robot, load_gait('crab', robot), plan, 'crab', 2000.0, 0.003)


def field_exhibits() -> list[Exhibit]:
    """Descend the potential of figures 5 to 7."""
    points = FIELD.descend((0.0, 0.0), STEP)
    return [_constants(), _path_exhibit(points), _potential_exhibit(points), _steps_exhibit(points)]


def _constants() -> Exhibit:
    rows = (
        same('eta', 0.1, FIELD.repulsion, '', 0.0),
        same('zeta', 1.0, FIELD.attraction, '', 0.0, 0),
        same('Q*', 1.5, FIELD.influence, 'm', 0.0),
        same('d*_goal', 10.0, FIELD.goal_distance, 'm', 0.0, 0),
    )
    return Exhibit('S1', 'Table I', 'constants of the potential', rows)


def _path_exhibit(points: Array) -> Exhibit:
    distances = [
        float(np.hypot(points[:, 0] - o.x, points[:, 1] - o.y).min()) - o.radius
        for o in FIELD.obstacles
    ]
    rows = (
        same('end, x', 8.0, float(points[-1, 0]), 'm', 0.05, 2),
        same('end, y', 8.0, float(points[-1, 1]), 'm', 0.05, 2),
        *(
            at_least(f'distance from the obstacle at ({o.x:g}, {o.y:g})', 'avoided', d, 'm', 0.0, 2)
            for o, d in zip(FIELD.obstacles, distances)
        ),
    )

    def draw(figure: Figure) -> None:
        figure.set_size_inches(4.2, 4.0)
        (axes,) = panels(figure, 1, 1)
        angle = np.linspace(0.0, 2.0 * math.pi, 60)
        for o in FIELD.obstacles:
            axes.fill(o.x + o.radius * np.cos(angle), o.y + o.radius * np.sin(angle), color='0.45')
        axes.plot(*points.T, color=COLORS[0], label='path')
        axes.plot(0.0, 0.0, 's', color=COLORS[2], label='start')
        axes.plot(8.0, 8.0, '*', color=COLORS[1], markersize=11, label='goal')
        axes.set_xlim(-0.5, 10.0)
        axes.set_ylim(-0.5, 10.0)
        axes.set_aspect('equal')
        axes.legend(fontsize=7)
        name_axes(axes, 'x [m]', 'y [m]')

    return Exhibit(
        'S1', 'Fig. 5', 'path along the potential', rows,
        "The third obstacle's place and all radii are lost, and chosen: (4.5, 3) and 0.5 m.", draw,
    )  # fmt: skip


def _potential_exhibit(points: Array) -> Exhibit:
    side = np.linspace(0.0, 10.0, 81, dtype=np.float64)
    values = np.array([[FIELD.potential(np.array([x, y])) for x in side] for y in side])
    _, peaks = label(np.isinf(values))
    low = (minimum_filter(values, size=3) == values) & np.isfinite(values)
    rows, columns = np.nonzero(low)
    bottom = side[[columns[0], rows[0]]]
    along = np.array([FIELD.potential(point) for point in points])
    compared = (
        same('maxima, at obstacles', 3, peaks, '', 0.0, 0),
        same('minima', 1, len(rows), '', 0.0, 0),
        at_most(
            'distance of the minimum from the goal', 'at the goal point',
            float(np.hypot(*(bottom - 8.0))), 'm', 0.05, 3,
        ),
        at_least(
            'steps of the path along which the potential falls', 'from high to low',
            1e2 * float(np.mean(np.diff(along) < 0.0)), '%', 100.0, 0,
        ),
    )  # fmt: skip

    def draw(figure: Figure) -> None:
        figure.set_size_inches(5.0, 4.0)
        axes = figure.add_subplot(projection='3d')
        x, y = np.meshgrid(side, side)
        axes.plot_surface(
            x, y, np.minimum(values, 90.0), cmap='viridis', linewidth=0, rstride=1, cstride=1
        )
        axes.plot(*points.T, along + 1.0, color=COLORS[1], linewidth=2.0, zorder=10)
        axes.view_init(48.0, 200.0)
        axes.set_box_aspect(None, zoom=0.85)
        axes.tick_params(labelsize=6)
        axes.set_xlabel('x [m]', fontsize=8)
        axes.set_ylabel('y [m]', fontsize=8)
        axes.set_title('potential, cut off at 90', fontsize=8)

    return Exhibit(
        'S1', 'Fig. 6', 'the potential', compared,
        'Within an obstacle the potential is infinite: each is one maximum.', draw,
    )  # fmt: skip


def _steps_exhibit(points: Array) -> Exhibit:
    ends, headings = steps_along(points, STEP)
    lengths = 1e2 * np.linalg.norm(np.diff(ends, axis=0), axis=1)
    compared = (
        same('shortest step but the last, r', 2.0, float(lengths[:-1].min()), 'cm', 0.0005, 3),
        same('longest step, r', 2.0, float(lengths.max()), 'cm', 0.0005, 3),
        at_most(
            'ends of steps, off the path', 'calculated from the path',
            1e2 * max(distance_to_polyline((x, y), points) for x, y in ends[::10].tolist()), 'cm', 0.001, 3,
        ),
    )  # fmt: skip

    def draw(figure: Figure) -> None:
        left, right = panels(figure, 1, 2)
        left.plot(*ends.T, '.', color=COLORS[0], markersize=2)
        left.set_aspect('equal')
        name_axes(left, 'x [m]', 'y [m]', f'{len(headings)} steps of {1e2 * STEP:g} cm')
        right.plot(np.degrees(headings), color=COLORS[1], linewidth=1.0)
        name_axes(right, 'step', 'direction beta [deg]')

    return Exhibit('S1', 'Fig. 7', 'the path cut into steps', compared, '', draw)


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
    half = yaw_pitch_pitch_leg(
        LegPlace('lf', np.zeros(3), 1), LegLengths(0.01, 0.0, 0.03, 0.05)
    )
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
            same(name, there, here, 'cm', 0.0006, 3, misprint if name.startswith('z') else '')
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
        'S1', 'Table III', 'initial values', rows,
        'These values belong to a leg half as long as that of table II, which is taken here.',
    )  # fmt: skip


def _step_exhibit(angles: Array) -> Exhibit:
    leg = load_robot('pukyong').legs[0]
    feet = 1e2 * (leg.forward(angles) - leg.hip)
    target = feet[0] + 1e2 * STEP * np.array([math.sin(_BETA), math.cos(_BETA), 0.0])
    rows = (
        at_most(
            'foot at the end, off the desired point', 'reaches the desired point',
            float(np.linalg.norm(feet[-1] - target)), 'cm', 0.02, 4,
        ),
        at_most(
            'change of height on the path', 'the desired point has the same z',
            float(np.abs(feet[:, 2] - feet[0, 2]).max()), 'cm', 0.02, 4,
        ),
    )  # fmt: skip

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
        'S1', 'Fig. 8', 'a step of one leg', rows,
        'Figures 8 to 10 are of the leg of table II. The gain is lost; it is '
        f'{DEFAULT_GAIN:g} 1/s here.', draw,
    )  # fmt: skip


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
            'to move one step', float(np.degrees(np.abs(angles[-1] - wanted)).max()), 'deg', 0.05, 3,
        ),
    )  # fmt: skip

    def draw(figure: Figure) -> None:
        for k, axes in enumerate(panels(figure, 1, 3)):
            axes.plot(times, shown[:, k], color=COLORS[k])
            name_axes(axes, 'time [s]', 'angle [deg]' if k == 0 else '', f'theta{k + 1}')

    return Exhibit('S1', 'Fig. 9', 'joint angles in one step', rows, '', draw)


def _error_exhibit(times: Array, errors: Array) -> Exhibit:
    sizes = np.linalg.norm(errors, axis=1)
    rows = (
        same('first error, each of two axes', 1.414, 1e2 * float(abs(errors[0, 0])), 'cm', 0.0005, 3),
        at_most(
            f'error after {_SECONDS:g} s, of the first', 'converges to zero',
            1e2 * float(sizes[-1] / sizes[0]), '%', 1.0, 2,
        ),
    )

    def draw(figure: Figure) -> None:
        (axes,) = panels(figure, 1, 1)
        for k, (name, style) in enumerate((('e_x', '-'), ('e_y', '--'), ('e_z', '-'))):
            axes.plot(times, 1e2 * errors[:, k], style, color=COLORS[k], label=name)
        axes.legend(fontsize=8)
        name_axes(axes, 'time [s]', 'error [cm]')

    return Exhibit('S1', 'Fig. 10', "error of the foot's place", rows, '', draw)


def walk_exhibits() -> list[Exhibit]:
    """Follow the path of figure 5 in the crab gait, in physics."""
    walked = walk_potential(FIELD.descend((0.0, 0.0), STEP))
    turned = math.degrees(float(np.abs(walked.record.heading).max()))
    far = 1e3 * walked.largest_distance if walked.arrived else math.nan
    rows = (
        at_most('distance from the path, walked in physics', 'follows the path', far, 'mm', 20.0),
        at_most(
            'change of heading, walked in physics', 'the orientation is maintained', turned, 'deg', 2.0
        ),
    )  # fmt: skip
    return [Exhibit('S1', 'Fig. 7', 'the path cut into steps', rows)]


PARTS: Sequence[Part] = (
    Part('S1', 'potential', field_exhibits),
    Part('S1', 'leg', leg_exhibits),
    Part('S1', 'crab walk', walk_exhibits, needs_physics=True),
)
"""What is measured, in the order of the figures."""
