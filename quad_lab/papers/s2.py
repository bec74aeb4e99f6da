"""
S2's tables I to IV and figures 8 to 10: a trot on circles.

Lengths are in millimetres and angles in degrees, as in the paper. Its lambda lets the direction of a
foot's path be a little larger than geometry says; here slip is compensated by asking for more
of the whole motion, by a factor that calibration finds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.robot.robot_build import LEGS
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import CycleOptions, generate_steady_cycle
from quad_gait.following.slip_compensation import Calibration, SlipCompensation
from quad_lab.closed_loop.calibration import calibrate_motion
from quad_lab.closed_loop.gait_measures import Circle, CircleWalk, circle_walk
from quad_lab.papers.comparison import Exhibit, Part, Row, at_most, less, same
from quad_lab.papers.drawing import COLORS, draw_body, name_axes, panels

Array = NDArray[np.float64]

EXHIBITS = ('Table I', 'Table II', 'Fig. 8', 'Table III', 'Table IV', 'Fig. 9', 'Fig. 10')
"""Those that show a result; the others are sketches."""


@dataclass(frozen=True)
class PublishedCircle:
    """One circle of S2 tables III and IV."""

    radius: float
    """R [m]."""
    degrees: float
    """Angle of one cycle, two delta [deg]."""
    short_step: float
    """s_step [mm]."""
    long_step: float
    """l_step [mm]."""
    angles: tuple[float, float]
    """Deflections of the feet's paths, inner and outer [deg]."""
    compensation: float
    """lambda"""
    walked_radius: float
    """R_r [mm]."""
    walked_steps: float
    """SN_r, steps of one lap."""

    @property
    def motion(self) -> BodyMotion:
        """Motion of the body in one cycle."""
        angle = math.radians(self.degrees)
        return BodyMotion(forward=self.radius * angle, turn=angle)

    def __str__(self) -> str:
        return f'{1e3 * self.radius:g} mm, {self.degrees:g} deg'


CIRCLES = (
    PublishedCircle(0.4, 18.0, 113.0, 147.6, (19.3, 14.7), 1.04, 409.0, 20.0),
    PublishedCircle(0.4, 10.0, 63.0, 82.2, (20.6, 15.7), 1.11, 406.0, 35.5),
    PublishedCircle(0.5, 18.0, 143.0, 178.1, (15.6, 12.5), 1.07, 515.0, 19.5),
    PublishedCircle(0.5, 10.0, 79.7, 99.2, (15.9, 12.7), 1.09, 505.0, 34.5),
)
"""Those of S2 tables III and IV, which are also figure 9's panels a to d."""


@dataclass(frozen=True)
class WalkedCircle:
    """One circle walked here, in physics."""

    published: PublishedCircle
    """The paper's."""
    calibration: Calibration
    """What is asked for, so that the circle comes out."""
    walks: dict[str, CircleWalk]
    """Walks by loop: closed and open with calibration, and both 'raw' without."""

    def errors(self, loop: str) -> tuple[float, float]:
        """Return by which fractions radius and steps per lap are off; infinite after a fall."""
        walk = self.walks[loop]
        if walk.has_fallen:
            return math.inf, math.inf
        steps = 360.0 / self.published.degrees
        return abs(walk.radius / self.published.radius - 1.0), abs(walk.steps_per_lap / steps - 1.0)


def walk_circle(published: PublishedCircle, laps: float, raw: bool = True) -> WalkedCircle:
    """
    Calibrate the trot for a circle, and walk it in physics.

    Parameters
    ----------
    published : PublishedCircle
        The circle.
    laps : float
        Laps of each walk.
    raw : bool
        Whether it is also walked without calibration.

    Returns
    -------
    WalkedCircle
        Closed loop and open loop.
    """
    robot = load_robot('cuhk')
    gait = load_gait('trot', robot)
    calibration, _, _ = calibrate_motion(robot, gait, published.motion)
    compensation = SlipCompensation((calibration,))
    circle = Circle(published.radius, published.motion.turn, laps)
    walks = {
        'closed': circle_walk(robot, gait, circle, True, compensation),
        'open': circle_walk(robot, gait, circle, False, compensation),
    }
    if raw:
        walks['closed, raw'] = circle_walk(robot, gait, circle, True)
        walks['open, raw'] = circle_walk(robot, gait, circle, False)
    return WalkedCircle(published, calibration, walks)


