"""
A motion of the joints that is given out bit by bit, to drives that may receive it late.

A foot that feels for the ground must stop when it meets it. Were its whole travel down given
out at once, it would press on for as long as the answer takes. So only as much is given out
as does no harm, and more while nothing has been met. How far the joints are is told by the
joints themselves, not by a clock: it is not known when a trajectory has come to them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.trajectory.joint_trajectory import JointTrajectory

Array = NDArray[np.float64]

_ALIKE = 5e-3
"""Samples are as good a match as the best one if no joint is off by so much more [rad]."""

_ELSEWHERE = 0.07
"""Distance of a joint from its command that drive and load do not make at rest, as for the watch
over joints that do not answer [rad]."""

_THERE = 0.03
"""Distance from its command at which a joint is there: where all but one are, a motion has come and
that one may have failed [rad]."""

_PATIENCE = 1.0
"""Time past its end after which a motion counts as lost [s]."""

_MOST_REPEATS = 2
"""Number of times that a lost motion is given out again; then it is over wherever joints are."""


@dataclass(frozen=True)
class JointMotion:
    """Evenly spaced samples of all joints."""

    joint_names: tuple[str, ...]
    """12 joints, leg by leg."""
    times: Array
    """Times of the samples, from 0 on, shape (n,) [s]."""
    positions: Array
    """Joint angles, shape (n, 4, 3) [rad]."""
    velocities: Array
    """Joint speeds, shape (n, 4, 3) [rad/s]."""
    fastest: Array
    """Largest speeds of the joints, shape (12,) [rad/s]."""
    start: float
    """Time at which its first sample is reached, if it is received at once [s]."""
    given: int
    """Samples up to this one have been given out."""
    since: int = 0
    """Sample with which what was given out last begins."""
    done: int = 0
    """Sample that the joints have reached, as far as is known."""
    repeats: int = 0
    """Number of times that it has been given out again, as the joints had not come to its end."""

    @property
    def end(self) -> float:
        """When the last sample is reached, if all are received at once [s]."""
        return self.start + float(self.times[-1])

    @property
    def commanded(self) -> Array:
        """Where the joints are commanded to be by now, shape (4, 3) [rad]."""
        commanded: Array = self.positions[self.done]
        return commanded

    @property
    def is_done(self) -> bool:
        """Whether the joints have got to the last sample."""
        return self.done == len(self.times) - 1

    def followed(self, time: float, joint_positions: Array) -> JointMotion:
        """
        Look how far the joints are.

        Parameters
        ----------
        time : float
            Of the measurement [s].
        joint_positions : ndarray, shape (4, 3)
            [rad]

        Returns
        -------
        JointMotion
            The same, with :attr:`done` brought up to date: the last sample that the joints may
            be at by their angles and by the clock.
        """
        if time > self.end + _PATIENCE and not self._is_lost(joint_positions):
            return replace(self, done=self.given)
        period = self.times[1]
        latest = min(self.given, int((time - self.start) / period + 1e-6))
        if latest <= self.done:
            return self
        off = np.abs(self.positions[self.done : latest + 1] - joint_positions).max(axis=(1, 2))
        alike = np.flatnonzero(off <= off.min() + _ALIKE)
        return replace(self, done=self.done + int(alike[-1]))

    def repeated(
        self, time: float, joint_positions: Array, reaction_time: float
    ) -> JointMotion | None:
        """
        Give out the rest again, if what was given out last seems to be lost.

        Parameters
        ----------
        time : float
            Of the measurement [s].
        joint_positions : ndarray, shape (4, 3)
            [rad]
        reaction_time : float
            In which a trajectory comes to the joints [s].

        Returns
        -------
        JointMotion or None
            With a :attr:`start` that fits the new trajectory; None if nothing is lost.
        """
        due = self.start + float(self.times[self.given])
        if time <= due + _PATIENCE or self.done == self.given:
            return None
        if not self._is_lost(joint_positions):
            return None
        start = time + reaction_time - float(self.times[self.done])
        return replace(self, since=self.done, start=start, repeats=self.repeats + 1)

    def _is_lost(self, joint_positions: Array) -> bool:
        """Tell of joints that should be at the end whether they never began, as far as is known."""
        off = np.sort(np.abs(self.positions[self.given] - joint_positions), axis=None)
        is_elsewhere = off[-1] > _ELSEWHERE and off[-2] > _THERE
        return bool(is_elsewhere and self.repeats < _MOST_REPEATS)

    def extended(self, time: float, reaction_time: float, samples: int) -> JointMotion | None:
        """
        Give out more, if the joints are soon at the end of what they have.

        Parameters
        ----------
        time : float
            [s]
        reaction_time : float
            In which a trajectory comes to the joints [s].
        samples : int
            How many more.

        Returns
        -------
        JointMotion or None
            With a :attr:`start` that fits the new trajectory; None if nothing is to be given.
        """
        last = len(self.times) - 1
        ahead = round(reaction_time / float(self.times[1]))
        if self.given == last or self.given - self.done > ahead:
            return None
        since = min(self.done + ahead, self.given)
        start = time + reaction_time - float(self.times[since])
        given = min(self.given + samples, last)
        return replace(self, since=since, given=given, start=start)

    def trajectory(self, reaction_time: float) -> JointTrajectory:
        """
        Write what has been given out last.

        Parameters
        ----------
        reaction_time : float
            After its arrival, until its first point is reached [s].

        Returns
        -------
        JointTrajectory
            It starts on arrival and ends at rest.
        """
        part = slice(self.since, self.given + 1)
        joints = len(self.joint_names)
        velocities = self.velocities[part].reshape(-1, joints).copy()
        times = reaction_time + self.times[part] - self.times[self.since]
        velocities[-1] = 0.0
        if len(times) > 1:
            displacement = self.positions[self.given] - self.positions[self.given - 1]
            least = braking_time(displacement.reshape(-1), velocities[-2], self.fastest)
            times[-1] = max(times[-1], times[-2] + least)
        return JointTrajectory(
            joint_names=self.joint_names,
            stamp=0.0,
            times=times,
            positions=self.positions[part].reshape(-1, joints),
            velocities=velocities,
        )


class MotionOutput:
    """
    Gives out one motion after the other, and knows how far the joints are.

    Parameters
    ----------
    reaction_time : float
        In which a trajectory comes to the joints [s].
    """

    def __init__(self, reaction_time: float) -> None:
        self._reaction = reaction_time
        self.motion: JointMotion | None = None
        """Motion that was given out last; None before the joints move."""
        self.way: list[Array] = []
        """Where the joints were commanded to be on their way so far, each of shape (4, 3) [rad]."""

    @property
    def end(self) -> float:
        """Time at which what was planned last is done; minus infinity if nothing was [s]."""
        return -np.inf if self.motion is None else self.motion.end

    @property
    def commanded(self) -> Array | None:
        """Where the joints are commanded to be by now, shape (4, 3) [rad]; None at first."""
        return None if self.motion is None else self.motion.commanded

    @property
    def last(self) -> Array | None:
        """Where the joints are commanded to end, shape (4, 3) [rad]; None at first."""
        return None if self.motion is None else self.motion.positions[self.motion.given]

    @property
    def is_done(self) -> bool:
        """Whether the joints have got to the end of a motion."""
        return self.motion is not None and self.motion.is_done

    def has_reached(self, sample: int) -> bool:
        """Tell whether the joints have got to a sample of the motion."""
        return self.motion is not None and self.motion.done >= sample

    def follow(self, time: float, joint_positions: Array) -> JointMotion | None:
        """Look how far the joints are; return the motion again if it seems to be lost."""
        if self.motion is None:
            return None
        before, self.motion = self.motion.done, self.motion.followed(time, joint_positions)
        self.way.extend(self.motion.positions[before + 1 : self.motion.done + 1])
        return self.motion.repeated(time, joint_positions, self._reaction)

    def give(self, motion: JointMotion) -> JointTrajectory:
        """Give out a motion, or more of it."""
        self.motion = motion
        return motion.trajectory(self._reaction)

    def forget_way_before(self, sample: int) -> None:
        """Forget the way so far, if the joints have not got beyond a sample of the motion."""
        if not self.has_reached(sample):
            self.way.clear()

    def more(self, time: float, samples: int) -> JointMotion | None:
        """Return the motion with more samples; None if nothing is to be given out yet."""
        if self.motion is None:
            return None
        return self.motion.extended(time, self._reaction, samples)

    def go_on(self, time: float, samples: int) -> JointTrajectory | None:
        """Give out more samples of the motion, if there are any to be given out yet."""
        more = self.more(time, samples)
        return None if more is None else self.give(more)


def braking_time(displacement: Array, velocity: Array, fastest: Array) -> float:
    """
    Return the shortest time in which joints come to rest after a displacement, within their speeds.

    Parameters
    ----------
    displacement : ndarray, shape (n,)
        Angles through which they still turn [rad].
    velocity : ndarray, shape (n,)
        Velocities with which they begin [rad/s].
    fastest : ndarray, shape (n,)
        Largest speeds [rad/s].

    Returns
    -------
    float
        For cubics [s]. Their velocity, v0 (1-s)^2 + 2 m s (1-s) with m = 3 d / T - v0 for a
        displacement d, has its largest value m^2 / (2 m - v0), which is the limit L for
        m = L + sqrt(L (L - v0)).
    """
    ahead = np.clip(velocity * np.sign(displacement), -fastest, fastest)
    most = fastest + np.sqrt(fastest * (fastest - ahead))
    return float(np.max(3.0 * np.abs(displacement) / (most + ahead)))
