"""
One generator for every gait: a cycle of body, feet and joints from gait and motion.

Body and footholds are planned in the cycle's ground frame (S4 sec. 1), feet are
brought into the body frame, and inverse kinematics gives the joints. Everything is
vectorised over the cycle's samples.

Cycles join: all feet are down at both ends, the body is on its course without sway, and
a cycle begins with the feet and the speed that the last one ended with.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, UnstableCycle
from quad_common.robot.exact_masses import ExactMasses
from quad_common.robot.leg_moments import LegCycle, leg_moments
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_course import body_course, give_way_to_legs
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.cycle import AT_REST, Cycle, CycleEnds
from quad_gait.cycle.foot_paths import FootPaths, rolled_paths
from quad_gait.cycle.footholds import (
    footholds_between,
    lean_on_curve,
    steady_ends,
    steady_footholds_of_orders,
)
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.part_check import check_own_parts
from quad_gait.cycle.schedule import legs_in_order, schedule_of, schedule_of_orders
from quad_gait.cycle.stability import stability_margin

Array = NDArray[np.float64]

FootTracking = Callable[[Robot, Array, Array, Array], tuple[Array, Array]]
"""Robot, times (n,), feet and their velocities in the body frame (n, 4, 3), to joint
positions and velocities (n, 4, 3)."""


_GRAVITY = 9.80665
"""[m/s^2]"""

_LEAN_ALLOWED = 0.5
"""Fraction of a lean into a curve by which the center of mass may be farther beside its feet."""

_REACTION_SAMPLES = 128
"""Instants of a cycle at which the legs' masses are looked at."""

_LITTLE = 0.02
"""Motion of such a cycle, as a fraction of the hips' height: what is found is in proportion."""

_NO_REACTION = np.zeros(2)

_MOST_GAITS = 64
"""Number of gaits of a robot of which it is kept: who tunes them makes many."""

_REACTIONS: WeakKeyDictionary[ExactMasses, dict[Gait, Array]] = WeakKeyDictionary()
"""What was found of the gaits of robots, by their masses, for as long as there are these."""


@dataclass(frozen=True)
class CycleOptions:
    """How cycles are computed, and what they must keep."""

    sample_period: float = 0.02
    """Longest time between samples, which are evenly spaced [s]."""
    least_margin: float = -np.inf
    """Stability margin below which a cycle is refused [m]."""
    track: FootTracking | None = None
    """Law that makes foot paths into joint motion; None: closed-form inverse kinematics."""


DEFAULT_OPTIONS = CycleOptions()
"""Fine samples, any margin, closed-form inverse kinematics."""


def generate_cycle(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    ends: CycleEnds = AT_REST,
    options: CycleOptions = DEFAULT_OPTIONS,
) -> Cycle:
    """
    Plan one cycle of a gait.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        The gait.
    motion : BodyMotion
        Where the body is to be at the end, and along which arc it goes there.
    ends : CycleEnds
        Feet and velocity at the start, and velocity at the end.
    options : CycleOptions
        Samples, least margin, and how foot paths become joint motion.

    Returns
    -------
    Cycle
        The cycle.

    Raises
    ------
    FootTargetUnreachable, JointLimitExceeded, PartsTooNear, UnstableCycle
        If the motion is too much for legs, joints, the robot's own parts or the margin.
    """
    schedule = schedule_of(gait, options.sample_period)
    footholds = footholds_between(robot, gait, motion, ends)
    course = body_course(gait, legs_in_order(gait), schedule, motion, ends, footholds)
    if np.any(reaction := leg_reaction(robot, gait)):
        course = give_way_to_legs(course, schedule, motion, ends, reaction)
    feet = rolled_paths(robot, schedule, footholds, course)
    positions, velocities = _joint_motion(robot, schedule.times, feet, options.track)
    chain = robot.stacked_legs.chain(positions)
    check_own_parts(robot, schedule.times, schedule.body_lift, positions, chain)
    center_of_mass = _center_of_mass(robot, positions, chain, course.pose)
    margin = stability_margin(center_of_mass, feet.in_ground[..., :2], schedule.in_contact)
    least = _least_margin(gait, ends, options)
    if np.min(margin) < least:
        raise UnstableCycle(float(np.min(margin)), least)
    return Cycle(
        gait,
        motion,
        ends.entry,
        ends.exit,
        times=schedule.times, body=course.pose,
        feet=feet.in_ground,
        in_contact=schedule.in_contact,
        joint_positions=positions,
        joint_velocities=velocities,
        end_feet=feet.in_body[-1],
        center_of_mass=center_of_mass, margin=margin,
    )  # fmt: skip


