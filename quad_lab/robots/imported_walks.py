"""
Walks of imported robots on their own links, in every gait and direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from quad_common.errors import QuadError
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.controllers import largest_speed
from quad_lab.closed_loop.gait_measures import steady_walk
from quad_sim.engines.registry import preferred

CURVES = {
    'curve': BodyMotion(1.0, 0.0, 1.0),
    'tight curve': BodyMotion(1.0, 0.0, 3.0),
    'backward curve': BodyMotion(-1.0, 0.0, 1.0),
    'crab curve': BodyMotion(0.0, 1.0, 1.0),
}
"""Curves that are walked, by metres and radians."""

DIRECTIONS = {
    'forward': BodyMotion(1.0, 0.0, 0.0),
    'backward': BodyMotion(-1.0, 0.0, 0.0),
    'left': BodyMotion(0.0, 1.0, 0.0),
    'turn': BodyMotion(0.0, 0.0, 1.0),
    **CURVES,
}
"""Directions that are walked."""

_LEAST_MARGIN = 0.005

_DURATIONS = {'trot': 12.0, 'walk': 12.0}
"""Duration of a walk [s]."""

_OTHERWISE = 24.0

_CYCLES_ON_CURVES = 12
"""Cycles of a walk on a curve, at least: corrections of the heading swing over ten of them, by up
to 6 % of what one turns, and the mean over fewer tells of those."""


@dataclass(frozen=True)
class ImportedWalk:
    """One robot in one gait and direction."""

    robot: str
    """Name of the robot."""
    gait: str
    """Name of the gait."""
    direction: str
    """One of :data:`DIRECTIONS`."""
    backend: str
    """Physics engine."""
    fraction: float
    """Part of the most that was asked for."""
    most: float
    """Most that the limits allow [m/s, or rad/s for turns in place]."""
    reason: str
    """What limits it."""
    error: float = math.nan
    """What was walked beside what was asked for, as a fraction less 1; on a curve of its length or
    its turn, whichever is farther off."""
    drift: float = math.nan
    """Sideways distance per metre."""
    tilt_rms: float = math.nan
    """Tilt of the body [rad]."""
    has_fallen: bool = False
    """Whether the robot fell."""
    problem: str = ''
    """Why it did not walk; empty if it did."""


def walk_imported(
    robot: str, gait: str, direction: str, backend: str, fraction: float
) -> ImportedWalk:
    """
    Let a robot walk.

    Parameters
    ----------
    robot : str
        Name or path of the robot.
    gait : str
        Name of the gait.
    direction : str
        One of :data:`DIRECTIONS`.
    backend : str
        Physics engine.
    fraction : float
        Part of the most that the gait's limits allow.
    """
    loaded = load_robot(robot)
    fitted = load_gait(gait, loaded)
    motion = DIRECTIONS[direction]
    most = largest_speed(loaded, fitted, motion, _LEAST_MARGIN)
    found = ImportedWalk(
        robot, gait, direction, backend, fraction, most=most.scale, reason=most.reason
    )
    if most.scale == 0.0:
        return _with(found, problem='the limits allow none')
    asked = motion.scaled(fraction * most.scale * most.period)
    try:
        with preferred(backend):
            duration = _DURATIONS.get(gait, _OTHERWISE)
            if direction in CURVES:
                duration = max(duration, _CYCLES_ON_CURVES * most.period)
            walk = steady_walk(loaded, fitted, motion, duration, asked, _LEAST_MARGIN)
    except QuadError as error:
        has_fallen = 'fallen' in str(error)
        return _with(found, problem=str(error), has_fallen=has_fallen)
    return _with(
        found,
        error=_error(walk.done, walk.asked),
        drift=abs(walk.drift),
        tilt_rms=walk.tilt_rms,
        has_fallen=walk.has_fallen,
    )


def _with(walk: ImportedWalk, **changes: object) -> ImportedWalk:
    return replace(walk, **changes)  # type: ignore[arg-type]


def _error(done: BodyMotion, asked: BodyMotion) -> float:
    """Return by which fraction a distance or a turn is off, whichever is farther."""
    errors = []
    if stride := math.hypot(asked.forward, asked.left):
        along = asked.forward * done.forward + asked.left * done.left
        errors.append(along / stride**2 - 1.0)
    if asked.turn:
        errors.append(done.turn / asked.turn - 1.0)
    return max(errors, key=abs)
