"""
Executes joint trajectories as ros2_control's joint_trajectory_controller does.

Joints are matched by name; a new trajectory replaces the old one on arrival; until its
first point the joints go from where they are commanded now to that point; between
points they follow cubics in position and velocity; after the last they hold it.

One thing is smoother. A trajectory may arrive so late that its first point cannot be reached
any more in its time, or lies in the past while the joints are commanded elsewhere. Then the
difference between the two commands fades out, as fast as the joints turn, instead of a jump; one
that starts on arrival starts that much later. Meanwhile commands stay within the joints' range.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import JointNotFound, JointsLeftOut, TrajectoryOver
from quad_common.trajectory.fading import Fading
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_gate import (
    VELOCITY_TOLERANCE,
    JointLimits,
    velocities_between,
)

Array = NDArray[np.float64]

_NEGLIGIBLE = 1e-4
"""Difference between two commands that is no jump [rad]."""

_LEAST_FADING = 0.1
"""Time in which even a small jump fades out [s]."""

LONGEST_FADING = 2.0
"""Time in which even a large jump has faded out, where joints have some speed left for it [s]."""

_LONGER, _SAMPLES = 1.2, 401
"""Factor between durations of fading that are tried, and number of instants that are looked at."""

_PATIENCE = 4.0
"""Factor of the longest fading for trajectories that leave joints no speed for it."""

_BRAKING = 0.06
"""Time in which joints come to rest that are to join a trajectory later, at most [s]."""

_STARTING = 0.1
"""Time in which joints that wait for a trajectory gather its first velocity, at most [s]."""

_DELAYS = tuple(0.01 * number for number in range(26))
"""Times by which a trajectory without a time of its own may begin later, in motion [s]."""

_LEAST_ROOM = 0.25
"""Fraction of a joint's velocity limit that is left for fading, however fast the trajectory."""


class _Stop(NamedTuple):
    """Where joints come to rest before they join a trajectory."""

    time: float
    """Time when they do [s]."""
    position: Array
    """Their positions then, shape (n,) [rad]."""