def _least_margin(gait: Gait, ends: CycleEnds, options: CycleOptions) -> float:
    """Return the margin that a cycle must keep [m]: less where the body leans into a curve."""
    lean = max(math.hypot(*lean_on_curve(gait, velocity)) for velocity in (ends.entry, ends.exit))
    return options.least_margin - _LEAN_ALLOWED * lean


def generate_steady_cycle(
    robot: Robot, gait: Gait, motion: BodyMotion, options: CycleOptions = DEFAULT_OPTIONS
) -> Cycle:
    """
    Plan a cycle in the midst of many equal ones.

    Parameters
    ----------
    robot, gait, motion, options
        As for :func:`generate_cycle`.

    Returns
    -------
    Cycle
        With the feet and the speed at its start that it also ends with. For S4's wave
        gait its start is the proper initial posture.
    """
    return generate_cycle(robot, gait, motion, steady_ends(robot, gait, motion), options)


def generate_largest_cycle(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    ends: CycleEnds = AT_REST,
    options: CycleOptions = DEFAULT_OPTIONS,
    accept: Callable[[Cycle], None] = lambda _: None,
) -> Cycle:
    """
    Plan a cycle, shortening its motion as far as the legs and the margin require.

    Parameters
    ----------
    robot, gait, motion, ends, options
        As for :func:`generate_cycle`.
    accept : callable, optional
        Raises a GaitError for a cycle that will not do after all.

    Returns
    -------
    Cycle
        The cycle; its :attr:`Cycle.motion` says what is left of the motion, and its
        :attr:`Cycle.limit` why.

    Raises
    ------
    GaitError
        If the robot cannot even come to rest, or, from rest, not even an eighth of the
        motion is possible.
    """
    rest = BodyMotion.during(ends.entry, (1.0 - gait.acceleration_fraction) * gait.cycle_period)
    fraction, limit = 1.0, ''
    while True:
        scaled = BodyMotion(
            fraction * motion.forward + (1.0 - fraction) * rest.forward,
            fraction * motion.left + (1.0 - fraction) * rest.left,
            fraction * motion.turn + (1.0 - fraction) * rest.turn,
        )
        slower = replace(ends, exit=ends.exit.scaled(fraction))
        try:
            cycle = generate_cycle(robot, gait, scaled, slower, options)
            accept(cycle)
            return replace(cycle, limit=limit)
        except GaitError as error:
            limit = limit or str(error)
            fraction -= 0.125
            if fraction < 0.0 or (fraction == 0.0 and not ends.entry):
                raise


def leg_reaction(robot: Robot, gait: Gait) -> Array:
    """
    Find by which wave a body on two feet makes up for the weight and inertia of its legs.

    A body of mass m with legs that move as they do in a slow steady walk is a pendulum
    c'' - omega^2 c = W / (m h), W being what the legs exert
    (:func:`~quad_common.robot.leg_moments.leg_moments`): its first wave over a support is
    answered by one of the body.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        The gait, fitted to it.

    Returns
    -------
    ndarray, shape (2,)
        Height of the wave, forward and to the left, as fractions of the body's motion in a cycle;
        0 for static gaits, for supports that are not half of the cycle, and where the masses and
        inertias of the legs are not known.
    """
    masses = robot.exact_masses
    if gait.pendulum_rate == 0.0 or masses is None or masses.inertias is None:
        return _NO_REACTION
    known = _REACTIONS.setdefault(masses, {})
    if gait not in known:
        if len(known) >= _MOST_GAITS:
            known.clear()
        known[gait] = _found_reaction(robot, masses, gait)
    return known[gait]


