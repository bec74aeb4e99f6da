"""
Whether commands and measured joints stay within what the robot can do.

Written apart from the gates in gait_node and sim_node, and from the robot's data alone: who
watches must not make the same mistake as who is watched.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_gate import OVERSHOOT, VELOCITY_TOLERANCE

Array = NDArray[np.float64]

_ROUNDING = 1e-6
"""Beyond a limit by no more than this is on it [rad, rad/s]."""

_SAME_PLACE = 0.02
"""A trajectory begins where the last one leads to, if it is as near as this [rad]."""

_GIVE = 0.1
"""By which a measured joint may be past its range: contacts and bodies are not rigid [rad]."""

_RUNNING = 0.02
"""Time in which a joint turns as far as a trajectory that runs already may be off [s]."""

_FAST = 1.5
"""A measured joint may be faster than its motor by this factor, when the leg is pushed."""

_INSTANTS = 11
"""Instants between the earliest and the latest at which a trajectory was decided on."""

_OWN_TIME = 0.02
"""Of a joint, for a jump: encoders are read at one instant, commands given at another [s]."""


class TrajectoryChecker:
    """
    Checks trajectories, one after the other, against the robot's joint ranges and speeds.

    Parameters
    ----------
    robot : Robot
        Whose limits count.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._lower = robot.lower.reshape(-1)
        self._upper = robot.upper.reshape(-1)
        self._speed = robot.velocity.reshape(-1)
        self._last: JointTrajectory | None = None
        self._compared_from = -math.inf

    def forget(self, until: float) -> None:
        """Compare no trajectories up to a time [s]: the robot is put elsewhere."""
        self._compared_from = until

    def check(
        self, trajectory: JointTrajectory, now: float, answered: float | None = None
    ) -> list[str]:
        """
        Check a trajectory, and keep it for the next one.

        Parameters
        ----------
        trajectory : JointTrajectory
            As published.
        now : float
            The time at which it came [s].
        answered : float, optional
            The time up to which the gait had answered before: on a busy machine it decided long
            before the trajectory came here [s]. As `now` if not given.

        Returns
        -------
        list of str
            Each way in which it leaves the limits.
        """
        missing = set(self._robot.joint_names) - set(trajectory.joint_names)
        if missing:
            return [f'joints {", ".join(sorted(missing))} are missing']
        order = [trajectory.joint_names.index(name) for name in self._robot.joint_names]
        ordered = JointTrajectory(
            self._robot.joint_names,
            trajectory.stamp,
            trajectory.times,
            trajectory.positions[:, order],
            trajectory.velocities[:, order],
        )
        earliest = now if answered is None else min(answered, now)
        problems = [*self._outside(ordered), *self._leap(ordered, earliest, now)]
        self._last = ordered
        return problems

    def _outside(self, trajectory: JointTrajectory) -> list[str]:
        low, high, fast = extremes(trajectory)
        at_points = np.abs(trajectory.velocities).max(axis=0)
        # Between points as much as the gate allows; at the points nothing.
        low = np.minimum(low + OVERSHOOT, trajectory.positions.min(axis=0))
        high = np.maximum(high - OVERSHOOT, trajectory.positions.max(axis=0))
        problems = []
        for joint, name in enumerate(trajectory.joint_names):
            if low[joint] < self._lower[joint] - _ROUNDING:
                problems.append(
                    f'{name} goes to {low[joint]:.4g} rad, below {self._lower[joint]:.4g}'
                )
            if high[joint] > self._upper[joint] + _ROUNDING:
                problems.append(
                    f'{name} goes to {high[joint]:.4g} rad, above {self._upper[joint]:.4g}'
                )
            most = self._speed[joint] + _ROUNDING
            if at_points[joint] > most or fast[joint] > (1.0 + VELOCITY_TOLERANCE) * most:
                problems.append(
                    f'{name} moves at {fast[joint]:.4g} rad/s, faster than {self._speed[joint]:.4g}'
                )
        return problems

    def _leap(self, trajectory: JointTrajectory, earliest: float, now: float) -> list[str]:
        """Compare where it begins with where the last one is then."""
        last = self._last
        if last is None or now < self._compared_from:
            return []
        start = (trajectory.stamp or now) + float(trajectory.times[0])
        first = trajectory.positions[0]
        apart = np.abs(first - position_at(last, start))
        # Not on the last one's path: then it has to be reached from there in the time left. One
        # that runs already may be off as far as gait_node's own gate lets it.
        instants = np.linspace(earliest, now, _INSTANTS)[:, None]
        far = np.abs(first - np.array([position_at(last, float(time)) for time in instants[:, 0]]))
        reach = self._speed * np.maximum(_RUNNING, start - instants) + _SAME_PLACE
        bad = np.flatnonzero((apart > _SAME_PLACE) & (far > reach).all(axis=0))
        return [
            f'{trajectory.joint_names[j]} is {far[-1, j]:.4g} rad from its last command, and has '
            f'{start - now:.3f} s to get there at {self._speed[j]:.3g} rad/s'
            for j in bad
        ]