def planned_circle(published: PublishedCircle) -> Cycle:
    """Plan a cycle in the midst of a circle."""
    robot = load_robot('cuhk')
    gait = load_gait('trot', robot)
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
        rows.append(same(f'foot {leg.name}, largest difference', 0.0, float(off), 'mm', 5e-10, 9))
    return Exhibit(
        'S2', 'Table II', 'Denavit-Hartenberg parameters', tuple(rows),
        "Over 200 random postures, the foot by the table's parameters and by this code.",
    )  # fmt: skip


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
        same(
            'height of the swing, h_step', 8.0, lift, 'mm', 0.05, 2,
            f'over the ground; in the frame of the body {float(foot[:, 2].max()) - level:.1f} mm, as '
            'the standing feet lift it meanwhile',
        ),
        same('depth of the support, rho h_step', 2.0, level - float(foot[:, 2].min()), 'mm', 0.05, 2),
        same(
            'half of the path, of the step', 25.0, 1e5 * half_axis / CIRCLES[0].short_step, '%', 0.5,
            1, _SHORT_SWING,
        ),
        same(
            'time of the swing over that of the support', 1.0,
            (swing.touchdown - swing.liftoff) / (gait.duty_factor('lf') * gait.cycle_period), '',
            0.005, 2, _SHORT_SWING,
        ),
    )  # fmt: skip

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
        'S2', 'Fig. 8', 'path of the left front foot', rows,
        f'In the frame of the body, on the circle of {CIRCLES[0]}.', draw,
    )  # fmt: skip


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
    rows: list[Row] = []
    for circle in CIRCLES:
        cycle = planned_circle(circle)
        steps = (cycle.feet[-1] - cycle.feet[0])[:2, :2]
        lengths = 1e3 * np.hypot(steps[:, 0], steps[:, 1])
        angles = _deflections(circle, cycle)
        rows += (
            same(f'{circle}: short step', circle.short_step, float(lengths[0]), 'mm', 0.06),
            same(f'{circle}: long step', circle.long_step, float(lengths[1]), 'mm', 0.06),
            *(
                same(
                    f"{circle}: theta{k + 1}, with the paper's lambda",
                    circle.angles[k], circle.compensation * angles[k], 'deg', 0.1,
                )
                for k in range(2)
            ),
        )  # fmt: skip
    return Exhibit(
        'S2', 'Table III', 'steps and deflections', tuple(rows),
        'Steps are measured between planned footholds.',
    )  # fmt: skip


_MORE_ASKED = (
    'of another kind: the paper turns the paths of the feet, here more of the whole motion is asked '
    'for. With the longest steps the trot rocks, and its feet slip more'
)

_HALF_STEPS = 'the paper counts in half steps, 2.5 % of this lap: its zero is no more exact'


def circle_exhibits() -> list[Exhibit]:
    """Calibrate and walk the four circles in physics."""
    circles = [walk_circle(published, 3.0, raw=False) for published in CIRCLES]
    compensations = [
        less(
            f'{circle.published}: asked for more than is wanted',
            1e2 * (circle.published.compensation - 1.0),
            1e2 * abs(circle.calibration.asked.turn / circle.calibration.wanted.turn - 1.0),
            '%',
            1,
            _MORE_ASKED,
        )
        for circle in circles
    ]
    return [
        Exhibit('S2', 'Table III', 'steps and deflections', tuple(compensations)),
        _walked_table(circles),
        _paths_exhibit(circles),
        _snapshots(circles[1]),
    ]


