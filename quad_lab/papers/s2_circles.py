"""
S2's circles: tables III and IV and figures 9 and 10, walked in physics.

The paper's lambda lets the direction of a foot's path be a little larger than geometry says; here
slip is compensated by asking for more of the whole motion, by a factor that calibration finds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.following.slip_compensation import Calibration, SlipCompensation
from quad_lab.closed_loop.calibration import calibrate_motion
from quad_lab.closed_loop.gait_measures import Circle, CircleWalk, circle_walk, fitted_circle
from quad_lab.papers.comparison import Exhibit, at_most, less
from quad_lab.papers.drawing import COLORS, draw_body, name_axes, panels

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PublishedCircle:
    """One circle of S2 tables III and IV."""

    radius: float
    """Radius R [m]."""
    degrees: float
    """Angle of one cycle, two delta [deg]."""
    short_step: float
    """Step of the inner feet, s_step [mm]."""
    long_step: float
    """Step of the outer feet, l_step [mm]."""
    angles: tuple[float, float]
    """Deflections of the feet's paths, inner and outer [deg]."""
    compensation: float
    """Compensation of slip, lambda."""
    walked_radius: float
    """Radius walked, R_r [mm]."""
    walked_steps: float
    """Steps of one lap walked, SN_r."""

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
    """Circle of the paper."""
    calibration: Calibration
    """Motion that is asked for so that the circle comes out."""
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


_MORE_ASKED = (
    'of another kind: the paper turns the paths of the feet, here more of the whole motion is '
    'asked for. Longer steps slip more, and those of 18 degrees are the longest'
)

_BELOW_A_MILLIMETRE = 'all four are below a millimetre, the last digit of the radii of the paper'

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
        ).because(_MORE_ASKED)
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
                less(
                    f'{published}, {loop} loop: steps of a lap, off', steps_there, 1e2 * steps, '%'
                ).because(_HALF_STEPS if steps_there < 0.05 else ''),
            ]
    return Exhibit(
        'S2',
        'Table IV',
        'circles walked',
        tuple(rows),
        "The paper's is an open loop with lambda tuned by hand; here after `quadwalk calibrate`.",
    )


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
    rows += [
        at_most(
            f'error of panel {many}, of that of panel {few}',
            f'{many} matches better than {few}',
            1e2 * off['abcd'.index(many)] / off['abcd'.index(few)],
            '%',
            100.0,
            0,
        ).because(_BELOW_A_MILLIMETRE)
        for many, few in ('ba', 'dc')
    ]
    note = 'Open loop, three laps; the circle that is wanted is dotted.'

    def draw(figure: Figure) -> None:
        figure.set_size_inches(6.4, 6.2)
        angle = np.linspace(0.0, 2.0 * math.pi, 120)
        for axes, circle, panel in zip(panels(figure, 2, 2), circles, 'abcd'):
            path = 1e3 * circle.walks['open'].positions
            center, _ = fitted_circle(path)
            r = 1e3 * circle.published.radius
            axes.plot(*(path - center).T, color=COLORS[0], linewidth=1.2)
            axes.plot(r * np.cos(angle), r * np.sin(angle), ':', color='0.2')
            axes.set_aspect('equal')
            name_axes(axes, 'x [mm]', 'y [mm]', f'{panel}: {circle.published}')

    return Exhibit('S2', 'Fig. 9', 'paths on circles', tuple(rows), note, draw)


def _snapshots(circle: WalkedCircle) -> Exhibit:
    path = 1e3 * circle.walks['closed'].positions
    path = path - fitted_circle(path)[0]
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
            'largest distance from the circle at any time',
            'precise motion',
            float(np.abs(distance - 400.0).max()),
            'mm',
            10.0,
        ),
    )

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
        'S2',
        'Fig. 10',
        'turning on a circle of 40 cm',
        rows,
        'Snapshots are drawn from above; they cannot be read off the paper.',
        draw,
    )