def _found_reaction(robot: Robot, masses: ExactMasses, gait: Gait) -> Array:
    halves = np.array([0.0, 0.5, 1.0]) * gait.cycle_period
    edges = gait.support_edges
    if len(edges) != len(halves) or not np.allclose(edges, halves, atol=1e-6):
        return _NO_REACTION
    little = _LITTLE * robot.hip_height
    reaction = np.empty(2)
    try:
        for side, motion in enumerate((BodyMotion(forward=little), BodyMotion(left=little))):
            # Whatever does not turn round with the motion is the same in place.
            there, back = (
                leg_moments(robot.stacked_legs, masses, _leg_cycle(robot, gait, own))[:, side]
                for own in (motion, motion.scaled(-1.0))
            )
            wave = np.fft.rfft((there - back) / (2.0 * little))[2]
            reaction[side] = -2.0 * wave.imag / len(there)
    except GaitError:
        return _NO_REACTION
    height = _GRAVITY / gait.pendulum_rate**2
    rate = 4.0 * np.pi / gait.cycle_period
    return -reaction / (robot.mass * height * (rate**2 + gait.pendulum_rate**2))


def _leg_cycle(robot: Robot, gait: Gait, motion: BodyMotion) -> LegCycle:
    """Move the legs as in the midst of many equal cycles, by a body that does not mind them."""
    schedule = schedule_of(gait, gait.cycle_period / _REACTION_SAMPLES)
    ends = steady_ends(robot, gait, motion)
    footholds = footholds_between(robot, gait, motion, ends)
    course = body_course(gait, legs_in_order(gait), schedule, motion, ends, footholds)
    feet = rolled_paths(robot, schedule, footholds, course)
    joints = robot.stacked_legs.inverse(feet.in_body)
    heights = robot.standing_height + schedule.body_lift
    return LegCycle(joints[:-1], heights[:-1], gait.cycle_period)


def margins_of_orders(
    robot: Robot, orders: Sequence[Gait], motion: BodyMotion, sample_period: float
) -> Array:
    """
    Find the least margins of steady cycles that differ in the order of their legs only.

    All at once, as arrays with an axis for the orders: 24 of them take little longer than two
    of :func:`generate_steady_cycle`.

    Parameters
    ----------
    robot : Robot
        The robot.
    orders : sequence of Gait
        A gait with its legs exchanged.
    motion : BodyMotion
        Motion of the body in a cycle.
    sample_period : float
        Longest time between samples [s].

    Returns
    -------
    ndarray, shape (len(orders),)
        Stability margins [m]; minus infinity where a joint would leave its range. Neither
        joints' speeds nor parts too near to one another are looked at.

    Raises
    ------
    FootTargetUnreachable, SingularPosture
        If one of the orders is too much for the legs.
    """
    schedule = schedule_of_orders(tuple(orders), sample_period)
    legs = np.stack([legs_in_order(order) for order in orders])
    footholds, ends = steady_footholds_of_orders(robot, orders, motion)
    course = body_course(orders[0], legs, schedule, motion, ends, footholds)
    feet = rolled_paths(robot, schedule, footholds, course)
    positions = robot.stacked_legs.inverse(feet.in_body)
    chain = robot.stacked_legs.chain(positions)
    center_of_mass = _center_of_mass(robot, positions, chain, course.pose)
    margin = stability_margin(center_of_mass, feet.in_ground[..., :2], schedule.in_contact)
    result: Array = np.where(robot.within_joint_limits(positions), margin, -np.inf).min(axis=1)
    return result


def _joint_motion(
    robot: Robot, times: Array, feet: FootPaths, track: FootTracking | None
) -> tuple[Array, Array]:
    """Make feet and their velocities in the body frame into joint angles and speeds."""
    if track is None:
        angles = robot.joint_angles(feet.in_body)
        speeds = robot.joint_velocities(angles, feet.velocities_in_body)
    else:
        angles, speeds = track(robot, times, feet.in_body, feet.velocities_in_body)
        robot.check_joint_limits(angles)
    robot.check_joint_speeds(speeds)
    return angles, speeds


def _center_of_mass(
    robot: Robot, joint_angles: Array, chain: tuple[Array, Array, Array], body: Array
) -> Array:
    """Project the center of mass to the ground, ground frame, shape (..., n, 2) [m]."""
    center = robot.center_of_mass_of(joint_angles, chain)
    cos, sin = np.cos(body[..., 2]), np.sin(body[..., 2])
    x, y = center[..., 0], center[..., 1]
    result: Array = body[..., :2] + np.stack([cos * x - sin * y, sin * x + cos * y], axis=-1)
    return result