def _walked_table(circles: list[WalkedCircle]) -> Exhibit:
    rows = []
    for circle in circles:
        published = circle.published
        radius_there = 1e2 * abs(published.walked_radius / (1e3 * published.radius) - 1.0)
        steps_there = 1e2 * abs(published.walked_steps * published.degrees / 360.0 - 1.0)
        for loop in ('open', 'closed'):
            radius, steps = circle.errors(loop)
            rows += [
                less(f'{published}, {loop} loop: radius, off', radius_there, 1e2 * radius, '%', 1),
                less(f'{published}, {loop} loop: steps of a lap, off', steps_there, 1e2 * steps, '%', 1,
                     _HALF_STEPS if steps_there < 0.05 else ''),
            ]  # fmt: skip
    return Exhibit(
        'S2', 'Table IV', 'circles walked', tuple(rows),
        "The paper's is an open loop with lambda tuned by hand; here after `quadwalk calibrate`.",
    )  # fmt: skip


def _paths_exhibit(circles: list[WalkedCircle]) -> Exhibit:
    off = [1e3 * abs(c.walks['open'].radius - c.published.radius) for c in circles]
    rows = [
        less(
            f'panel {panel}: radius walked, off {circle.published}',
            abs(circle.published.walked_radius - 1e3 * circle.published.radius),
            error,
            'mm',
            1,
        )
        for panel, circle, error in zip('abcd', circles, off)
    ]
    note = 'Open loop, three laps; the circle that is wanted is dotted.'

    def draw(figure: Figure) -> None:
        figure.set_size_inches(6.4, 6.2)
        angle = np.linspace(0.0, 2.0 * math.pi, 120)
        for axes, circle, panel in zip(panels(figure, 2, 2), circles, 'abcd'):
            path = 1e3 * circle.walks['open'].positions
            center = _center_of_circle(path)
            r = 1e3 * circle.published.radius
            axes.plot(*(path - center).T, color=COLORS[0], linewidth=1.2)
            axes.plot(r * np.cos(angle), r * np.sin(angle), ':', color='0.2')
            axes.set_aspect('equal')
            name_axes(axes, 'x [mm]', 'y [mm]', f'{panel}: {circle.published}')

    return Exhibit('S2', 'Fig. 9', 'paths on circles', tuple(rows), note, draw)


def _center_of_circle(path: Array) -> Array:
    matrix = np.column_stack([2.0 * path, np.ones(len(path))])
    center: Array = np.linalg.lstsq(matrix, np.sum(path**2, axis=1), rcond=None)[0][:2]
    return center


def _snapshots(circle: WalkedCircle) -> Exhibit:
    path = 1e3 * circle.walks['closed'].positions
    path = path - _center_of_circle(path)
    distance = np.hypot(*path.T)
    rows = (
        less(
            'radius, closed loop, off 40 cm',
            abs(circle.published.walked_radius - 400.0),
            1e3 * abs(circle.walks['closed'].radius - 0.4),
            'mm',
            1,
        ),
        at_most(
            'largest distance from the circle at any time', 'precise motion',
            float(np.abs(distance - 400.0).max()), 'mm', 10.0,
        ),
    )  # fmt: skip

    def draw(figure: Figure) -> None:
        figure.set_size_inches(4.6, 4.4)
        (axes,) = panels(figure, 1, 1)
        axes.plot(*path.T, color=COLORS[0], linewidth=1.2, label='path of the body')
        per_lap = max(len(path) // 3, 1)
        for k in np.linspace(0, per_lap, 8, endpoint=False).astype(int):
            step = path[min(k + 5, len(path) - 1)] - path[k]
            draw_body(axes, np.array([*path[k], math.atan2(step[1], step[0])]), 115.0, 57.5)
        axes.set_aspect('equal')
        axes.legend(fontsize=7)
        name_axes(axes, 'x [mm]', 'y [mm]')

    return Exhibit(
        'S2', 'Fig. 10', 'turning on a circle of 40 cm', rows,
        'Snapshots are drawn from above; they cannot be read off the paper.', draw,
    )  # fmt: skip


PARTS: Sequence[Part] = (
    Part('S2', 'planned steps', planned_exhibits),
    Part('S2', 'circles', circle_exhibits, needs_physics=True),
)
"""What is measured, in the order of the figures."""
