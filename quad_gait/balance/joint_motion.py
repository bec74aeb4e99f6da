"""
From the feet of knots to joint motion that the drives can follow.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, TrajectoryError
from quad_common.robot.robot import Robot
from quad_common.trajectory.trajectory_gate import JointLimits

Array = NDArray[np.float64]

_NEARER = (1.0, 0.85, 0.7, 0.5, 0.3, 0.0)
"""Fractions of the way from its neutral place at which a foot is put that cannot be farther."""

_ROOM = 0.02
"""Distance from the ends of their ranges that the joints of a slowed leg keep [rad]."""

_FIRST = 0.5
"""Fraction of its largest speed that a joint is slowed to in the first interval: what runs goes
into it with a speed of its own."""


@dataclass(frozen=True)
class JointMotion:
    """Positions and velocities of the joints at m knots."""

    times: Array
    """Times of the knots, shape (m,) [s]."""
    positions: Array
    """Positions, shape (m, 4, 3) [rad]."""
    speeds: Array
    """Velocities, shape (m, 4, 3) [rad/s]."""


class JointMotionPlanner:
    """
    Chooses joint motion within the limits of one robot.

    Where the feet's own motion would leave a range, or be too fast for a joint, the feet are put
    nearer, and the legs concerned are slowed as a whole, so that their feet keep to their paths.

    Parameters
    ----------
    robot : Robot
        The robot.
    speed_fraction : float
        Fraction of their largest speeds to which the joints of a leg are slowed.
    """

    def __init__(self, robot: Robot, speed_fraction: float) -> None:
        self._robot = robot
        self._limits = JointLimits.of(robot)
        self._speed_fraction = speed_fraction
        self.slowed = 0
        """Number of times that legs were slowed."""

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
        for speeds_of in (smooth_speeds, monotone_speeds):
            speeds = speeds_of(all_times, positions)
            speeds[:held], speeds[-1] = given.speeds, 0.0
            if self._is_possible(all_times, positions, speeds, held):
                return JointMotion(all_times, positions, speeds)
            self.slowed += 1
            positions[held:] = self._slowed(wanted, given.positions[-1], np.diff(all_times))
        return None

    def _is_possible(self, times: Array, positions: Array, speeds: Array, held: int) -> bool:
        first = held - 1
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

    def _slowed(self, wanted: Array, last: Array, intervals: Array) -> Array:
        """Return joint positions, (m, 4, 3), that each leg comes to without undue haste."""
        robot = self._robot
        positions = np.clip(wanted, robot.lower + _ROOM, robot.upper - _ROOM)
        fraction = _FIRST
        for k, dt in enumerate(intervals[-len(wanted) :]):
            step = positions[k] - last
            over = (np.abs(step) / (fraction * dt * robot.velocity)).max(axis=1)
            positions[k] = last + step / np.maximum(1.0, over)[:, None]
            last, fraction = positions[k], self._speed_fraction
        return positions


def smooth_speeds(times: Array, positions: Array) -> Array:
    """Return velocities at m >= 2 knots, those of parabolas through each and its neighbors."""
    h = np.diff(times)[:, None, None]
    slopes = np.diff(positions, axis=0) / h
    speeds = np.zeros_like(positions)
    speeds[1:-1] = (h[1:] * slopes[:-1] + h[:-1] * slopes[1:]) / (h[1:] + h[:-1])
    return speeds


def monotone_speeds(times: Array, positions: Array) -> Array:
    """Return velocities at m >= 2 knots with which no joint goes beyond the knots between them."""
    slopes = np.diff(positions, axis=0) / np.diff(times)[:, None, None]
    before, after = slopes[:-1], slopes[1:]
    is_same = before * after > 0.0
    total = np.where(is_same, before + after, 1.0)
    speeds = np.zeros_like(positions)
    speeds[1:-1] = np.where(is_same, 2.0 * before * after / total, 0.0)
    return speeds
