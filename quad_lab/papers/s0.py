"""
S0's figures of gaits, 10, 11 and 15 to 18: sequences of legs, joints and lengths over a cycle.

Figures 6 to 8 are in :mod:`quad_lab.papers.s0_paths`; what is measured here is in
:mod:`quad_lab.papers.s0_gaits`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait import Gait, load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.cycle.stability import stability_margin, support_polygon
from quad_lab.papers.comparison import (
    Exhibit,
    Part,
    Row,
    at_least,
    at_most,
    more,
    same,
    words,
)
from quad_lab.papers.drawing import (
    COLORS,
    LEG_NAMES,
    LEG_NUMBERS,
    draw_body,
    draw_legs,
    draw_stance,
    name_axes,
    panels,
)
from quad_lab.papers.s0_gaits import (
    STRIDE,
    LegCourses,
    leg_courses,
    schedule_of_s0,
    standing,
    straight_courses,
    walk_exhibits,
    without_balls,
)
from quad_lab.papers.s0_paths import path_exhibits

Array = NDArray[np.float64]

EXHIBITS = (
    'Fig. 6',
    'Fig. 7',
    'Fig. 8',
    'Fig. 10',
    'Fig. 11',
    'Fig. 15',
    'Fig. 16',
    'Fig. 17',
    'Fig. 18',
)
"""Those that show a result; the others are photographs, sketches and a flow chart."""


def cycle_exhibits() -> list[Exhibit]:
    """Plan the cycles of figures 10, 11 and 15 to 18."""
    courses = straight_courses()
    return [
        _straight_exhibit(),
        _turning_exhibit(),
        _joints_exhibit(courses),
        _lengths_exhibit(courses),
        _heights_exhibit(courses),
        _turning_lengths_exhibit(),
    ]


def _order(gait: Gait) -> str:
    return ' '.join(LEG_NUMBERS[swing.leg] for swing in gait.swings)


def _margin_rows(name: str, motion: BodyMotion) -> list[Row]:
    """Compare margins by the paper's schedule, and by the one that sways."""
    robot = load_robot('titan_viii')
    papers = generate_cycle(without_balls(robot), schedule_of_s0(name), motion)
    center = papers.body[:, :2]
    margin = stability_margin(center, papers.feet[..., :2], papers.in_contact).min()
    swaying = generate_cycle(robot, load_gait(name, robot), motion)
    return [
        at_least(
            "least margin of the body's center, the paper's schedule",
            'within the support polygon',
            1e3 * margin,
            'mm',
            -1e-6,
        ),
        more(
            'least margin of the center of mass, as the robot walks here',
            0.0,
            1e3 * swaying.least_margin,
            'mm',
        ).because("in the paper's schedule it is zero at one end of each phase"),
    ]


def _straight_exhibit() -> Exhibit:
    robot = without_balls(load_robot('titan_viii'))
    gait, motion = schedule_of_s0(), BodyMotion(forward=STRIDE)
    cycle = generate_cycle(robot, gait, motion)
    ends = [float(cycle.body[cycle.sample(2.0 + phase), 0]) for phase in range(4)]
    rows = [
        words('order of the legs', '3 1 4 2', _order(gait)),
        *(
            same(
                f'body after phase {k + 1}',
                25.0 * (k + 1),
                1e2 * x / STRIDE,
                '% of the stride',
                0.05,
            )
            for k, x in enumerate(ends)
        ),
        *_margin_rows('crawl', motion),
    ]
    return Exhibit(
        'S0',
        'Fig. 10',
        'sequence of legs in the straight-going gait',
        tuple(rows),
        '',
        partial(_draw_sequence, robot, cycle),
    )


def _turning_exhibit() -> Exhibit:
    robot = without_balls(load_robot('titan_viii'))
    gait, motion = schedule_of_s0('turn'), BodyMotion(turn=math.radians(22.5))
    cycle = generate_cycle(robot, gait, motion)
    moved = 1e3 * np.abs(cycle.end_feet - robot.neutral_feet).max()
    rows = [
        words('order of the legs to the left', '4 2 1 3', _order(gait)),
        words('order of the legs to the right', '3 1 2 4', _order(gait.mirrored())),
        at_most('feet at the end, off the initial posture', 'returned to it', moved, 'mm', 0.01),
        *_margin_rows('turn', motion),
    ]
    return Exhibit(
        'S0',
        'Fig. 11',
        'sequence of legs in the standstill-turning gait',
        tuple(rows),
        'A turn of 22.5 degrees, half of 45, is drawn.',
        partial(_draw_sequence, robot, cycle),
    )


