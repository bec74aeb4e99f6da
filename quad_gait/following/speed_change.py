"""
How a dynamic gait may change its speed within a cycle, and leave its course.

On two feet the body is an inverted pendulum: its center of mass goes where it falls, and cannot be
pushed to either side of the line between the feet. Legs that shift it there tilt the body instead,
and lower the feet that swing on that side. Feet that drag along the ground throw the robot over.
"""

from __future__ import annotations

import math
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

_LOWERED = 0.4
"""Part of the height to which feet are lifted by which a body may be tilted on their side. With all
of it a1, whose body rocks as it stops, met the ground with them in every third walk, was thrown
back, and did the same again; with 0.6 it was tilted by up to 17 degrees, with this by 6."""

_INSTANTS = 100
"""Instants of a cycle at which is seen which feet stand."""

_GRIP = 0.8 * 9.80665
"""Deceleration that friction gives, by a coefficient of 0.8: dry floors, and simulated worlds'
[m/s^2]."""


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


def bearable_motion(
    motion: BodyMotion, ends: tuple[Twist2D, Twist2D], robot: Robot, gait: Gait
) -> BodyMotion:
    """Take from a cycle's motion what `balanced_motion` and `gripped_motion` take, as they do."""
    return gripped_motion(balanced_motion(motion, ends, robot, gait), ends, gait)


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
        is too much for a dynamic gait: no more than tilts swinging feet down by a part of their
        way to the ground.
        Turns about the middle of the feet tilt nothing.
    """
    if gait.pendulum_rate == 0.0:
        return motion
    natural = natural_motion(*ends, gait)
    lowered = lowered_feet(motion.minus(natural), robot, gait)
    bearable = _LOWERED * gait.swing_height
    if lowered <= bearable:
        return motion
    return _shortened(motion, natural, bearable / lowered)


def gripped_motion(motion: BodyMotion, ends: tuple[Twist2D, Twist2D], gait: Gait) -> BodyMotion:
    """
    Take from a cycle's motion what its last support could not brake: feet would slide.

    A robot that comes to rest may walk some way more in its last cycle. It gathers speed for that
    up to the last change of feet, and loses all of it over the two feet that stand then. A fast
    robot that slides on them comes to rest tilted forward.

    Parameters
    ----------
    motion : BodyMotion
        Motion that is wanted.
    ends : pair of Twist2D
        Velocities at the start and at the end of the cycle.
    gait : Gait
        The gait.

    Returns
    -------
    BodyMotion
        The motion, with less of the translation that does not follow from these velocities if a
        dynamic gait would lose more speed over its last support than friction takes, and more than
        it does without.
    """
    if gait.pendulum_rate == 0.0:
        return motion
    entry, exit = ends
    natural = natural_motion(entry, exit, gait)
    beyond = motion.minus(natural)
    pace, gain = _last_support(gait)
    lost = pace * np.array([entry.forward - exit.forward, entry.left - exit.left])
    more = gain * np.array([beyond.forward, beyond.left])
    braked = _GRIP * (gait.support_edges[-1] - gait.support_edges[-2])
    largest = max(braked, float(np.hypot(*lost)))
    if float(np.hypot(*(lost + more))) <= largest:
        return motion
    # |lost + kept more| = largest has one solution between 0 and 1.
    along, size = float(lost @ more), float(more @ more)
    room = largest**2 - float(lost @ lost)
    kept = min(1.0, max(0.0, (math.sqrt(max(along**2 + size * room, 0.0)) - along) / size))
    return _shortened(motion, natural, kept)


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
    height = robot.center_height
    shift, feet = np.array([motion.forward, motion.left]), robot.neutral_feet[:, :2]
    most = 0.0
    for standing in _pairs(gait):
        first, second = feet[standing]
        line = (second - first) / np.linalg.norm(second - first)
        normal = np.array([-line[1], line[0]])
        tilt = abs(float(normal @ shift)) / (2.0 * height)
        most = max(most, tilt * float(np.abs((feet - first) @ normal).max()))
    return most


def _shortened(motion: BodyMotion, natural: BodyMotion, kept: float) -> BodyMotion:
    """Keep a fraction of the translation beyond the natural one, and the turn."""
    beyond = motion.minus(natural)
    return BodyMotion(
        natural.forward + kept * beyond.forward, natural.left + kept * beyond.left, motion.turn
    )


@lru_cache(maxsize=32)
def _pairs(gait: Gait) -> tuple[NDArray[np.bool_], ...]:
    """List which feet stand, wherever there are two, each of shape (4,)."""
    down = np.unique(schedule_of(gait, gait.cycle_period / _INSTANTS).in_contact, axis=0)
    return tuple(down[down.sum(axis=1) == 2])


@lru_cache(maxsize=32)
def _last_support(gait: Gait) -> tuple[float, float]:
    """
    Say how fast the body is when the last support begins.

    Returns
    -------
    tuple of float
        Per mean speed at the cycle's start, and per distance beyond what follows from its ends
        [1/s].
    """
    schedule = schedule_of(gait, gait.cycle_period / _INSTANTS)
    change = int(np.searchsorted(schedule.times, gait.support_edges[-2] - 1e-9))
    pace = float(schedule.progress_rate[0])
    slower = schedule.entry_rate[change] + schedule.exit_rate[change]
    return pace * gait.cycle_period, float(schedule.progress_rate[change] - pace * slower)
