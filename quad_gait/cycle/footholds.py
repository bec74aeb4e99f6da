"""
Where the feet stand before and after the swings of a cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import STILL, Pose2D, Twist2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_motion import BodyMotion, smooth_progress
from quad_gait.cycle.cycle import CycleEnds
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.schedule import legs_in_order, setback

Array = NDArray[np.float64]


class Footholds(NamedTuple):
    """Centers of the standing feet before and after their swings, in the ground frame."""

    start: Array
    """Centers at the start of the cycle, shape (..., 4, 3) [m]."""
    target: Array
    """Centers at its end, shape (..., 4, 3) [m]."""


def steady_ends(robot: Robot, gait: Gait, motion: BodyMotion) -> CycleEnds:
    """
    Join a cycle to equal ones before and after it (S4 eq. 5).

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        The gait.
    motion : BodyMotion
        Motion of the body in each cycle.

    Returns
    -------
    CycleEnds
        Speeds and feet with which each begins and ends.
    """
    ends = _steady_speeds(gait, motion)
    feet = motion.end.inverse().transform(next_footholds(robot, gait, motion, ends))
    return CycleEnds(feet, ends.entry, ends.exit)


def footholds_between(robot: Robot, gait: Gait, motion: BodyMotion, ends: CycleEnds) -> Footholds:
    """
    Place the feet before and after the swings of a cycle.

    Parameters
    ----------
    robot, gait, motion, ends
        As for :func:`next_footholds`.

    Returns
    -------
    Footholds
        Centers of the feet in the ground frame.
    """
    to_ground = np.array([0.0, 0.0, robot.standing_height])
    start = robot.neutral_feet if ends.start_feet is None else ends.start_feet
    target = next_footholds(robot, gait, motion, ends)
    return Footholds(start + to_ground, target + to_ground)


def next_footholds(robot: Robot, gait: Gait, motion: BodyMotion, ends: CycleEnds) -> Array:
    """
    Choose where the feet are to stand next.

    In mid-stance a foot is where it is in the initial posture: so every foot uses its
    working range evenly, whatever the motion (S4 eq. 5 for straight walking). A pendulum
    that is to gain speed stands farther back, and one that walks a curve stands outside it.

    Parameters
    ----------
    robot : Robot
        The robot.
    gait : Gait
        The gait.
    motion : BodyMotion
        Motion of the body in the cycle.
    ends : CycleEnds
        Speeds at the cycle's ends.

    Returns
    -------
    ndarray, shape (4, 3)
        Feet in the ground frame at hip level [m].
    """
    stances = _stances(gait, motion, ends)
    if stances is None:
        return motion.end.transform(robot.neutral_feet)
    footholds = np.empty((len(LEGS), 3))
    for leg, stance in zip(legs_in_order(gait), stances):
        footholds[leg] = stance.transform(robot.neutral_feet[leg])
    return footholds


def steady_footholds_of_orders(
    robot: Robot, orders: Sequence[Gait], motion: BodyMotion
) -> tuple[Footholds, CycleEnds]:
    """
    Place the feet of steady cycles that differ in the order of their legs only.

    Parameters
    ----------
    robot : Robot
        The robot.
    orders : sequence of Gait
        A gait with its legs exchanged.
    motion : BodyMotion
        Motion of the body in a cycle.

    Returns
    -------
    tuple of Footholds and CycleEnds
        Footholds of shape (len(orders), 4, 3), and the speeds at the ends of every cycle.
    """
    gait = orders[0]
    ends = _steady_speeds(gait, motion)
    stances = _stances(gait, motion, ends)
    if stances is None:
        footholds = motion.end.transform(robot.neutral_feet)
        footholds = np.broadcast_to(footholds, (len(orders), *footholds.shape))
    else:
        # By turn and leg; each order picks which leg has which turn.
        legs = np.stack([legs_in_order(order) for order in orders])
        by_turn = np.stack([stance.transform(robot.neutral_feet) for stance in stances])
        footholds = by_turn[np.argsort(legs, axis=1), np.arange(len(LEGS))]
    to_ground = np.array([0.0, 0.0, robot.standing_height])
    start = motion.end.inverse().transform(footholds) + to_ground
    return Footholds(start, footholds + to_ground), ends


def _steady_speeds(gait: Gait, motion: BodyMotion) -> CycleEnds:
    """Begin and end a cycle at the pace of its motion, if the gait keeps its speed."""
    speed = motion.rate(gait.cycle_period) if gait.is_steady else STILL
    return CycleEnds(entry=speed, exit=speed)


def _stances(gait: Gait, motion: BodyMotion, ends: CycleEnds) -> list[Pose2D] | None:
    """
    Say where the body is in mid-stance of each foot's next stand, in the order of swings.

    None if all feet are to stand under the body's end pose.
    """
    if gait.footholds == 'initial_posture' or not ends.exit:
        return None
    period = gait.cycle_period
    onward = BodyMotion.during(ends.exit, period)
    gain = ends.exit.minus(ends.entry)
    gathered = BodyMotion.during(gain, gait.acceleration_fraction * period)
    before = motion.minus(gathered) if gait.pendulum_rate > 0.0 else motion
    set_back = BodyMotion.during(gain, -setback(gait)).end
    stances = []
    for swing in gait.swings:
        middle = (swing.touchdown + period + swing.liftoff) / 2.0
        if middle <= period:
            fraction = middle / period
            if gait.body_progress is not None:
                fraction = float(smooth_progress(gait.body_progress, np.array([middle]))[0][0])
            body = _pose(before, fraction) @ set_back
            velocity = ends.entry.plus(ends.exit).scaled(0.5)
        else:
            body = motion.end @ _pose(onward, middle / period - 1.0)
            velocity = ends.exit
        outward = lean_on_curve(gait, velocity)
        stances.append(body @ Pose2D(*outward, 0.0) if any(outward) else body)
    return stances


def lean_on_curve(gait: Gait, velocity: Twist2D) -> tuple[float, float]:
    """
    Say how far outside its curve a dynamic gait stands, so that its body leans into it.

    A pendulum over feet at p is accelerated by ``omega^2 (c - p)``, and a curve needs
    ``omega_z x v``: feet that stand under the body do not give it, and let it tilt outward.

    Parameters
    ----------
    gait : Gait
        The gait.
    velocity : Twist2D
        Mean velocity of the body.

    Returns
    -------
    tuple of float
        Distance forward and to the left [m]; 0 for static gaits, straight ways, and turns in
        place.
    """
    if gait.pendulum_rate == 0.0 or velocity.turn == 0.0:
        return 0.0, 0.0
    aside = velocity.turn / gait.pendulum_rate**2
    return aside * velocity.left, -aside * velocity.forward


def _pose(motion: BodyMotion, fraction: float) -> Pose2D:
    x, y, yaw = motion.pose_at(np.array(fraction))
    return Pose2D(float(x), float(y), float(yaw))
