"""
Says in words what is wrong with a gait on a robot, and what it can do.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.gait_generator import generate_steady_cycle
from quad_gait.cycle.joint_torques import torque_demand
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.part_check import crossing_feet

DIRECTIONS = {
    'forward': BodyMotion(forward=1.0),
    'backward': BodyMotion(forward=-1.0),
    'left': BodyMotion(left=1.0),
    'right': BodyMotion(left=-1.0),
    'turn left': BodyMotion(turn=1.0),
    'turn right': BodyMotion(turn=-1.0),
}
"""The motions that a gait is checked in."""

_USELESS = 0.005
"""A gait that gets no farther in a cycle than this fraction of the stride is no gait."""


@dataclass(frozen=True)
class MotionReport:
    """What a gait does in one direction, at its largest."""

    direction: str
    """A key of :data:`DIRECTIONS`."""
    largest: BodyMotion
    """Largest motion of one cycle."""
    limit: str
    """Reason why more is not possible."""
    least_margin: float
    """Least static stability margin of that cycle [m]."""
    order: tuple[str, ...]
    """Legs in the order of liftoff."""
    nearest_parts: tuple[str, str]
    """The robot's own parts with the least distance to spare in that cycle."""
    clearance: float
    """Distance between them [m]."""
    nearest_at: float
    """Time at which they are nearest, as a fraction of the cycle."""


@dataclass(frozen=True)
class GaitReport:
    """What a gait does on a robot, and what is wrong with it."""

    motions: tuple[MotionReport, ...]
    """Reports of the motions that were tried."""
    problems: tuple[str, ...]
    """Sentences; empty if nothing is wrong."""


def check_gait(robot: Robot, gait: Gait, least_margin: float = 0.0) -> GaitReport:
    """
    Try a gait on a robot in every direction.

    What a gait file by itself gets wrong, for example two feet in the air in a static
    gait, is refused when it is loaded; here come stability, reach, parts of the robot
    that would touch, and feet in each other's way.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        The gait, fitted to it.
    least_margin : float
        That cycles of a static gait must keep [m].

    Returns
    -------
    GaitReport
        What it can do, and sentences on what is wrong.
    """
    limits = MotionLimits(robot, gait, least_margin)
    motions: list[MotionReport] = []
    problems: list[str] = []
    tipping = _tipping_problem(limits, robot)
    if tipping:
        # No direction makes up for that.
        return GaitReport((), (tipping,))
    standstill = _standstill_problem(robot, gait, least_margin)
    if standstill:
        problems.append(standstill)
    for name, direction in DIRECTIONS.items():
        fraction = limits.largest_scale(direction)
        reason = limits.reason(direction)
        scale = robot.largest_turn if direction.turn else robot.largest_stride
        if fraction < _USELESS * scale:
            problems.append(f'{name}: hardly any motion is possible: {reason}')
            continue
        largest = direction.scaled(fraction)
        cycle = generate_steady_cycle(robot, limits.gait_for(direction), largest)
        nearest = robot.own_parts.nearest(cycle.joint_positions)
        motions.append(
            MotionReport(
                name,
                largest,
                reason,
                cycle.least_margin,
                tuple(swing.leg for swing in cycle.gait.swings),
                (nearest.pair.first, nearest.pair.second),
                nearest.clearance,
                float(cycle.times[nearest.sample]) / cycle.period,
            )
        )
        crossing = crossing_feet(robot, cycle)
        if crossing:
            problems.append(f'{name} at {_amount(largest)} a cycle: {crossing}')
    return GaitReport(tuple(motions), tuple(problems))


def _tipping_problem(limits: MotionLimits, robot: Robot) -> str:
    """Say why a body tips over the feet that a dynamic gait leaves down; empty if it does not."""
    gait, most = limits.gait, -limits.least_margin
    try:
        beside = -generate_steady_cycle(robot, gait, BodyMotion()).least_margin
    except GaitError:
        # Not even the legs can do it: that is said below.
        return ''
    if gait.is_static or beside <= most:
        return ''
    return (
        f'stepping on the spot the center of mass is {1e3 * beside:.0f} mm beside the feet that '
        f'stand; with more than {1e3 * most:.0f} mm the body tips over before other feet are '
        'down: pairs of feet that stand must be diagonal, as in the trot and the walk, not those '
        'of one side (a pace) or of one end (a bound)'
    )


def _standstill_problem(robot: Robot, gait: Gait, least_margin: float) -> str:
    """Say why not even stepping on the spot is possible; empty if it is."""
    try:
        cycle = generate_steady_cycle(robot, gait, BodyMotion())
    except GaitError as error:
        return f'stepping on the spot: {error}'
    if gait.is_static and cycle.least_margin < least_margin:
        # Without the sign of a zero.
        margin = round(1e3 * cycle.least_margin, 1) + 0.0
        return (
            f'stepping on the spot the least stability margin is {margin:.1f} mm; '
            f'it must be at least {1e3 * least_margin:.1f} mm: '
            f'the body must sway more, or the swings come in another order'
        )
    demand = torque_demand(robot, cycle)
    return f'stepping on the spot: {demand.sentence()}' if demand.is_too_much else ''


def _amount(motion: BodyMotion) -> str:
    if motion.turn:
        return f'{math.degrees(abs(motion.turn)):.1f} degrees'
    return f'{1e3 * math.hypot(motion.forward, motion.left):.0f} mm'
