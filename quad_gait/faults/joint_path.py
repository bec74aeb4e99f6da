"""
A joint trajectory that was given out, and how far sound joints may be from it.

A drive follows its command with a lag. A joint that is commanded to turn at a speed v is
behind by lag * v, and loads and the drive's stiffness add something that does not depend
on the speed: so a sound joint is within

    allowed = tolerance + lag * |v|

of its command, v being the largest commanded speed over the last two intervals.
"""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

from quad_common.trajectory.joint_trajectory import JointTrajectory

Array = NDArray[np.float64]


class JointPath:
    """
    Where the joints should be at a time, and how far from there they may be.

    Parameters
    ----------
    trajectory : JointTrajectory
        As it was given out.
    given : float
        When it was given out [s]; one without a stamp begins then at the earliest.
    tolerance : float
        What a joint at rest may be off [rad].
    lag : float
        By so much time it may be behind [s].
    """

    def __init__(
        self, trajectory: JointTrajectory, given: float, tolerance: float, lag: float
    ) -> None:
        self.given = given
        """Time at which it was given out [s]."""
        self.starts_on_arrival = trajectory.stamp <= 0.0
        """Whether it begins whenever it arrives."""
        start = given if self.starts_on_arrival else trajectory.stamp
        times, positions = start + trajectory.times, trajectory.positions
        velocities = trajectory.velocities
        self.positions = positions
        """Positions at its points, shape (m, n) [rad]."""
        self.begin, self.end = float(times[0]), float(times[-1])
        """Times of the first and the last point, if it arrives at once [s]."""
        self._knots, self._times = times, times.tolist()
        h = np.diff(times)[:, None]
        slope = np.diff(positions, axis=0) / h
        v0, v1 = velocities[:-1], velocities[1:]
        self._coefficients = np.stack(
            [positions[:-1], v0, (3.0 * slope - 2.0 * v0 - v1) / h, (v0 + v1 - 2.0 * slope) / h**2],
            axis=1,
        )
        # At the ends of the interval and in its middle, where a cubic is fastest.
        middle = 1.5 * slope - 0.25 * (v0 + v1)
        speeds = np.max(np.abs([v0, v1, middle]), axis=0)
        speeds[1:] = np.maximum(speeds[1:], speeds[:-1])
        if not len(speeds):
            speeds = np.zeros((1, positions.shape[1]))
        self._allowed = tolerance + lag * speeds

    @classmethod
    def hold(cls, positions: Array, time: float, tolerance: float) -> JointPath:
        """Return the path of joints that stay where they are from a time [s] on."""
        still = np.zeros((1, len(positions)))
        names = tuple(str(k) for k in range(len(positions)))
        trajectory = JointTrajectory(names, time, np.zeros(1), positions[None].copy(), still)
        path = cls(trajectory, time, tolerance, 0.0)
        # Before anything that is given out, and at no unknown time.
        path.given, path.starts_on_arrival = -np.inf, False
        return path

    def at(self, time: float) -> tuple[Array, Array]:
        """Return positions and what they may be off at a time [s], each of shape (n,) [rad]."""
        times = self._times
        if time >= times[-1]:
            return self.positions[-1], self._allowed[-1]
        if time <= times[0]:
            return self.positions[0], self._allowed[0]
        k = bisect_right(times, time) - 1
        a, b, c, d = self._coefficients[k]
        s = time - times[k]
        return a + s * (b + s * (c + s * d)), self._allowed[k]

    def over(self, times: Array) -> tuple[Array, Array]:
        """Return the same for many times, shape (m,) [s]; each of shape (m, n) [rad]."""
        if not len(self._coefficients):
            shape = (len(times), self.positions.shape[1])
            return np.broadcast_to(self.positions, shape), np.broadcast_to(self._allowed, shape)
        # As numpy.clip, which takes several times as long for a few numbers.
        t = np.minimum(np.maximum(times, self.begin), self.end)
        k = np.minimum(np.searchsorted(self._knots, t, side='right') - 1, len(self._allowed) - 1)
        a, b, c, d = self._coefficients[k].transpose(1, 0, 2)
        s = (t - self._knots[k])[:, None]
        return a + s * (b + s * (c + s * d)), self._allowed[k]
