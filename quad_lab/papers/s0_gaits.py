"""
What S0's figures of gaits show, measured: legs over a planned cycle, and walks in physics.

The stride of figures 15 to 17 is that which gives figure 16's longest leg, 107.7 mm. Angles,
lengths and heights of legs are the paper's (S0 eqs. 11 to 14): theta1 from straight outward, theta2
and theta3 from the horizontal, heights downward from the hip.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.plan import Plan
from quad_common.robot.leg_builds import drive_angles
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import Cycle
from quad_gait.cycle.gait import Gait, load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_lab.closed_loop.calibration import measure_motion
from quad_lab.closed_loop.gait_measures import PlanWalk, plan_walk
from quad_lab.papers.comparison import Exhibit, Row, at_most, less

Array = NDArray[np.float64]

STRIDE = 0.1077
"""Stride of S0 figs. 15 to 17 [m]."""


@dataclass(frozen=True)
class LegCourses:
    """Legs over a planned cycle as the paper describes them, n samples of four legs."""

    times: Array
    """Times, shape (n,) [s]."""
    angles: Array
    """theta1, theta2 and theta3, shape (n, 4, 3) [deg]."""
    lengths: Array
    """Lengths from hip to foothold in the plan view, shape (n, 4) [mm]."""
    heights: Array
    """Heights from foot to hip, shape (n, 4) [mm]."""
    in_contact: NDArray[np.bool_]
    """Whether a foot is on the ground, shape (n, 4)."""


def schedule_of_s0(name: str = 'crawl') -> Gait:
    """Return S0's own schedule of a gait, crawl or turn: phases of a second, no sway."""
    gait = load_gait(name)
    swings = tuple(
        replace(swing, liftoff=1.0 + k, touchdown=2.0 + k) for k, swing in enumerate(gait.swings)
    )
    return replace(
        gait,
        swings=swings,
        sway_weight=(0.0, 0.0),
        body_progress=((1.0, 0.0), (2.0, 0.25), (3.0, 0.5), (4.0, 0.75), (5.0, 1.0)),
    )


def without_balls(robot: Robot) -> Robot:
    """Return the robot on points in place of balls: the papers' feet do not roll."""
    return replace(robot, links={**robot.links, 'foot': replace(robot.links['foot'], radius=0.0)})


def leg_courses(robot: Robot, cycle: Cycle) -> LegCourses:
    """
    Describe the legs over a cycle as S0 does.

    Parameters
    ----------
    robot : Robot
        TITAN-VIII, on points.
    cycle : Cycle
        Planned for it.

    Returns
    -------
    LegCourses
        In degrees and millimetres.
    """
    hips = np.array([leg.hip for leg in robot.legs])
    arms = robot.foot_positions(cycle.joint_positions) - hips
    # S0 has y forward and x to the right: tan(theta1) = forward / right (S0 eq. 13).
    theta1 = np.arctan(arms[..., 0] / -arms[..., 1])
    drives = drive_angles(cycle.joint_positions, knee_is_absolute=True)
    return LegCourses(
        cycle.times,
        np.degrees(np.stack([theta1, drives[..., 1], drives[..., 2]], axis=-1)),
        1e3 * np.hypot(arms[..., 0], arms[..., 1]),
        -1e3 * arms[..., 2],
        cycle.in_contact,
    )


def straight_courses() -> LegCourses:
    """Plan the straight cycle of S0 figs. 15 to 17, and describe its legs."""
    robot = without_balls(load_robot('titan_viii'))
    return leg_courses(robot, generate_cycle(robot, schedule_of_s0(), BodyMotion(forward=STRIDE)))


def standing(values: Array, courses: LegCourses) -> Array:
    """Return values of legs where they stand, and nan where they swing."""
    return np.where(courses.in_contact, values, np.nan)


def walk_line(length: float) -> PlanWalk:
    """Walk a straight line of a length [m] in physics, at the largest stride."""
    robot = load_robot('titan_viii')
    line = Plan.through([(0.0, 0.0), (length, 0.0)], 0.0)
    return plan_walk(robot, load_gait('crawl', robot), line, 'in_place', 40.0 * length)


def turn_on_the_spot(degrees: float) -> PlanWalk:
    """Turn by an angle [deg] in physics, in as few cycles as may be."""
    robot = load_robot('titan_viii')
    turn = Plan.through([(0.0, 0.0)], math.radians(degrees))
    return plan_walk(robot, load_gait('crawl', robot), turn, 'in_place', 120.0)


def quarter_in_four() -> float:
    """Turn in the paper's four cycles in physics; return how far off 90 degrees it ends [deg]."""
    robot = load_robot('titan_viii')
    quarter = math.radians(90.0)
    turned = measure_motion(robot, load_gait('turn', robot), BodyMotion(turn=quarter / 4.0), 4)
    return abs(math.degrees(4.0 * turned.mean.turn - quarter))


_LINE = 10.0
"""Length of the line that is walked [m]."""


def walk_exhibits() -> list[Exhibit]:
    """Walk straight ahead and turn in physics, as figures 10, 11 and 18 have it."""
    line = walk_line(_LINE)
    far = 1e3 * line.largest_distance_at_ends if line.arrived else math.nan
    straight = at_most(
        f'distance from a line of {_LINE:g} m walked in physics, at the ends of cycles',
        'straight-going',
        far,
        'mm',
        30.0,
    )
    published = ((45, 2), (-45, 2), (90, 4), (-90, 4))
    counts = [_cycles_for(degrees, there) for degrees, there in published]
    four = at_most(
        '90 degrees in four cycles in physics, off',
        'the desired angle',
        quarter_in_four(),
        'deg',
        1.0,
    )
    return [
        Exhibit('S0', 'Fig. 10', 'sequence of legs in the straight-going gait', (straight,)),
        Exhibit('S0', 'Fig. 18', 'length of the legs while turning by 45 degrees', (*counts, four)),
    ]


def _cycles_for(degrees: int, there: int) -> Row:
    turned = turn_on_the_spot(degrees)
    cycles = turned.cycles if turned.arrived else math.nan
    reason = '90 is less than three times 44' if abs(degrees) == 90 else ''
    return less(f'turning cycles for {degrees} degrees, in physics', there, cycles, '', 0).because(
        reason
    )
