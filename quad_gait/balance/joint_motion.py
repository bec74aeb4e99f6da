"""
From the feet of knots to joint motion that the drives can follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_common.errors import GaitError, TrajectoryError
from quad_common.robot.robot import Robot
from quad_common.trajectory.trajectory_gate import VELOCITY_TOLERANCE, JointLimits

Array = NDArray[np.float64]

_NEARER = (1.0, 0.85, 0.7, 0.5, 0.3, 0.0)
"""Fractions of the way from its neutral place at which a foot is put that cannot be farther."""

_ROOM = 0.02
"""Distance from the ends of their ranges that joints keep where they are slowed [rad]."""


@dataclass(frozen=True)
class JointMotion:
    """Positions and velocities of the joints at m knots."""

    times: Array
    """Times of the knots, shape (m,) [s]."""
    positions: Array
    """Positions, shape (m, 4, 3) [rad]."""
    speeds: Array
    """Velocities, shape (m, 4, 3) [rad/s]."""
    is_slowed: bool = False
    """Whether joints come to where the feet are wanted later than wanted."""

    def at(self, time: float) -> tuple[Array, Array]:
        """Return positions and velocities at a time within it [s], each (4, 3) [rad], [rad/s]."""
        position, speed = np.empty(self.positions.shape[1:]), np.empty(self.speeds.shape[1:])
        _cubic_at(self.times, self.positions, self.speeds, time, position, speed)
        return position, speed

    def at_or_after(self, time: float) -> tuple[Array, Array]:
        """Return the same at a time from its begin on [s]; at rest after its end."""
        if time >= self.times[-1]:
            return self.positions[-1], np.zeros_like(self.positions[-1])
        return self.at(time)


class Limits(NamedTuple):
    """What joints are able to do, as compiled code takes it."""

    lower: Array
    """Least positions, shape (4, 3) [rad]."""
    upper: Array
    """Largest positions, shape (4, 3) [rad]."""
    fastest: Array
    """Largest speeds, shape (4, 3) [rad/s]."""


class JointMotionPlanner:
    """
    Chooses joint motion within the limits of one robot.

    Where the feet's own motion would leave a range the feet are put nearer, and where it would be
    too fast for a joint, that joint follows as fast as it can. The others of its leg do not wait
    for it: a thigh that has to lift a foot off the ground must not keep its hip from swinging it.

    Parameters
    ----------
    robot : Robot
        The robot.
    speed_fraction : float
        Fraction of their largest speeds that joints use at most where they are slowed.
    """

    def __init__(self, robot: Robot, speed_fraction: float) -> None:
        self._robot = robot
        self._limits = JointLimits.of(robot)
        fastest = np.array(np.broadcast_to(robot.velocity, robot.lower.shape))
        self._within = Limits(robot.lower, robot.upper, fastest)
        self._slowest = self._within._replace(fastest=speed_fraction * fastest)

    def warm_up(self) -> None:
        """Compile what a hurry needs, or read its code: no decision is to wait for that."""
        rest, times = np.zeros((2, 4, 3)), np.array([0.0, 1.0])
        keep_up(rest, rest.copy(), times, 1, self._slowest)
        JointMotion(times, rest, rest.copy()).at(0.5)
        is_within(rest, rest, times, 0, self._within)

    def go_on(self, given: JointMotion, places: Array, times: Array) -> JointMotion | None:
        """
        Go on after what was given out.

        Parameters
        ----------
        given : JointMotion
            What holds; the new motion leaves it at its last knot.
        places : ndarray, shape (m, 4, 3)
            The feet after it, in the body's axes [m].
        times : ndarray, shape (m,)
            Their times [s].

        Returns
        -------
        JointMotion or None
            Both together; None if the joints cannot do it, and what was given out is to go on.
        """
        wanted = self._inverse(places)
        held = len(given.times)
        all_times = np.concatenate([given.times, times])
        positions = np.concatenate([given.positions, wanted])
        speeds = smooth_speeds(all_times, positions)
        speeds[:held], speeds[-1] = given.speeds, 0.0
        if self._is_possible(all_times, positions, speeds, held):
            return JointMotion(all_times, positions, speeds)
        lower, upper, _ = self._slowest
        positions[held:] = np.clip(wanted, lower + _ROOM, upper - _ROOM)
        keep_up(positions, speeds, all_times, held, self._slowest)
        if self._is_possible(all_times, positions, speeds, held):
            return JointMotion(all_times, positions, speeds, is_slowed=True)
        return None

    def _is_possible(self, times: Array, positions: Array, speeds: Array, held: int) -> bool:
        first = held - 1
        if is_within(positions, speeds, times, first, self._within):
            return True
        shape = (len(times) - first, 12)
        try:
            self._limits.check(
                times[first:], positions[first:].reshape(shape), speeds[first:].reshape(shape)
            )
        except TrajectoryError:
            return False
        return True

    def _inverse(self, feet: Array) -> Array:
        """Return joint positions, (m, 4, 3) [rad], for feet that may have to be nearer [m]."""
        legs, neutral = self._robot.stacked_legs, self._robot.neutral_feet
        try:
            return legs.inverse(feet)
        except GaitError:
            pass
        joints = np.empty_like(feet)
        for k, places in enumerate(feet):
            for fraction in _NEARER:
                try:
                    joints[k] = legs.inverse(neutral + fraction * (places - neutral))
                except GaitError:
                    continue
                break
        return joints


@compiled_loop
def keep_up(positions: Array, speeds: Array, times: Array, held: int, limits: Limits) -> None:
    """
    Have each joint come as near to its positions as its speed and its range allow.

    Over a time h a cubic with the velocities v and w at its ends, and m in the mean, is never
    faster than the largest of v, 3 m - v - w and w. So with the speed V of a joint m is possible
    from (v - 2 V) / 3 to (v + 2 V) / 3, and then w from 3 m - v - V to 3 m - v + V. Positions are
    within those of its ends and what is a third of h inside of them, with v and w.

    Parameters
    ----------
    positions : ndarray, shape (m, 4, 3)
        Where the joints are, and are to be, within their ranges; changed from ``held`` on [rad].
    speeds : ndarray, shape (m, 4, 3)
        Their velocities; filled in from there on [rad/s].
    times : ndarray, shape (m,)
        Times of all [s].
    held : int
        Number of knots that hold, at least one.
    limits : Limits
        What the joints are able to do.
    """
    count = len(times)
    for k in range(held, count):
        h = times[k] - times[k - 1]
        # At the last knot w is none.
        after, room = (times[k + 1] - times[k], 2.0) if k + 1 < count else (0.0, 1.0)
        for leg in range(positions.shape[1]):
            for joint in range(positions.shape[2]):
                last, v = positions[k - 1, leg, joint], speeds[k - 1, leg, joint]
                fastest = limits.fastest[leg, joint]
                mean = (positions[k, leg, joint] - last) / h
                mean = min(max(mean, (v - room * fastest) / 3.0), (v + room * fastest) / 3.0)
                place = last + h * mean
                positions[k, leg, joint] = place
                if after == 0.0:
                    speeds[k, leg, joint] = 0.0
                    continue
                on = (positions[k + 1, leg, joint] - place) / after
                on = min(max(on, -fastest), fastest)
                speed = _within((after * mean + h * on) / (h + after), 3.0 * mean - v, fastest)
                below = 3.0 * (place - limits.lower[leg, joint])
                above = 3.0 * (limits.upper[leg, joint] - place)
                speed = min(max(speed, -below / after, -above / h), above / after, below / h)
                speeds[k, leg, joint] = speed
                # What has to brake before the end of its range comes less far.
                mean = min(max(mean, (v + speed - fastest) / 3.0), (v + speed + fastest) / 3.0)
                positions[k, leg, joint] = last + h * mean


@compiled_loop
def is_within(positions: Array, speeds: Array, times: Array, first: int, limits: Limits) -> bool:
    """
    Return whether cubics are within limits for sure, as the last gate takes it.

    A cubic stays between its Bezier points. Its velocity is farthest from none at one of its ends,
    v and w, or at its vertex.

    Parameters
    ----------
    positions, speeds : ndarray, shape (m, 4, 3)
        At the knots [rad], [rad/s].
    times : ndarray, shape (m,)
        Times of all [s].
    first : int
        Knot from which on they are looked at.
    limits : Limits
        What the joints are able to do.

    Returns
    -------
    bool
        False where a closer look at positions may find them within the limits.
    """
    for k in range(first, len(times)):
        h = times[k] - times[k - 1] if k > first else 0.0
        for leg in range(positions.shape[1]):
            for joint in range(positions.shape[2]):
                low, high = limits.lower[leg, joint], limits.upper[leg, joint]
                fastest = limits.fastest[leg, joint]
                q, w = positions[k, leg, joint], speeds[k, leg, joint]
                # NaN is not within.
                if not (low <= q <= high and abs(w) <= fastest):
                    return False
                if k == first:
                    continue
                p, v = positions[k - 1, leg, joint], speeds[k - 1, leg, joint]
                if not (low <= p + v * h / 3.0 <= high and low <= q - w * h / 3.0 <= high):
                    return False
                middle = 3.0 * (q - p) / h - v - w
                if not abs(_extreme(v, middle, w)) <= (1.0 + VELOCITY_TOLERANCE) * fastest:
                    return False
    return True


@compiled_loop
def _cubic_at(
    times: Array, positions: Array, speeds: Array, time: float, position: Array, speed: Array
) -> None:
    """Fill in where joints are at a time [s], and how fast, (4, 3) [rad], [rad/s]."""
    k = 1
    while k < len(times) - 1 and times[k] <= time:
        k += 1
    h = times[k] - times[k - 1]
    u = (time - times[k - 1]) / h
    for leg in range(positions.shape[1]):
        for joint in range(positions.shape[2]):
            p, q = positions[k - 1, leg, joint], positions[k, leg, joint]
            v, w = speeds[k - 1, leg, joint] * h, speeds[k, leg, joint] * h
            # The cubic between two knots, as drives follow it.
            bend, twist = 3.0 * (q - p) - 2.0 * v - w, 2.0 * (p - q) + v + w
            position[leg, joint] = p + u * (v + u * (bend + u * twist))
            speed[leg, joint] = (v + u * (2.0 * bend + u * 3.0 * twist)) / h


@compiled_part
def _within(speed: float, middle: float, fastest: float) -> float:
    """Return the possible velocity that is nearest to one [rad/s]."""
    speed = min(max(speed, middle - fastest), middle + fastest)
    return min(max(speed, -fastest), fastest)


@compiled_part
def _extreme(first: float, middle: float, last: float) -> float:
    """Return the vertex of a parabola by its Bezier points; an end if that is outside, or none."""
    bend = first - 2.0 * middle + last
    if bend == 0.0:
        return first
    s = min(max((first - middle) / bend, 0.0), 1.0)
    return (1.0 - s) * ((1.0 - s) * first + 2.0 * s * middle) + s * s * last


def smooth_speeds(times: Array, positions: Array) -> Array:
    """Return velocities at m >= 2 knots, those of parabolas through each and its neighbors."""
    h = np.diff(times)[:, None, None]
    slopes = np.diff(positions, axis=0) / h
    speeds = np.zeros_like(positions)
    speeds[1:-1] = (h[1:] * slopes[:-1] + h[:-1] * slopes[1:]) / (h[1:] + h[:-1])
    return speeds