class TrajectoryExecutor:
    """
    Turns the current trajectory into a command for each instant.

    Parameters
    ----------
    joint_names : tuple of str
        The robot's joints, in the order of its commands.
    positions : ndarray, shape (n,)
        What to hold until a trajectory comes [rad].
    limits : JointLimits, optional
        What the joints are able to do, in the same order; without them commands may jump.
    """

    def __init__(
        self,
        joint_names: tuple[str, ...],
        positions: Array,
        limits: JointLimits | None = None,
    ) -> None:
        self._joint_names = joint_names
        self._limits = limits
        self.hold(positions)

    def hold(self, positions: Array) -> None:
        """Drop the trajectory and hold these positions, shape (n,) [rad]."""
        still = np.zeros_like(positions)
        self._times = np.array([0.0])
        self._positions = np.array([positions], dtype=float)
        self._coefficients: Array = np.zeros((0, 4, len(positions)))
        self._segment = 0
        self._still = still
        self._fading: Fading | None = None
        self._joined_at = -np.inf

    @property
    def end(self) -> float:
        """When the last point of the trajectory is, or was, reached [s]."""
        return float(self._times[-1])

    def accept(self, trajectory: JointTrajectory, now: float) -> bool:
        """
        Replace the current trajectory.

        Parameters
        ----------
        trajectory : JointTrajectory
            It must move every joint; their order is free.
        now : float
            Current time [s].

        Returns
        -------
        bool
            Whether it fits what the joints are commanded now; if not, the difference fades out.

        Raises
        ------
        JointNotFound
            If it names a joint that the robot does not have.
        TrajectoryError
            If it leaves out a joint, or has ended already.
        """
        times, positions, velocities = self._in_order(trajectory, now)
        position, velocity = self.command(now)
        fading, followed = self._fading, self._followed(now)[0]
        is_ahead = bool(times[0] > now)
        fits = not is_ahead or self._reaches(
            times[0] - now, position, velocity, positions[0], velocities[0]
        )
        joins = is_ahead and (fits or trajectory.stamp <= 0.0)
        joined_at = times[0]
        if joins and not fits:
            # It has no time of its own: it begins as soon as its first point can be reached.
            delay = self.delay_of(trajectory, now)
            if np.isfinite(delay):
                times = times + delay
                joined_at = times[0]
            else:
                times, positions, velocities, joined_at = self._joined_from_rest(
                    now, (position, velocity), times, positions, velocities
                )
        if joins:
            times = np.concatenate([[now], times])
            positions = np.vstack([position, positions])
            velocities = np.vstack([velocity, velocities])
        elif is_ahead:
            times, positions, velocities = self._waiting(now, times, positions, velocities)
        self._times = times
        self._positions = positions
        self._coefficients = _cubics(times, positions, velocities)
        self._segment = 0
        self._fading = None
        self._joined_at = -np.inf if fits else joined_at
        limits = self._limits
        if limits is None or joins:
            return fits
        after, _ = self.command(now)
        if _is_same(after, followed):
            # It goes on with what runs, and so does what is fading out.
            self._fade(fading)
            return fits
        if _is_same(after, position):
            return fits
        self._fade(self._fading_from(now, position - after, limits.velocity))
        self._joined_at = max(self._joined_at, joined_at)
        return False

    def delay_of(self, trajectory: JointTrajectory, now: float) -> float:
        """
        Return how much later a trajectory is to begin so that its first point can be reached.

        Parameters
        ----------
        trajectory : JointTrajectory
            As :meth:`accept` takes it.
        now : float
            Time at which it arrives [s].

        Returns
        -------
        float
            0 if it has a time of its own, or needs no delay; infinity if it cannot be begun in
            motion [s].
        """
        if trajectory.stamp > 0.0 or trajectory.times[0] <= 0.0:
            return 0.0
        times, positions, velocities = self._in_order(trajectory, now)
        ends = *self.command(now), positions[0], velocities[0]
        h = float(times[0]) - now
        return next((delay for delay in _DELAYS if self._reaches(h + delay, *ends)), np.inf)

    def _fade(self, fading: Fading | None) -> None:
        """Let a difference fade out, if there is one."""
        self._fading = fading
        self._joined_at = -np.inf if fading is None else fading.end

    def _in_order(self, trajectory: JointTrajectory, now: float) -> tuple[Array, Array, Array]:
        """Return times, positions and velocities of the joints in order; raise as `accept`."""
        positions, velocities = trajectory.positions, trajectory.velocities
        if trajectory.joint_names != self._joint_names:
            for name in trajectory.joint_names:
                if name not in self._joint_names:
                    raise JointNotFound(name, self._joint_names)
            missing = [name for name in self._joint_names if name not in trajectory.joint_names]
            if missing:
                raise JointsLeftOut(tuple(missing))
            order = [trajectory.joint_names.index(name) for name in self._joint_names]
            positions, velocities = positions[:, order], velocities[:, order]
        start = trajectory.stamp if trajectory.stamp > 0.0 else now
        times = start + trajectory.times
        if times[-1] <= now:
            raise TrajectoryOver(float(times[-1]), now)
        return times, positions, velocities

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
        position, velocity = self._followed(time)
        if time >= self._joined_at:
            self._fading = None
            return position, velocity
        if self._fading is not None and time < self._fading.end:
            offset, rate = self._fading.at(time)
            position, velocity = position + offset, velocity + rate
        if self._limits is None:
            return position, velocity
        within = self._limits.clip(position)
        return within, np.where(within == position, velocity, 0.0)

    def _followed(self, time: float) -> tuple[Array, Array]:
        """Return what the trajectory itself says."""
        if time >= self._times[-1]:
            return self._positions[-1], self._still
        while self._segment > 0 and time < self._times[self._segment]:
            self._segment -= 1
        while time >= self._times[self._segment + 1]:
            self._segment += 1
        a, b, c, d = self._coefficients[self._segment]
        s = time - self._times[self._segment]
        return a + s * (b + s * (c + s * d)), b + s * (2.0 * c + 3.0 * s * d)

    def _fading_from(self, now: float, offset: Array, limits: Array) -> Fading:
        """Let a difference fade out beside the trajectory, as fast as leaves joints their speed."""
        times, own = self._speeds_after(now, LONGEST_FADING)
        room = np.maximum(limits - np.abs(own).max(axis=0), _LEAST_ROOM * limits)
        # Minimum jerk is at most 15/8 times as fast as the mean.
        duration = 1.875 * float(np.max(np.abs(offset) / room))
        duration = min(max(_LEAST_FADING, duration), LONGEST_FADING)
        best, least = duration, np.inf
        while duration <= _PATIENCE * LONGEST_FADING:
            if duration > LONGEST_FADING and len(times) == _SAMPLES:
                # The trajectory is as fast as joints are, all the time.
                times, own = self._speeds_after(now, _PATIENCE * LONGEST_FADING)
            s = np.minimum((times - now) / duration, 1.0)[:, None]
            rates = own - 30.0 * s * s * (1.0 - s) ** 2 * (offset / duration)
            most = float(np.max(np.abs(rates) / limits))
            if most < least:
                best, least = duration, most
            if most <= 1.0 + VELOCITY_TOLERANCE:
                break
            duration *= _LONGER
        return Fading(now, best, offset)

    def _speeds_after(self, now: float, span: float) -> tuple[Array, Array]:
        """Return times while a difference may fade, (m,), and the velocities then, (m, n)."""
        count = round((_SAMPLES - 1) * span / LONGEST_FADING) + 1
        times = np.linspace(now, now + span, count, dtype=np.float64)
        segments = np.clip(np.searchsorted(self._times, times, 'right') - 1, 0, None)
        running = segments < len(self._coefficients)
        _, b, c, d = np.moveaxis(self._coefficients[segments[running]], 1, 0)
        s = (times[running] - self._times[segments[running]])[:, None]
        velocities: Array = np.zeros((len(times), len(self._still)))
        velocities[running] = b + s * (2.0 * c + 3.0 * s * d)
        return times, velocities

    def _later(
        self, now: float, position: Array, velocity: Array, times: Array, first: Array
    ) -> tuple[Array, _Stop | None]:
        """
        Return times at which a trajectory can be joined, and where joints come to rest before.

        A cubic that begins with a velocity, and lasts for longer than that takes to the first
        point, goes on beyond it: where a joint would, all come to rest first.
        """
        assert self._limits is not None
        fastest, h, way = self._limits.velocity, times[0] - now, first - position
        room = np.maximum(fastest - np.abs(velocity), _LEAST_ROOM * fastest)
        needed = max(h, float(np.max(3.0 * np.abs(way) / room)))
        ahead = needed * velocity * np.where(way == 0.0, 1.0, np.sign(way))
        if np.all((ahead >= -_NEGLIGIBLE) & (ahead <= 3.0 * np.abs(way) + _NEGLIGIBLE)):
            return times + (needed - h), None
        braking = min(h, _BRAKING)
        stop = self._limits.clip(position + velocity * (braking / 3.0))
        rest = max(_LEAST_FADING, float(np.max(1.5 * np.abs(first - stop) / fastest)))
        return times + (braking + rest - h), _Stop(now + braking, stop)

    def _waiting(
        self, now: float, times: Array, positions: Array, velocities: Array
    ) -> tuple[Array, Array, Array]:
        """Begin a trajectory now, at rest, and wait for it where it starts from."""
        starting = min(times[0] - now, _STARTING)
        place = self._starting_place(positions[0], velocities[0], starting)
        begin = [now] if starting == times[0] - now else [now, times[0] - starting]
        return (
            np.concatenate([begin, times]),
            np.vstack([*([place] * len(begin)), positions]),
            np.vstack([*([self._still] * len(begin)), velocities]),
        )

    def _joined_from_rest(
        self, now: float, command: tuple[Array, Array], times: Array, positions: Array,
        velocities: Array,
    ) -> tuple[Array, Array, Array, float]:  # fmt: skip
        """Let a trajectory begin much later, at rest; return when it is joined, too [s]."""
        is_moving = bool(velocities[0].any())
        if is_moving:
            place = self._starting_place(positions[0], velocities[0], _STARTING)
            times = np.concatenate([times[:1], times + _STARTING])
            positions = np.vstack([place, positions])
            velocities = np.vstack([self._still, velocities])
        times, stop = self._later(now, *command, times, positions[0])
        joined_at = float(times[int(is_moving)])
        if stop is not None:
            times = np.concatenate([[stop.time], times])
            positions = np.vstack([stop.position, positions])
            velocities = np.vstack([self._still, velocities])
        return times, positions, velocities, joined_at

    def _starting_place(self, position: Array, velocity: Array, starting: float) -> Array:
        """Return from where joints that rest gather a velocity on a straight way, (n,) [rad]."""
        assert self._limits is not None
        return self._limits.clip(position - velocity * (starting / 2.0))

    def _reaches(self, h: float, p0: Array, v0: Array, p1: Array, v1: Array) -> bool:
        """Return whether the joints get from one state to another in a time [s], within range."""
        limits = self._limits
        if limits is None:
            return True
        # As the gate does: what passes there is not delayed here.
        ends = np.array([0.0, h]), np.stack([limits.clip(p0), p1]), np.stack([v0, v1])
        between = np.abs(velocities_between(*ends)[0])
        fastest = np.maximum(np.abs(v0), np.abs(v1))
        limit = np.maximum((1.0 + VELOCITY_TOLERANCE) * limits.velocity, fastest)
        return bool(np.all(between <= limit)) and limits.keeps_range(*ends)


def _is_same(a: Array, b: Array) -> bool:
    return float(np.max(np.abs(a - b))) <= _NEGLIGIBLE


def _cubics(times: Array, positions: Array, velocities: Array) -> Array:
    """Coefficients of the cubic in each interval, shape (m - 1, 4, n)."""
    h = np.diff(times)[:, None]
    p0, p1 = positions[:-1], positions[1:]
    v0, v1 = velocities[:-1], velocities[1:]
    slope = (p1 - p0) / h
    bend = (3.0 * slope - 2.0 * v0 - v1) / h
    return np.stack([p0, v0, bend, (v0 + v1 - 2.0 * slope) / h**2], axis=1)
