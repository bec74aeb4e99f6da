"""
The papers' figures of gaits as criteria, measured in physics by :mod:`quad_lab.papers`.
"""

from __future__ import annotations

import math

import numpy as np
from rich.console import Console
from rich.table import Table

from quad_lab.closed_loop.calibration import measure_motion
from quad_lab.closed_loop.gait_measures import CircleWalk
from quad_lab.papers import s0_gaits, s1, s1_leg, s2_circles, s4_posture, s4_walks
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure


def figures_of_s0(quick: bool) -> list[Criterion]:
    """Leg lengths (fig. 16), heights (fig. 17), turning cycles, and ten metres of a line."""
    courses = s0_gaits.straight_courses()
    lengths = s0_gaits.standing(courses.lengths, courses)
    heights = s0_gaits.standing(np.abs(courses.heights - courses.heights[0, 0]), courses)
    length = 2.0 if quick else 10.0
    walked = s0_gaits.walk_line(length)
    bars = [
        at_most('S0: shortest leg, off 200.0 mm', abs(np.nanmin(lengths) - 200.0), 'mm', 0.05),
        at_most('S0: longest leg, off 215.7 mm', abs(np.nanmax(lengths) - 215.7), 'mm', 0.05),
        at_most('S0: change of the height of standing legs', np.nanmax(heights), 'mm', 1e-6),
        at_most('S0: cycle, off 5 s', abs(courses.times[-1] - 5.0), 's', 1e-9),
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
        at_most(
            "S0: 90 degrees in the paper's four cycles, off", s0_gaits.quarter_in_four(), 'deg', 1.0
        ),
    ]
    for degrees, cycles in ((45, 2), (-45, 2), (90, 3), (-90, 3)):
        if quick and degrees < 0:
            continue
        turned = s0_gaits.turn_on_the_spot(degrees)
        count = turned.cycles if turned.arrived else None
        bars.append(at_most(f'S0: turning cycles for {degrees} degrees', count, '', cycles))
    return bars


def figures_of_s1(quick: bool) -> list[Criterion]:
    """The step of one leg (fig. 10), and the crab gait along a potential's path (fig. 5)."""
    _, _, errors = s1_leg.leg_step()
    sizes = np.linalg.norm(errors, axis=1)
    points = s1.FIELD.descend((0.0, 0.0), s1_leg.STEP)
    walked = s1.walk_potential(points[:30] if quick else points)
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
    chosen = list(s2_circles.CIRCLES)
    if quick:
        chosen = [chosen[int(np.random.default_rng(seed).integers(len(chosen)))]]
    table = Table('radius [mm]', 'angle', 'loop', 'radius walked', 'steps', 'steps walked')
    worst = {loop: [0.0, 0.0] for loop in ('closed', 'open', 'closed, raw', 'open, raw')}
    noted = []
    for published in chosen:
        radius, degrees = published.radius, published.degrees
        circle = s2_circles.walk_circle(published, 1.0 if quick else 3.0)
        for loop, walk in circle.walks.items():
            worst[loop] = [max(a, b) for a, b in zip(worst[loop], circle.errors(loop))]
            table.add_row(
                f'{1e3 * radius:.0f}',
                f'{degrees:g} deg',
                loop,
                f'{1e3 * walk.radius:.1f}',
                f'{360.0 / degrees:g}',
                f'{walk.steps_per_lap:.2f}',
            )
            wanted = {'wanted_radius': radius, 'degrees': degrees, 'loop': loop}
            noted.append({**wanted, **_told(walk)})
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


def _told(walk: CircleWalk) -> dict[str, object]:
    """Return a walk without its path, for JSON."""
    return {name: value for name, value in vars(walk).items() if name != 'positions'}


def figures_of_s4(quick: bool) -> list[Criterion]:
    """The initial posture (fig. 8), 65 mm in 4 s, six spins, and the sway (fig. 9)."""
    robot, wave = s4_walks.wave()
    strides = s4_posture.longest_strides()
    forward = measure_motion(robot, wave, s4_walks.STRIDE, 4 if quick else 12)
    spin = measure_motion(robot, wave, s4_walks.SPIN, 6)
    duration = 20.0 if quick else 60.0
    with_sway, _ = s4_walks.tilting_walk(True, duration)
    without, _ = s4_walks.tilting_walk(False, duration)
    return [
        at_least(
            'S4: longest reachable stride by the initial posture',
            1e2 * (strides.proper / strides.without - 1.0),
            '% more',
            25.0,
        ),
        figure('S4: longest reachable stride', 1e3 * strides.proper, 'mm'),
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
