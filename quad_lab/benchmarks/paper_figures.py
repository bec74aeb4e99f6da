"""
The papers' figures of gaits, measured again, in physics.
"""

from __future__ import annotations

import math
from dataclasses import asdict, replace

import numpy as np
from rich.console import Console
from rich.table import Table

from quad_common.plan import Plan
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.foot_tracking import step_response
from quad_gait.cycle.gait import Gait, load_gait
from quad_gait.cycle.gait_check import DIRECTIONS
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.slip_compensation import SlipCompensation
from quad_lab.closed_loop.calibration import calibrate_motion, measure_motion
from quad_lab.closed_loop.gait_measures import (
    Circle,
    CircleWalk,
    circle_walk,
    plan_walk,
    steady_walk,
)
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_planner.potential.potential_field import PotentialField, RoundObstacle

CIRCLES = ((0.4, 18.0), (0.4, 10.0), (0.5, 18.0), (0.5, 10.0))
"""Radius [m] and angle of one cycle [deg] of S2's table IV."""


def figures_of_s0(quick: bool) -> list[Criterion]:
    """Leg lengths (fig. 16), heights (fig. 17), turning cycles, and ten metres of a line."""
    robot = load_robot('titan_viii')
    gait = schedule_of_s0()
    cycle = generate_cycle(without_balls(robot), gait, BodyMotion(forward=0.1077))
    hips = np.array([leg.hip for leg in robot.legs])
    feet = robot.foot_positions(cycle.joint_positions)
    arms = np.where(cycle.in_contact[..., None], feet - hips, np.nan)
    lengths = 1e3 * np.hypot(arms[..., 0], arms[..., 1])
    heights = 1e3 * np.nanmax(np.abs(arms[..., 2] - arms[0, 0, 2]))
    length = 2.0 if quick else 10.0
    line = Plan.through([(0.0, 0.0), (length, 0.0)], 0.0)
    walked = plan_walk(robot, load_gait('crawl', robot), line, 'in_place', 40.0 * length)
    bars = [
        at_most('S0: shortest leg, off 200.0 mm', abs(np.nanmin(lengths) - 200.0), 'mm', 0.05),
        at_most('S0: longest leg, off 215.7 mm', abs(np.nanmax(lengths) - 215.7), 'mm', 0.05),
        at_most('S0: change of the height of standing legs', float(heights), 'mm', 1e-6),
        at_most('S0: cycle, off 5 s', abs(gait.cycle_period - 5.0), 's', 1e-9),
        at_most(
            f'S0: distance from a line of {length:g} m at the largest stride',
            1e3 * walked.largest_distance if walked.arrived else None,
            'mm',
            30.0,
        ),
        figure(
            'S0: the same, without the sway of the body',
            1e3 * walked.largest_distance_at_ends,
            'mm',
        ),
    ]
    quarter = math.radians(90.0)
    in_four = measure_motion(robot, load_gait('turn', robot), BodyMotion(turn=quarter / 4.0), 4)
    bars.append(
        at_most(
            "S0: 90 degrees in the paper's four cycles, off",
            abs(math.degrees(4.0 * in_four.mean.turn - quarter)),
            'deg',
            1.0,
        )
    )
    for degrees, cycles in ((45, 2), (-45, 2), (90, 3), (-90, 3)):
        if quick and degrees < 0:
            continue
        turn = Plan.through([(0.0, 0.0)], math.radians(degrees))
        turned = plan_walk(robot, load_gait('crawl', robot), turn, 'in_place', 120.0)
        count = turned.cycles if turned.arrived else None
        bars.append(at_most(f'S0: turning cycles for {degrees} degrees', count, '', cycles))
    return bars


def schedule_of_s0() -> Gait:
    """Return S0's own straight gait: phases of a second, no sway, order 3-1-4-2."""
    crawl = load_gait('crawl')
    swings = tuple(
        replace(swing, liftoff=1.0 + k, touchdown=2.0 + k) for k, swing in enumerate(crawl.swings)
    )
    return replace(
        crawl,
        swings=swings,
        sway_weight=(0.0, 0.0),
        body_progress=((1.0, 0.0), (2.0, 0.25), (3.0, 0.5), (4.0, 0.75), (5.0, 1.0)),
    )


def without_balls(robot: Robot) -> Robot:
    """Return the robot on points in place of balls: the papers' feet do not roll."""
    return replace(robot, links={**robot.links, 'foot': replace(robot.links['foot'], radius=0.0)})


def figures_of_s1(quick: bool) -> list[Criterion]:
    """The step of one leg (fig. 10), and the crab gait along a potential's path (fig. 5)."""
    robot = load_robot('pukyong')
    leg = robot.legs[0]
    start = robot.initial_joint_angles[0]
    across = np.array([math.sin(math.pi / 4.0), math.cos(math.pi / 4.0), 0.0])
    _, _, errors = step_response(leg, start, leg.forward(start) + 0.02 * across, 4.0, 2.0, 0.01)
    sizes = np.linalg.norm(errors, axis=1)
    # The third obstacle's place and all radii are lost: any that leave a path.
    field = PotentialField(
        (8.0, 8.0),
        (RoundObstacle(1.0, 3.0, 0.5), RoundObstacle(5.0, 7.0, 0.5), RoundObstacle(4.5, 3.0, 0.5)),
    )
    points = field.descend((0.0, 0.0))
    if quick:
        points = points[:30]
    walked = plan_walk(
        robot, load_gait('crab', robot), Plan.through(points, 0.0), 'crab', 2000.0, 0.003
    )
    return [
        at_most('S1: error of the foot after 2 s', float(sizes[-1] / sizes[0]), 'of first', 0.01),
        at_most(
            'S1: crab gait, distance from the path of the potential',
            1e3 * walked.largest_distance if walked.arrived else None,
            'mm',
            20.0,
        ),
        figure(
            'S1: the same, without the sway of the body',
            1e3 * walked.largest_distance_at_ends,
            'mm',
        ),
    ]