class JointChecker:
    """
    Checks measured joints against the robot's ranges and speeds.

    Parameters
    ----------
    robot : Robot
        Whose limits count.
    """

    def __init__(self, robot: Robot) -> None:
        self._names = robot.joint_names
        self._lower = robot.lower.reshape(-1) - _GIVE
        self._upper = robot.upper.reshape(-1) + _GIVE
        self._speed = _FAST * robot.velocity.reshape(-1)
        self._before: tuple[float, Array] | None = None
        self._compared_from = -math.inf

    def forget(self, until: float) -> None:
        """Compare no positions up to a time [s]: the robot is put elsewhere."""
        self._compared_from = until

    def check(self, time: float, positions: Array) -> list[str]:
        """
        Check measured positions, and keep them for the next ones.

        Parameters
        ----------
        time : float
            When they were measured [s].
        positions : ndarray, shape (12,)
            In the robot's order [rad].

        Returns
        -------
        list of str
            Each way in which they leave the limits.
        """
        problems = [
            f'{self._names[j]} is at {positions[j]:.4g} rad, outside '
            f'{self._lower[j]:.4g} to {self._upper[j]:.4g}'
            for j in np.flatnonzero((positions < self._lower) | (positions > self._upper))
        ]
        is_compared = time >= self._compared_from
        if is_compared and self._before is not None and time > self._before[0]:
            duration = time - self._before[0] + _OWN_TIME
            moved = np.abs(positions - self._before[1])
            problems += [
                f'{self._names[j]} moved by {moved[j]:.4g} rad in {duration - _OWN_TIME:.3f} s'
                for j in np.flatnonzero(moved > self._speed * duration)
            ]
        self._before = (time, positions)
        return problems


def position_at(trajectory: JointTrajectory, time: float) -> Array:
    """
    Return where a trajectory has the joints at a time.

    Parameters
    ----------
    trajectory : JointTrajectory
        Before its first point the first one counts, after its last the last.
    time : float
        [s]

    Returns
    -------
    ndarray, shape (n,)
        Positions, by the cubic between points [rad].
    """
    s = time - trajectory.stamp
    times = trajectory.times
    if s <= times[0]:
        return np.asarray(trajectory.positions[0])
    if s >= times[-1]:
        return np.asarray(trajectory.positions[-1])
    k = int(np.searchsorted(times, s, 'right')) - 1
    a, b, c, d = _cubics(trajectory)[:, k]
    s -= times[k]
    return np.asarray(a + s * (b + s * (c + s * d)))


def extremes(trajectory: JointTrajectory) -> tuple[Array, Array, Array]:
    """
    Return how far and how fast a trajectory moves each joint, also between its points.

    Parameters
    ----------
    trajectory : JointTrajectory
        The joints follow cubics in position and velocity.

    Returns
    -------
    tuple of ndarray, each of shape (n,)
        Least and largest position [rad], largest speed [rad/s].
    """
    low, high = trajectory.positions.min(axis=0), trajectory.positions.max(axis=0)
    fast = np.abs(trajectory.velocities).max(axis=0)
    if len(trajectory.times) < 2:
        return low, high, fast
    a, b, c, d = _cubics(trajectory)
    h = np.diff(trajectory.times)[:, None]
    with np.errstate(divide='ignore', invalid='ignore', over='ignore'):
        # Largest speed: where the acceleration 2 c + 6 d s is zero.
        vertex = -c / (3.0 * d)
        speed = np.abs(b + vertex * (2.0 * c + 3.0 * d * vertex))
        inside = (vertex > 0.0) & (vertex < h)
        fast = np.maximum(fast, np.where(inside, speed, 0.0).max(axis=0))
        # Extreme positions: where the velocity b + 2 c s + 3 d s^2 is zero; in the form that
        # does not lose digits where d is next to nothing.
        root = np.sqrt(c * c - 3.0 * b * d)
        half = -(c + np.copysign(root, c))
        for s in (half / (3.0 * d), b / half):
            inside = (s > 0.0) & (s < h)
            position = a + s * (b + s * (c + s * d))
            low = np.minimum(low, np.where(inside, position, np.inf).min(axis=0))
            high = np.maximum(high, np.where(inside, position, -np.inf).max(axis=0))
    return low, high, fast


def _cubics(trajectory: JointTrajectory) -> Array:
    """Coefficients of the cubic in each interval, shape (4, m - 1, n)."""
    h = np.diff(trajectory.times)[:, None]
    # Numbers that overflow here are far outside the limits at the points already.
    with np.errstate(over='ignore', invalid='ignore'):
        return _hermite(h, trajectory)


def _hermite(h: Array, trajectory: JointTrajectory) -> Array:
    p0, p1 = trajectory.positions[:-1], trajectory.positions[1:]
    v0, v1 = trajectory.velocities[:-1], trajectory.velocities[1:]
    slope = (p1 - p0) / h
    bend = (3.0 * slope - 2.0 * v0 - v1) / h
    return np.stack([p0, v0, bend, (v0 + v1 - 2.0 * slope) / h**2])