def _draw_sequence(robot: Robot, cycle: Cycle, figure: Figure) -> None:
    figure.set_size_inches(7.4, 2.1)
    hips = np.abs(robot.legs[0].hip)
    for axes, time in zip(panels(figure, 1, 5, shared_y=True), (0.0, 1.5, 2.5, 3.5, 4.5)):
        k = cycle.sample(time)
        feet, down = cycle.feet[k, :, :2], cycle.in_contact[k]
        # The paper has its robot walk up the page.
        turned = np.stack([-feet[:, 1], feet[:, 0]], axis=1)
        draw_stance(axes, turned, down, support_polygon(turned, down))
        x, y, yaw = cycle.body[k]
        draw_body(axes, np.array([-y, x, yaw + math.pi / 2.0]), float(hips[0]), float(hips[1]))
        axes.plot(-y, x, '+', color='black', markersize=7)
        axes.set_xlim(-0.42, 0.42)
        axes.set_ylim(-0.36, 0.44)
        swinging = [LEG_NUMBERS[LEGS[leg]] for leg in np.flatnonzero(~down)]
        title = f'leg {swinging[0]} swings' if swinging else 'initial posture'
        axes.set_title(f'{title}\n{cycle.times[k]:.1f} s', fontsize=8)
    figure.supxlabel('to the right [m]', fontsize=8)
    figure.supylabel('forward [m]', fontsize=8)


def _joint_rows(courses: LegCourses) -> tuple[Row, ...]:
    times, theta = courses.times, courses.angles
    at = {second: int(np.argmin(np.abs(times - second))) for second in range(6)}
    leg_1 = theta[:, 0]
    rising = np.diff(leg_1[at[3] :, 0]) > -1e-9
    b, d, e, a = 200.0, 155.0, 45.0, 43.0
    t2, t3 = np.radians(theta[..., 1]), np.radians(theta[..., 2])
    wrong_length = np.abs(b * np.cos(t3) + d * np.cos(t2) + e - courses.lengths).max()
    wrong_height = np.abs(b * np.sin(t3) + d * np.sin(t2) + a - courses.heights).max()
    rate = (leg_1[at[2], 0] - leg_1[at[2] - 1, 0]) / (times[1] - times[0])
    return (
        same('a cycle', 5.0, float(times[-1]), 's', 0.05),
        at_most(
            'change of all joints, 0 to 1 s',
            'initial values',
            np.abs(theta[: at[1] + 1] - theta[0]).max(),
            'deg',
            0.005,
            2,
        ),
        at_least(
            'theta11 gained, 1 to 2 s', 'increased', leg_1[at[2], 0] - leg_1[at[1], 0], 'deg', 0.1
        ),
        at_most(
            'rate of theta11 just before 2 s', 'reached a stable angle', abs(rate), 'deg/s', 0.5, 2
        ).because(
            'the body goes on through the phases without a stop, and rests only at the ends of the '
            'cycle: to stop at each phase costs speed and jerks'
        ),
        at_least(
            'change of theta13, 1 to 2 s',
            'changed, as the leg became longer',
            abs(leg_1[at[2], 2] - leg_1[at[1], 2]),
            'deg',
            0.1,
            2,
        ),
        at_least(
            'samples from 3 to 5 s in which theta11 increases',
            'increased continuously',
            1e2 * rising.mean(),
            '%',
            100.0,
        ),
        at_most(
            'all joints at the end, off their initial values',
            'came back to the initial angle',
            np.abs(theta[-1] - theta[0]).max(),
            'deg',
            0.005,
            2,
        ),
        at_most(
            'lengths by S0 eq. 11 of these angles, off', 'eq. 11', wrong_length, 'mm', 0.005, 2
        ),
        at_most(
            'heights by S0 eq. 11 of these angles, off', 'eq. 11', wrong_height, 'mm', 0.005, 2
        ),
    )


