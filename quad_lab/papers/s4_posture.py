"""
S4's figures 7 and 8: what the proper initial posture is good for.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from quad_common.errors import FootTargetUnreachable, GaitError
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.footholds import steady_ends
from quad_gait.cycle.gait import Gait, Swing
from quad_gait.cycle.gait_generator import generate_steady_cycle
from quad_gait.cycle.motion_limits import MotionLimits
from quad_lab.papers.comparison import (
    Exhibit,
    at_least,
    at_most,
    more,
    same,
    words,
)
from quad_lab.papers.drawing import (
    draw_legs,
    name_axes,
    panels,
)
from quad_lab.papers.s0_gaits import without_balls
from quad_lab.papers.s4_walks import STRIDE, wave, without_sway

Array = NDArray[np.float64]


def with_equal_feet(gait: Gait) -> Gait:
    """Return the gait whose feet begin alike under the body, as S4 fig. 7 (a) has them."""
    return replace(gait, footholds='initial_posture')


@dataclass(frozen=True)
class LongestStrides:
    """What legs reach (S4 fig. 8), however fast the joints must be."""

    without: float
    """Longest stride without the proper initial posture [m]."""
    proper: float
    """Longest stride with it [m]."""


def longest_strides() -> LongestStrides:
    """Find the longest strides; how fast the joints of 2008 were is not told."""
    robot, gait = wave()
    tireless = replace(robot, velocity=1e3 * robot.velocity)
    return LongestStrides(
        *(
            MotionLimits(tireless, one, reserve=1.0).largest_scale(BodyMotion(forward=1.0))
            for one in (with_equal_feet(gait), gait)
        )
    )


def _evenly_timed(gait: Gait) -> Gait:
    """Return the gait with swings that begin where S4 eq. 5 has them, (beta - 0.75) T first."""
    beta, period = gait.duty_factor('lf'), gait.cycle_period
    lift = [(beta - 0.75 + 0.25 * k) * period for k in range(4)]
    swings = [
        Swing(swing.leg, at, at + (1.0 - beta) * period - 1e-9)
        for swing, at in zip(gait.swings, lift)
    ]
    return replace(gait, swings=tuple(swings), sway_weight=(0.0, 0.0))


def _offsets(robot: Robot, gait: Gait) -> Array:
    """Return the feet at the start, ahead of their neutral places, in order of the swings [m]."""
    start = steady_ends(robot, gait, STRIDE).start_feet
    assert start is not None
    ahead = (start - robot.neutral_feet)[:, 0]
    order = [LEGS.index(swing.leg) for swing in gait.swings]
    result: Array = ahead[order]
    return result


def ranges_exhibit() -> Exhibit:
    """Compare the ranges in which feet work."""
    robot, gait = wave()
    timed = _evenly_timed(gait)
    beta = timed.duty_factor('lf')
    offsets = _offsets(robot, timed) / (beta * STRIDE.forward)
    published = (
        -(0.5 - (beta - 0.75) / beta),
        -(0.5 - (beta - 0.5) / beta),
        (beta - 0.25) / beta - 0.5,
        0.5,
    )
    proper, equal = (np.ptp(_centers(robot, one)) for one in (gait, with_equal_feet(gait)))
    rows = (
        *(
            same(
                f'foot of swing {k + 1} at the start, S4 eq. 5',
                1e2 * there,
                1e2 * float(here),
                '% of the stroke',
                0.5,
            )
            for k, (there, here) in enumerate(zip(published, offsets))
        ),
        at_most(
            'middles of the ranges, apart: proper posture',
            'even',
            1e3 * float(proper),
            'mm',
            0.1,
        ),
        at_least(
            'middles of the ranges, apart: feet begin alike',
            'different',
            1e3 * float(equal),
            'mm',
            1.0,
        ),
    )

    def draw(figure: Figure) -> None:
        for axes, one, title in zip(
            panels(figure, 1, 2, shared_y=True),
            (with_equal_feet(gait), gait),
            ('feet begin alike', 'proper initial posture'),
        ):
            ahead, times = _feet_ahead(robot, one)
            draw_legs(axes, times, 1e3 * ahead)
            name_axes(axes, 'time [s]', 'foot ahead of the shoulder [mm]', title)
        figure.axes[0].legend(fontsize=6)

    return Exhibit(
        'S4',
        'Fig. 7',
        'work ranges of the feet',
        rows,
        'Rows of S4 eq. 5 are with swings at its times; its lambda is what a foot moves while it '
        'stands, the stroke.',
        draw,
    )


def _feet_ahead(robot: Robot, gait: Gait) -> tuple[Array, Array]:
    """Return how far feet are ahead of their neutral places, (n, 4) [m], and times (n,) [s]."""
    # A ball rolls under its foot, which blurs the ranges by a millimetre or two.
    robot = without_balls(robot)
    cycle = generate_steady_cycle(robot, without_sway(gait), STRIDE)
    feet = robot.foot_positions(cycle.joint_positions)[..., 0]
    return feet - robot.neutral_feet[:, 0], cycle.times


def _centers(robot: Robot, gait: Gait) -> Array:
    """Return the middle of each foot's range [m]."""
    ahead, _ = _feet_ahead(robot, gait)
    middle: Array = (ahead.max(axis=0) + ahead.min(axis=0)) / 2.0
    return middle


def strides_exhibit() -> Exhibit:
    """Compare the longest strides."""
    robot, gait = wave()
    longest = longest_strides()
    tireless = replace(robot, velocity=1e3 * robot.velocity)
    at_limit = BodyMotion(forward=longest.without)
    limit = generate_steady_cycle(tireless, with_equal_feet(gait), at_limit)
    proper = generate_steady_cycle(tireless, gait, at_limit)
    bend = math.degrees(float(np.abs(proper.joint_positions[..., 2]).min()))
    chosen = 'lengths of links are lost; those that are chosen reach farther'
    rows = (
        more('longest stride, feet begin alike', 60.0, 1e3 * longest.without, 'mm', 0).because(
            chosen
        ),
        more('longest stride, proper initial posture', 75.0, 1e3 * longest.proper, 'mm', 0).because(
            chosen
        ),
        more('longer by', 25.0, 1e2 * (longest.proper / longest.without - 1.0), '%', 0),
        words(
            'what forbids more, feet begin alike',
            'singularity',
            _what_forbids(tireless, with_equal_feet(gait), at_limit.scaled(1.02)),
        ),
        at_least(
            'straightest knee at that stride, proper initial posture',
            'smooth',
            bend,
            'deg',
            10.0,
            0,
        ),
    )

    def draw(figure: Figure) -> None:
        for axes, cycle, title in zip(
            panels(figure, 1, 2, shared_y=True),
            (limit, proper),
            ('feet begin alike', 'proper posture'),
        ):
            _draw_knees(axes, cycle, f'{title}: stride of {1e3 * longest.without:.0f} mm')
        figure.axes[0].legend(fontsize=6)

    return Exhibit('S4', 'Fig. 8', 'longer strides by the initial posture', rows, '', draw)


def _what_forbids(robot: Robot, gait: Gait, motion: BodyMotion) -> str:
    """Say what forbids a motion: a leg that is straight is singular."""
    try:
        generate_steady_cycle(robot, gait, motion)
    except FootTargetUnreachable:
        return 'singularity'
    except GaitError as error:
        return str(error)
    return 'nothing'


def _draw_knees(axes: Axes, cycle: Cycle, title: str) -> None:
    draw_legs(axes, cycle.times, np.degrees(np.abs(cycle.joint_positions[..., 2])))
    name_axes(axes, 'time [s]', 'bend of the knee [deg]', title)