def circles_of_s2(
    console: Console, quick: bool, seed: int, details: dict[str, object]
) -> list[Criterion]:
    """Table IV: radius and steps per lap, closed loop, and open loop after calibration."""
    robot = load_robot('cuhk')
    gait = load_gait('trot', robot)
    rows = list(CIRCLES)
    if quick:
        rows = [rows[int(np.random.default_rng(seed).integers(len(rows)))]]
    table = Table('radius [mm]', 'angle', 'loop', 'radius walked', 'steps', 'steps walked')
    worst = {loop: [0.0, 0.0] for loop in ('closed', 'open', 'closed, raw', 'open, raw')}
    noted = []
    for radius, degrees in rows:
        angle = math.radians(degrees)
        wanted = BodyMotion(forward=radius * angle, turn=angle)
        calibration, _, _ = calibrate_motion(robot, gait, wanted)
        compensation = SlipCompensation((calibration,))
        circle = Circle(radius, angle, 1.0 if quick else 3.0)
        walks: dict[str, CircleWalk] = {
            'closed': circle_walk(robot, gait, circle, True, compensation),
            'open': circle_walk(robot, gait, circle, False, compensation),
            'closed, raw': circle_walk(robot, gait, circle, True),
            'open, raw': circle_walk(robot, gait, circle, False),
        }
        for loop, walk in walks.items():
            steps = 360.0 / degrees
            off = (abs(walk.radius / radius - 1.0), abs(walk.steps_per_lap / steps - 1.0))
            if walk.has_fallen:
                off = (math.inf, math.inf)
            worst[loop] = [max(a, b) for a, b in zip(worst[loop], off)]
            table.add_row(
                f'{1e3 * radius:.0f}',
                f'{degrees:g} deg',
                loop,
                f'{1e3 * walk.radius:.1f}',
                f'{steps:g}',
                f'{walk.steps_per_lap:.2f}',
            )
            noted.append({'radius': radius, 'degrees': degrees, 'loop': loop, **asdict(walk)})
    console.print(table)
    details['circles'] = noted
    bars = []
    for loop, bar in (('closed', 1.0), ('open', 2.0)):
        what = f'{loop} loop, calibrated'
        bars.append(at_most(f'S2: radius, {what}, worst row', 1e2 * worst[loop][0], '%', bar))
        bars.append(
            at_most(f'S2: steps per lap, {what}, worst row', 1e2 * worst[loop][1], '%', bar)
        )
    for loop in ('closed', 'open'):
        for k, what in enumerate(('radius', 'steps per lap')):
            fraction = worst[f'{loop}, raw'][k]
            bars.append(figure(f'S2: {what}, {loop} loop, not calibrated', 1e2 * fraction, '%'))
    return bars


def figures_of_s4(quick: bool) -> list[Criterion]:
    """The initial posture (fig. 8), 65 mm in 4 s, six spins, and the sway (fig. 9)."""
    robot = load_robot('genibo')
    wave = load_gait('wave', robot)
    # Reach alone: how fast the joints of 2008 were is not told.
    tireless = replace(robot, velocity=1e3 * robot.velocity)
    strides = [
        MotionLimits(tireless, gait, reserve=1.0).largest_scale(BodyMotion(forward=1.0))
        for gait in (replace(wave, footholds='initial_posture'), wave)
    ]
    cycles = 4 if quick else 12
    forward = measure_motion(robot, wave, BodyMotion(forward=0.065), cycles)
    spin = measure_motion(robot, wave, BodyMotion(turn=math.radians(15.0)), 6)
    duration = 20.0 if quick else 60.0
    ahead, asked = DIRECTIONS['forward'], BodyMotion(forward=0.065)
    with_sway = steady_walk(robot, wave, ahead, duration, asked)
    stiff = replace(wave, sway_weight=(0.0, 0.0))
    without = steady_walk(robot, stiff, ahead, duration, asked, least_margin=-math.inf)
    return [
        at_least(
            'S4: longest reachable stride by the initial posture',
            1e2 * (strides[1] / strides[0] - 1.0),
            '% more',
            25.0,
        ),
        figure('S4: longest reachable stride', 1e3 * strides[1], 'mm'),
        at_most('S4: 65 mm in 4 s, off', 1e3 * abs(forward.mean.forward - 0.065), 'mm', 2.0),
        at_most(
            'S4: six spins of 15 degrees, off 90',
            abs(6.0 * math.degrees(spin.mean.turn) - 90.0),
            'deg',
            1.0,
        ),
        at_most(
            'S4: tilt rms with sway, of that without',
            with_sway.tilt_rms / without.tilt_rms,
            '',
            1.0 / 3.0,
        ),
        figure('S4: tilt rms with sway', math.degrees(with_sway.tilt_rms), 'deg'),
        at_least('S4: least measured margin with sway', 1e3 * with_sway.least_margin, 'mm', 0.0),
    ]
