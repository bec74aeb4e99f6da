"""
Motions of the body over its feet, one after the other, while one leg does something else.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.body_motion import minimum_jerk

Array = NDArray[np.float64]

_PARTS = tuple(np.linspace(1.0, 0.0, 11).tolist())
"""Fractions of a motion, of which the legs may reach a part only."""

_RISES = (0.0, 0.03, 0.06, 0.09)
"""Heights by which the body may go up where it cannot be levelled as low as it is [m]."""


@dataclass(frozen=True)
class BodyShift:
    """Where the body is to go, and what the lame leg does meanwhile."""

    level: Array
    """Rotation from the body's axes to level ones, shape (3, 3)."""
    feet: Array
    """Where the feet are to be in level axes, relative to the body now, shape (4, 3) [m]."""
    shift: Array
    """Displacement of the body in those axes, shape (3,) [m]."""
    lame: Array
    """Joint positions of the lame leg at the end, shape (3,) [rad]."""
    levels: bool = False
    """Whether the body is made level; then it may rise for that."""


class StopMotions:
    """
    Makes shifts of the body into joint motion, not faster than joints turn.

    Parameters
    ----------
    robot : Robot
        The robot.
    leg : int
        The lame leg's place in ``LEGS``.
    commanded : ndarray, shape (4, 3)
        Where the joints are commanded to be at first [rad].
    sample_period : float
        Time between a trajectory's points [s].
    """

    def __init__(self, robot: Robot, leg: int, commanded: Array, sample_period: float) -> None:
        self._robot = robot
        self._leg = leg
        self._scale = robot.relative_size
        self._sample_period = sample_period
        self._motion = (-np.inf, commanded, commanded)
        self.end = -np.inf
        """When the last motion is done [s]."""
        self.joint_positions: Array = commanded.copy()
        """Where the joints are commanded to end, shape (4, 3) [rad]."""

    def interrupt(self, time: float) -> None:
        """Let the next motion begin where the joints are commanded to be at a time [s]."""
        begin, start, end = self._motion
        done = minimum_jerk(begin, self.end, np.array([time]))[0][0]
        self.joint_positions = start + done * (end - start)

    def move(self, time: float, duration: float, shift: BodyShift) -> JointTrajectory:
        """
        Move the body over its feet, as far as the legs reach.

        Parameters
        ----------
        time : float
            When it begins [s].
        duration : float
            How long it takes at least [s].
        shift : BodyShift
            Where to.
        """
        level_after = np.eye(3) if shift.levels else shift.level
        for part, rise in product(_PARTS, _RISES if shift.levels else (0.0,)):
            rotation = level_after if part > 0.0 else shift.level
            offset = part * shift.shift + np.array([0.0, 0.0, self._scale * rise])
            arms = (shift.feet - offset) @ rotation
            arms[self._leg] = self._robot.neutral_feet[self._leg]
            try:
                end = self._robot.joint_angles(arms)
            except GaitError:
                continue
            end[self._leg] = shift.lame
            return self.turn(time, duration, end)
        end = self.joint_positions.copy()
        end[self._leg] = shift.lame
        return self.turn(time, duration, end)

    def turn(self, time: float, duration: float, end: Array) -> JointTrajectory:
        """
        Turn all joints.

        Parameters
        ----------
        time : float
            When it begins [s].
        duration : float
            How long it takes [s]; longer if the joints are not fast enough.
        end : ndarray, shape (4, 3)
            Where to [rad].
        """
        robot, start = self._robot, self.joint_positions
        change = (end - start).reshape(-1)
        # Minimum jerk is at most 15/8 times as fast as the mean.
        fastest = np.max(np.abs(change) / np.broadcast_to(robot.velocity, (4, 3)).reshape(-1))
        duration = max(duration, 1.875 * float(fastest))
        steps = max(2, round(duration / self._sample_period))
        times = np.linspace(0.0, duration, steps + 1, dtype=np.float64)
        done, rate = minimum_jerk(0.0, duration, times)
        self.joint_positions = end.copy()
        self.end = time + duration
        self._motion = (time, start, end)
        return JointTrajectory(
            joint_names=robot.joint_names,
            stamp=time,
            times=times,
            positions=start.reshape(-1) + done[:, None] * change,
            velocities=rate[:, None] * change,
        )
