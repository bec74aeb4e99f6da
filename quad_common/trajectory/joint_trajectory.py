"""
A joint trajectory: positions and velocities of named joints over time.

It holds what a trajectory_msgs/JointTrajectory message holds, checked, as arrays.
Between points the joints follow cubic polynomials, as ros2_control's
joint_trajectory_controller interpolates positions with velocities.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    EmptyTrajectory,
    JointRepeated,
    TimesDoNotRise,
    TrajectoryNotFinite,
    TrajectoryShapeWrong,
)

Array = NDArray[np.float64]

LONGEST_TRAJECTORY = 20_000
"""Points of a trajectory that is executed, unless a parameter says otherwise."""


@dataclass(frozen=True)
class JointTrajectory:
    """
    Points of a joint trajectory.

    Raises
    ------
    TrajectoryError
        If it is empty, its sizes disagree, a number is not finite, or its times do not
        rise.
    """

    joint_names: tuple[str, ...]
    """n joints."""
    stamp: float
    """Time at which it starts [s]; 0 means on arrival."""
    times: Array
    """Times of the points, from the start, shape (m,) [s]."""
    positions: Array
    """Joint angles at the points, shape (m, n) [rad]."""
    velocities: Array
    """Joint speeds at the points, shape (m, n) [rad/s]."""

    def __post_init__(self) -> None:
        points, joints = len(self.times), len(self.joint_names)
        if points == 0 or joints == 0:
            raise EmptyTrajectory(points, joints)
        if len(set(self.joint_names)) != joints:
            names = self.joint_names
            raise JointRepeated(next(name for name in names if names.count(name) > 1))
        for what, values in (('positions', self.positions), ('velocities', self.velocities)):
            if values.shape != (points, joints):
                raise TrajectoryShapeWrong(what, values.shape, (points, joints))
            if not np.all(np.isfinite(values)):
                raise TrajectoryNotFinite(what)
        if not np.all(np.isfinite(self.times)) or not np.isfinite(self.stamp):
            raise TrajectoryNotFinite('times')
        if self.times[0] < 0.0 or np.any(np.diff(self.times) <= 0.0):
            raise TimesDoNotRise()

    @property
    def end(self) -> float:
        """When the last point is reached [s]."""
        return self.stamp + float(self.times[-1])

    def delayed(self, delay: float) -> JointTrajectory:
        """Return the same motion, begun later by a time [s]."""
        return replace(self, times=self.times + delay) if delay else self

    def positions_at(self, times: Array) -> Array:
        """
        Return the positions on the cubics between points.

        Parameters
        ----------
        times : ndarray, shape (k,)
            When [s]; before the first and after the last point these points are held.

        Returns
        -------
        ndarray, shape (k, n)
            [rad]
        """
        if len(self.times) == 1:
            return np.repeat(self.positions, len(times), axis=0)
        t = np.clip(times - self.stamp, self.times[0], self.times[-1])
        k = np.searchsorted(self.times, t, side='right') - 1
        k = np.clip(k, 0, len(self.times) - 2)
        h = (self.times[k + 1] - self.times[k])[:, None]
        s = (t - self.times[k])[:, None] / h
        a, b = self.positions[k], self.positions[k + 1]
        u, v = self.velocities[k] * h, self.velocities[k + 1] * h
        path: Array = a + s * (u + s * (3.0 * (b - a) - 2.0 * u - v + s * (u + v - 2.0 * (b - a))))
        return path
