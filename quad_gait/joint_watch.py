"""
Notices a joint that has failed: what it does against what it was commanded to do.

A sound joint follows its command within a few hundredths of a radian. One that stays off
for longer, while the others follow, does not answer any more: it gives way, or it is
stuck. Commands are known from the trajectories that were given out. They may be heard
late, and measurements may be old: whatever was commanded a moment ago is as good.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.joint_trajectory import JointTrajectory
from quad_common.robot import JOINTS_PER_LEG, LEGS, Robot

Array = NDArray[np.float64]

_SPACING = 0.02
"""Of instants at which a trajectory that may run late is looked at [s]."""

_BETWEEN = 6
"""So many postures are looked at on the way from one trajectory into the next."""


@dataclass(frozen=True)
class WatchOptions:
    """When a joint has failed."""

    tolerance: float = 0.08
    """Farther from its command than this a joint is off [rad]; sound ones are by 0.03 at most."""
    patience: float = 0.04
    """It has failed if it stays off for so long [s]."""
    age: float = 0.06
    """Measurements may be so old, or joints so late [s]."""
    delay: float = 0.3
    """One that starts on arrival may start so long after it was given out [s]."""
    hearing: float = 1.0
    """A trajectory is heard so long after it was given out, at the latest [s]."""
    longest_gap: float = 0.03
    """Two measurements farther apart count as if they were so near [s]."""
    saturated: float = 0.95
    """A motor that gives more than this share of its torque is overloaded, and has not failed."""
    slack: float = 0.03
    """A motor that gives less than this share of its torque gives none."""
    rest: float = 0.004
    """A joint that has turned by less than this since it is off does not move [rad]."""


@dataclass(frozen=True)
class JointFault:
    """One joint that does not answer."""

    joint: int
    """Its place in ``Robot.joint_names``."""
    name: str
    """Of the joint."""
    kind: str
    """``free``: it does not hold; ``stuck``: it does not move."""
    measured: float
    """[rad]"""
    commanded: float
    """[rad]"""
    effort: float | None
    """Torque of its motor [N m]; None if that is not known."""
    time: float
    """When it was noticed [s]."""
    is_slack: bool = False
    """Whether the motor gives next to no torque."""

    @property
    def leg(self) -> int:
        """Place of its leg in ``LEGS``."""
        return self.joint // JOINTS_PER_LEG

    def __str__(self) -> str:
        """Say what is wrong, with the numbers."""
        what = 'does not hold' if self.kind == 'free' else 'does not move'
        torque = ''
        if self.effort is not None:
            torque = ', and carries no torque' if self.is_slack else f', with {self.effort:.3g} N m'
        return (
            f'{self.name} of leg {LEGS[self.leg]} {what}: it is at {self.measured:.2f} rad, '
            f'{abs(self.measured - self.commanded):.2f} rad from its command{torque}'
        )


class _Given(NamedTuple):
    """A trajectory that was given out."""

    time: float
    """When [s]."""
    trajectory: JointTrajectory
    """With a stamp that is a time."""
    delay: float
    """By so much later it may run [s]."""


class JointWatch:
    """
    Compares joints with their commands, measurement by measurement.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : WatchOptions
        When a joint has failed.
    """

    def __init__(self, robot: Robot, options: WatchOptions | None = None) -> None:
        self._robot = robot
        self._options = WatchOptions() if options is None else options
        self._largest = robot.effort.reshape(-1)
        self._fastest = np.broadcast_to(robot.velocity, (4, 3)).reshape(-1)
        self.forget()

    def forget(self) -> None:
        """Know no commands, until the next trajectory is given out."""
        self._given: deque[_Given] = deque()
        self._last: tuple[float, Array] | None = None
        self._off_for = np.zeros(len(self._robot.joint_names))
        self._off_from = np.zeros(len(self._robot.joint_names))

    def expect(self, trajectory: JointTrajectory, time: float) -> None:
        """Take notice of a trajectory that is given out at a time [s]."""
        if self._given and self._given[-1].time >= time:
            self._given.pop()
        delay = 0.0
        if trajectory.stamp <= 0.0:
            trajectory, delay = replace(trajectory, stamp=time), self._options.delay
        self._given.append(_Given(time, trajectory, delay))

    def commanded(self, time: float) -> Array | None:
        """Return where the joints are commanded to be at a time [s], shape (12,) [rad]."""
        if not self._given:
            return None
        commanded: Array = _at(self._given[-1].trajectory, np.array([time]))[0]
        return commanded

    def update(
        self, time: float, positions: Array, efforts: Array | None = None
    ) -> JointFault | None:
        """
        Take a measurement.

        Parameters
        ----------
        time : float
            When it was taken [s].
        positions : ndarray, shape (12,)
            [rad]
        efforts : ndarray, shape (12,), optional
            Torques of the motors [N m].

        Returns
        -------
        JointFault or None
            The joint that has failed, if one has.
        """
        options = self._options
        last, self._last = self._last, (time, positions)
        if not self._given or last is None:
            return None
        dt = time - last[0]
        if dt <= 0.0:
            # Nothing new; or the clock was set back.
            if dt < 0.0:
                self.forget()
            return None
        jump = np.abs(positions - last[1]) - 4.0 * self._fastest * dt
        if np.any(jump > options.tolerance):
            # No drive moves like that: the robot was put somewhere else, as by a reset.
            self.forget()
            return None
        while len(self._given) > 1 and self._given[1].time < time - options.hearing:
            self._given.popleft()
        newest = _at(self._given[-1].trajectory, np.array([time]))
        postures = newest
        if np.any(np.abs(newest - positions) > options.tolerance):
            postures = self._postures(time)
        far = np.abs(postures - positions) > options.tolerance
        # Where the robot may be is told by all joints but one: there that one should be as well.
        others = far.sum(axis=1, keepdims=True) - far
        follow = others == 0
        off = (follow & far).any(axis=0) & ~(follow & ~far).any(axis=0)
        if np.count_nonzero(off) > 1:
            # What one of them says of the instant, another denies: nearer to now is likelier.
            first = (follow & far)[:, off].argmax(axis=0)
            off &= np.arange(len(off)) == np.flatnonzero(off)[int(first.argmin())]
        if efforts is not None:
            off &= np.abs(efforts) < options.saturated * self._largest
        self._off_from[~off] = positions[~off]
        self._off_for = np.where(off, self._off_for + min(dt, options.longest_gap), 0.0)
        failed = np.flatnonzero(self._off_for >= options.patience)
        return self._fault(int(failed[0]), time, positions, efforts) if len(failed) else None

    def _fault(
        self, joint: int, time: float, positions: Array, efforts: Array | None
    ) -> JointFault:
        options = self._options
        commanded = self.commanded(time)
        assert commanded is not None
        turned = abs(positions[joint] - self._off_from[joint])
        effort = None if efforts is None or not np.any(efforts) else float(efforts[joint])
        is_slack = effort is not None and abs(effort) < options.slack * self._largest[joint]
        moves = turned > options.rest
        return JointFault(
            joint,
            self._robot.joint_names[joint],
            'free' if moves else 'stuck',
            float(positions[joint]),
            float(commanded[joint]),
            effort,
            time,
            is_slack,
        )

    def _postures(self, time: float) -> Array:
        """
        List the postures that a sound robot may be in.

        Returns
        -------
        ndarray, shape (n, 12)
            By each trajectory that it may follow, at each of the instants that may be measured
            [rad], the latest first; none before the first trajectory has begun.
        """
        rows = [np.empty((0, len(self._robot.joint_names)))]
        for k in reversed(range(len(self._given))):
            _, trajectory, delay = self._given[k]
            latest = self._options.age + delay
            instants = time - np.linspace(0.0, latest, 1 + round(latest / _SPACING))
            runs = instants >= trajectory.stamp + float(trajectory.times[0])
            if not runs.all() and k == 0:
                # Where the joints were commanded before is not known.
                return np.empty((0, len(self._robot.joint_names)))
            rows.append(_at(trajectory, instants[runs]))
            if not runs.all():
                # On its way from one trajectory into the next.
                before = _at(self._given[k - 1].trajectory, np.array([time]))[0]
                share = np.linspace(0.0, 1.0, _BETWEEN)[:, None]
                rows.append(before + share * (trajectory.positions[0] - before))
        return np.concatenate(rows)


def _at(trajectory: JointTrajectory, time: Array) -> Array:
    """Return the positions on the cubics between points, shape (m, n) for m times [rad]."""
    times, positions, velocities = trajectory.times, trajectory.positions, trajectory.velocities
    if len(times) == 1:
        return np.repeat(positions, len(time), axis=0)
    t = np.clip(time - trajectory.stamp, times[0], times[-1])
    k = np.clip(np.searchsorted(times, t, side='right') - 1, 0, len(times) - 2)
    h = (times[k + 1] - times[k])[:, None]
    s = (t - times[k])[:, None] / h
    a, b, u, v = positions[k], positions[k + 1], velocities[k] * h, velocities[k + 1] * h
    path: Array = a + s * (u + s * (3.0 * (b - a) - 2.0 * u - v + s * (u + v - 2.0 * (b - a))))
    return path
