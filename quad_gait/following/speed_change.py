"""
How a dynamic gait may change its speed within a cycle, and leave its course.

On two feet the body is an inverted pendulum: its center of mass goes where it falls, and cannot be
pushed to either side of the line between the feet. Legs that shift it there tilt the body instead,
and lower the feet that swing on that side. Feet that drag along the ground throw the robot over.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Twist2D
from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.cycle.schedule import schedule_of

_SPEED_STEP = 0.4
"""Fraction of its largest speed that a dynamic gait gathers in one cycle."""

_INSTANTS = 100
"""Instants of a cycle at which is seen which feet stand."""


def gathered(wanted: Twist2D, entry: Twist2D, gear: MotionLimits) -> Twist2D:
    """
    Let a dynamic gait gather speed over a few cycles: it would rock otherwise.

    Parameters
    ----------
    wanted : Twist2D
        Velocity that is wanted at the end of a cycle.
    entry : Twist2D
        Velocity at its start.
    gear : MotionLimits
        The gait.

    Returns
    -------
    Twist2D
        Velocity to have at its end; the one that is wanted if the gait is static.
    """
    if gear.gait.is_static or not wanted:
        return wanted
    motion = BodyMotion.during(wanted, gear.period)
    largest = gear.largest_scale(motion) * gear.size(motion)
    gain = wanted.minus(entry)
    size = gear.size(BodyMotion.during(gain, gear.period))
    if size <= _SPEED_STEP * largest:
        return wanted
    return entry.plus(gain.scaled(_SPEED_STEP * largest / size))


def natural_motion(entry: Twist2D, exit: Twist2D, gait: Gait) -> BodyMotion:
    """Return the motion of a cycle in which a body goes from one velocity to another."""
    part, period = gait.acceleration_fraction, gait.cycle_period
    mean = entry.scaled(1.0 - part).plus(exit.scaled(part))
    return BodyMotion.during(mean, period)


def balanced_motion(
    motion: BodyMotion, ends: tuple[Twist2D, Twist2D], robot: Robot, gait: Gait
) -> BodyMotion:
    """
    Take from a cycle's motion what would tilt a body on two feet too far.

    Parameters
    ----------
    motion : BodyMotion
        Motion that is wanted.
    ends : pair of Twist2D
        Velocities at the start and at the end of the cycle.
    robot : Robot
        The robot.
    gait : Gait
        The gait.

    Returns
    -------
    BodyMotion
        The motion, with less of the translation that does not follow from these velocities if that
        is too much for a dynamic gait: no more than tilts swinging feet down to the ground.
        Turns about the middle of the feet tilt nothing.
    """
    if gait.pendulum_rate == 0.0:
        return motion
    natural = natural_motion(*ends, gait)
    beyond = motion.minus(natural)
    lowered = lowered_feet(beyond, robot, gait)
    if lowered <= gait.swing_height:
        return motion
    kept = gait.swing_height / lowered
    return BodyMotion(
        natural.forward + kept * beyond.forward, natural.left + kept * beyond.left, motion.turn
    )


def lowered_feet(motion: BodyMotion, robot: Robot, gait: Gait) -> float:
    """
    Say how far a shift of the body tilts swinging feet down, at most.

    While two feet stand the center of mass stays over the line between them. Half of the shift is
    planned by the next change of feet: the body then tilts by that over the height of the center
    of mass, about the line.

    Parameters
    ----------
    motion : BodyMotion
        What a cycle is to do beyond what follows from the velocities at its ends.
    robot : Robot
        The robot.
    gait : Gait
        The gait.

    Returns
    -------
    float
        Of the foot that is farthest from its line [m]; 0 if never just two feet stand.
    """
    height = float(robot.center_of_mass(robot.initial_joint_angles)[2] + robot.standing_height)
    shift, feet = np.array([motion.forward, motion.left]), robot.neutral_feet[:, :2]
    most = 0.0
    for standing in _pairs(gait):
        first, second = feet[standing]
        line = (second - first) / np.linalg.norm(second - first)
        normal = np.array([-line[1], line[0]])
        tilt = abs(float(normal @ shift)) / (2.0 * height)
        most = max(most, tilt * float(np.abs((feet - first) @ normal).max()))
    return most


@lru_cache(maxsize=32)
def _pairs(gait: Gait) -> tuple[NDArray[np.bool_], ...]:
    """List which feet stand, wherever there are two, each of shape (4,)."""
    down = np.unique(schedule_of(gait, gait.cycle_period / _INSTANTS).in_contact, axis=0)
    return tuple(down[down.sum(axis=1) == 2])
