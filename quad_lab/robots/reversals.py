"""
Trots whose direction is turned round at once, again and again.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.errors import QuadError
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import ENGINES, preferred

REVERSALS = {
    'turn': (BodyMotion(turn=1.0), BodyMotion(turn=-1.0)),
    'forward': (BodyMotion(forward=1.0), BodyMotion(forward=-1.0)),
    'left': (BodyMotion(left=1.0), BodyMotion(left=-1.0)),
    'curve': (BodyMotion(forward=1.0, turn=1.0), BodyMotion(forward=1.0, turn=-1.0)),
}
"""Motions, and what each of them is turned round into."""

_TIMES = 2
"""How often a robot goes there and back."""

_DURATION = 3.0
"""Time for which each direction is asked for [s]."""

_LEAST_MARGIN = 0.005
"""Stability margin of static gaits [m]."""


@dataclass(frozen=True)
class Reversal:
    """A robot that goes there and back in a trot."""

    robot: str
    """Name of the robot."""
    direction: str
    """One of :data:`REVERSALS`."""
    backend: str
    """Physics engine."""
    fraction: float
    """Part of the most that was asked for."""
    largest_tilt: float = math.nan
    """Largest tilt of the body at any time [rad]."""
    has_fallen: bool = False
    """Whether the robot fell."""
    problem: str = ''
    """Reason why it did not walk; empty if it did."""


def walk_there_and_back(robot: str, direction: str, backend: str, fraction: float) -> Reversal:
    """
    Let a robot trot in one direction, and turn that round at once.

    Parameters
    ----------
    robot : str
        Name or path of the robot.
    direction : str
        One of :data:`REVERSALS`.
    backend : str
        Physics engine.
    fraction : float
        Part of the most that the gait's limits allow, in each direction.

    Returns
    -------
    Reversal
        How it went.
    """
    loaded = load_robot(robot)
    gait = load_gait('trot', loaded)
    limits = MotionLimits(loaded, gait, _LEAST_MARGIN)
    with preferred(backend):
        loop = ClosedLoop(loaded, measuring_controller(loaded, gait, least_margin=_LEAST_MARGIN))
    try:
        loop.run(0.1)
        for motion in _TIMES * REVERSALS[direction]:
            asked = motion.scaled(fraction * limits.largest_scale(motion))
            loop.controller.set_twist(asked.rate(gait.cycle_period))
            loop.run(_DURATION, until=lambda: loop.record.has_fallen)
        problem = ''
    except QuadError as error:
        problem = str(error)
    finally:
        loop.close()
    largest = float(np.max(loop.record.tilts))
    return Reversal(robot, direction, backend, fraction, largest, loop.record.has_fallen, problem)


def reversal_bars(
    console: Console, robots: tuple[str, ...], quick: bool
) -> tuple[list[Criterion], list[dict[str, Any]]]:
    """
    Turn the direction of trots round at once: of imported robots, and of those that ship.

    Parameters
    ----------
    console : Console
        Where walks are shown.
    robots : tuple of str
        Imported robots.
    quick : bool
        These alone, at almost their most.
    """
    engines = [name for name, e in ENGINES.items() if e.has_world and e.is_installed]
    everybody = robots if quick else (*robots, *available_robots())
    jobs = [
        (robot, direction, engine, fraction)
        for robot in everybody
        for direction in REVERSALS
        for engine in engines
        for fraction in ((0.95,) if quick else (0.6, 0.95))
    ]
    found: list[Reversal] = []
    with worker_pool() as pool:
        for walk in pool.map(walk_there_and_back, *zip(*jobs)):
            found.append(walk)
            said = walk.problem or f'tilted by {math.degrees(walk.largest_tilt):.1f} deg at most'
            console.print(
                f'reversal {len(found)} of {len(jobs)}: {walk.robot} {walk.direction} '
                f'({walk.backend}): {said}' + (', FELL' if walk.has_fallen else '')
            )
    tilts = [math.degrees(walk.largest_tilt) for walk in found if not walk.problem]
    falls = sum(walk.has_fallen for walk in found)
    return [
        at_most(f'falls of trots that are turned round, of {len(found)}', falls, '', 0),
        figure('their largest tilt, median', float(np.median(tilts)) if tilts else None, 'deg'),
        figure('their largest tilt', max(tilts, default=None), 'deg'),
    ], [asdict(walk) for walk in found]