def _joints_exhibit(courses: LegCourses) -> Exhibit:
    times, theta = courses.times, courses.angles

    def draw(figure: Figure) -> None:
        for k, axes in enumerate(panels(figure, 1, 3)):
            draw_legs(axes, times, theta[..., k])
            name_axes(axes, 'time [s]', 'angle [deg]' if k == 0 else '', f'theta{k + 1}')
        named = figure.axes[0].get_legend_handles_labels()
        figure.legend(*named, fontsize=7, ncols=4, loc='outside lower center')

    return Exhibit(
        'S0',
        'Fig. 15',
        'joint angles over a straight cycle',
        _joint_rows(courses),
        'The curves are lost; their course is told.',
        draw,
    )


def _lengths_exhibit(courses: LegCourses) -> Exhibit:
    lengths = standing(courses.lengths, courses)
    rows = (
        same('shortest leg', 200.0, float(np.nanmin(lengths)), 'mm', 0.05),
        same('longest leg', 215.7, float(np.nanmax(lengths)), 'mm', 0.05),
    )

    def draw(figure: Figure) -> None:
        (axes,) = panels(figure, 1, 1)
        draw_legs(axes, courses.times, courses.lengths)
        name_axes(axes, 'time [s]', 'length [mm]')
        axes.axhline(215.7, color='0.5', linewidth=0.8, linestyle=':', label="the paper's most")
        axes.legend(fontsize=7)

    return Exhibit(
        'S0',
        'Fig. 16',
        'length of the legs over a straight cycle',
        rows,
        'Rows are of legs that stand.',
        draw,
    )


def _heights_exhibit(courses: LegCourses) -> Exhibit:
    heights = courses.heights
    level = standing(heights, courses)
    rows = (
        same('height in the initial posture, H0', 243.0, float(heights[0, 0]), 'mm', 0.05),
        same(
            'difference of heights, first and last of the cycle',
            0.0,
            float(np.abs(heights[-1] - heights[0]).max()),
            'mm',
            0.005,
            2,
        ),
        at_most(
            'change of the height of standing legs',
            'without changing the height',
            float(np.nanmax(np.abs(level - heights[0, 0]))),
            'mm',
            0.005,
            2,
        ),
    )

    def draw(figure: Figure) -> None:
        (axes,) = panels(figure, 1, 1)
        draw_legs(axes, courses.times, heights)
        name_axes(axes, 'time [s]', 'height from foot to hip [mm]')
        axes.legend(fontsize=7)

    return Exhibit(
        'S0',
        'Fig. 17',
        'height of the legs over a straight cycle',
        rows,
        'How high a foot is lifted is lost; it is 50 mm here.',
        draw,
    )


def _turning_lengths_exhibit() -> Exhibit:
    robot = without_balls(load_robot('titan_viii'))
    motion = BodyMotion(turn=math.radians(22.5))
    courses = leg_courses(robot, generate_cycle(robot, schedule_of_s0('turn'), motion))
    lengths = standing(courses.lengths, courses)
    stretch = 1e3 * (robot.largest_stride**2 + robot.stance_reach**2) ** 0.5
    rows = (
        same('length at the start, L0', 200.0, float(lengths[0, 0]), 'mm', 0.05),
        at_most(
            'lengths at the end, off those at the start',
            'returned to the initial posture',
            float(np.abs(courses.lengths[-1] - courses.lengths[0]).max()),
            'mm',
            0.05,
        ),
        at_most(
            'longest leg',
            f'at most the stretch of S0 eq. 16, {stretch:.1f} mm',
            float(np.nanmax(lengths)),
            'mm',
            stretch,
        ),
        same('largest turn of a cycle', 44.0, math.degrees(robot.largest_turn), 'deg', 0.5),
    )

    def draw(figure: Figure) -> None:
        (axes,) = panels(figure, 1, 1)
        for k, name in enumerate(LEG_NAMES):
            axes.plot(courses.times, courses.lengths[:, k], color=COLORS[k], label=name)
        name_axes(axes, 'time [s]', 'length [mm]', 'first of two cycles for 45 degrees')
        axes.legend(fontsize=7)

    return Exhibit(
        'S0',
        'Fig. 18',
        'length of the legs while turning by 45 degrees',
        rows,
        'The curves are lost.',
        draw,
    )


PARTS: Sequence[Part] = (
    Part('S0', 'paths', path_exhibits),
    Part('S0', 'cycles', cycle_exhibits),
    Part('S0', 'walks', walk_exhibits, needs_physics=True),
)
"""What is measured, in the order of the figures."""
