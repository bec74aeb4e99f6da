"""
S1's figures 5 to 10 and tables I to III: a path along a potential, and one leg that steps.

What is lost: the place of the third obstacle, all radii, and the gain of the controller. Chosen
are radii of 0.5 m, a third obstacle at (4.3, 3.5), around which the path bends, and a gain of
4 1/s. Lengths are in centimetres, as in the paper.
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
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.gait_measures import PlanWalk, plan_walk
from quad_lab.papers.comparison import Exhibit, Part, at_least, at_most, same
from quad_lab.papers.drawing import COLORS, name_axes, panels
from quad_lab.papers.s1_leg import STEP, leg_exhibits
from quad_planner.potential.path_steps import steps_along
from quad_planner.potential.potential_field import PotentialField, RoundObstacle

Array = NDArray[np.float64]

EXHIBITS = (
    'Table I',
    'Fig. 5',
    'Fig. 6',
    'Fig. 7',
    'Table II',
    'Table III',
    'Fig. 8',
    'Fig. 9',
    'Fig. 10',
)
"""Those that show a result; the others are sketches."""


FIELD = PotentialField(
    (8.0, 8.0),
    (RoundObstacle(1.0, 3.0, 0.5), RoundObstacle(5.0, 7.0, 0.5), RoundObstacle(4.3, 3.5, 0.5)),
)
"""The potential of S1 fig. 5, with the constants of S1 table I."""


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
        'S1',
        'Fig. 5',
        'path along the potential',
        rows,
        "The third obstacle's place and all radii are lost, and chosen: (4.3, 3.5) and 0.5 m.",
        draw,
    )


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
            'distance of the minimum from the goal',
            'at the goal point',
            float(np.hypot(*(bottom - 8.0))),
            'm',
            0.05,
            3,
        ),
        at_least(
            'steps of the path along which the potential falls',
            'from high to low',
            1e2 * float(np.mean(np.diff(along) < 0.0)),
            '%',
            100.0,
            0,
        ),
    )

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
        'S1',
        'Fig. 6',
        'the potential',
        compared,
        'Within an obstacle the potential is infinite: each is one maximum.',
        draw,
    )


def _steps_exhibit(points: Array) -> Exhibit:
    ends, headings = steps_along(points, STEP)
    lengths = 1e2 * np.linalg.norm(np.diff(ends, axis=0), axis=1)
    compared = (
        same('shortest step but the last, r', 2.0, float(lengths[:-1].min()), 'cm', 0.0005, 3),
        same('longest step, r', 2.0, float(lengths.max()), 'cm', 0.0005, 3),
        at_most(
            'ends of steps, off the path',
            'calculated from the path',
            1e2 * max(distance_to_polyline((x, y), points) for x, y in ends[::10].tolist()),
            'cm',
            0.001,
            3,
        ),
    )

    def draw(figure: Figure) -> None:
        left, right = panels(figure, 1, 2)
        left.plot(*ends.T, '.', color=COLORS[0], markersize=2)
        left.set_aspect('equal')
        name_axes(left, 'x [m]', 'y [m]', f'{len(headings)} steps of {1e2 * STEP:g} cm')
        right.plot(np.degrees(headings), color=COLORS[1], linewidth=1.0)
        name_axes(right, 'step', 'direction beta [deg]')

    return Exhibit('S1', 'Fig. 7', 'the path cut into steps', compared, '', draw)


def walk_exhibits() -> list[Exhibit]:
    """Follow the path of figure 5 in the crab gait, in physics."""
    walked = walk_potential(FIELD.descend((0.0, 0.0), STEP))
    turned = math.degrees(float(np.abs(walked.record.heading).max()))
    far = 1e3 * walked.largest_distance if walked.arrived else math.nan
    rows = (
        at_most('distance from the path, walked in physics', 'follows the path', far, 'mm', 20.0),
        at_most(
            'change of heading, walked in physics',
            'the orientation is maintained',
            turned,
            'deg',
            2.0,
        ),
    )
    return [Exhibit('S1', 'Fig. 7', 'the path cut into steps', rows)]


PARTS: Sequence[Part] = (
    Part('S1', 'potential', field_exhibits),
    Part('S1', 'leg', leg_exhibits),
    Part('S1', 'crab walk', walk_exhibits, needs_physics=True),
)
"""What is measured, in the order of the figures."""
