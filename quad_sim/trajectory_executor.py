"""
Executes joint trajectories as ros2_control's joint_trajectory_controller does.

Joints are matched by name; a new trajectory replaces the old one on arrival; until its
first point the joints go from where they are commanded now to that point; between
points they follow cubics in position and velocity; after the last they hold it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import JointNotFound, TrajectoryError
from quad_common.joint_trajectory import JointTrajectory

Array = NDArray[np.float64]


class TrajectoryExecutor:
    """
    Turns the current trajectory into a command for each instant.

    Parameters
    ----------
    joint_names : tuple of str
        The robot's joints, in the order of its commands.
    positions : ndarray, shape (n,)
        What to hold until a trajectory comes [rad].
    """

    def __init__(self, joint_names: tuple[str, ...], positions: Array) -> None:
        self._joint_names = joint_names
        self.hold(positions)

    def hold(self, positions: Array) -> None:
        """Drop the trajectory and hold these positions, shape (n,) [rad]."""
        still = np.zeros_like(positions)
        self._times = np.array([0.0])
        self._positions = np.array([positions], dtype=float)
        self._coefficients = np.zeros((0, 4, len(positions)))
        self._segment = 0
        self._still = still

    @property
    def end(self) -> float:
        """When the last point of the trajectory is, or was, reached [s]."""
        return float(self._times[-1])

    def accept(self, trajectory: JointTrajectory, now: float) -> None:
        """
        Replace the current trajectory.

        Parameters
        ----------
        trajectory : JointTrajectory
            It must move every joint; their order is free.
        now : float
            Current time [s].

        Raises
        ------
        JointNotFound
            If it names a joint that the robot does not have.
        TrajectoryError
            If it leaves out a joint, or has ended already.
        """
        for name in trajectory.joint_names:
            if name not in self._joint_names:
                raise JointNotFound(name, self._joint_names)
        missing = [name for name in self._joint_names if name not in trajectory.joint_names]
        if missing:
            raise TrajectoryError(f'the trajectory leaves out {", ".join(missing)}')
        start = trajectory.stamp if trajectory.stamp > 0.0 else now
        times = start + trajectory.times
        if times[-1] <= now:
            raise TrajectoryError(
                f'the trajectory ended at {times[-1]:.3f} s, {now - times[-1]:.3f} s ago'
            )
        order = [trajectory.joint_names.index(name) for name in self._joint_names]
        positions = trajectory.positions[:, order]
        velocities = trajectory.velocities[:, order]
        if times[0] > now:
            position, velocity = self.command(now)
            times = np.concatenate([[now], times])
            positions = np.vstack([position, positions])
            velocities = np.vstack([velocity, velocities])
        self._times = times
        self._positions = positions
        self._coefficients = _cubics(times, positions, velocities)
        self._segment = 0

    def command(self, time: float) -> tuple[Array, Array]:
        """
        Say where the joints should be.

        Parameters
        ----------
        time : float
            [s]; times should not go back between trajectories.

        Returns
        -------
        tuple of ndarray, each of shape (n,)
            Positions [rad] and velocities [rad/s].
        """
        if time >= self._times[-1]:
            return self._positions[-1], self._still
        while self._segment > 0 and time < self._times[self._segment]:
            self._segment -= 1
        while time >= self._times[self._segment + 1]:
            self._segment += 1
        a, b, c, d = self._coefficients[self._segment]
        s = time - self._times[self._segment]
        return a + s * (b + s * (c + s * d)), b + s * (2.0 * c + 3.0 * s * d)


def _cubics(times: Array, positions: Array, velocities: Array) -> Array:
    """Coefficients of the cubic in each interval, shape (m - 1, 4, n)."""
    h = np.diff(times)[:, None]
    p0, p1 = positions[:-1], positions[1:]
    v0, v1 = velocities[:-1], velocities[1:]
    slope = (p1 - p0) / h
    bend = (3.0 * slope - 2.0 * v0 - v1) / h
    return np.stack([p0, v0, bend, (v0 + v1 - 2.0 * slope) / h**2], axis=1)
