"""
A joint that has failed, and whether it answers again.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.posture import posture_trajectory
from quad_gait.faults.joint_fault import JointFault
from quad_gait.faults.safe_stop import SafeStop
from quad_gait.faults.safe_stop_options import SafeStopOptions
from quad_gait.state.stance import Stance

Array = NDArray[np.float64]

_TRIAL = 0.15
"""Angle by which a joint is turned to see whether it answers [rad]."""

_TRIAL_TIME, _TRIAL_PAUSE = 0.6, 0.3
"""Time for that, and for the joint to follow [s]."""


class JointRecovery:
    """
    A joint that has failed, what the robot does about it, and whether it answers again.

    Parameters
    ----------
    robot : Robot
        The robot.
    fault : JointFault
        What has failed.
    stop : SafeStop
        How the robot comes to a standstill.
    """

    def __init__(self, robot: Robot, fault: JointFault, stop: SafeStop) -> None:
        self._robot = robot
        self.fault = fault
        self.stop = stop
        self._is_asked = False
        self._trial: tuple[float, Array, float] | None = None
        self._has_failed_again = False
        self.is_over = False
        """Whether the joint has been seen to answer."""

    def __str__(self) -> str:
        """Say what is wrong, and what the robot does about it."""
        again = '; tried again, it still does not answer' if self._has_failed_again else ''
        return f'{self.fault}; {self.stop.prediction}; {self.stop}{again}'

    def try_again(self) -> None:
        """Turn the joint a little, as soon as the robot stands still, and see whether it does."""
        self._is_asked = True

    def update(self, now: Stance, commanded: Array) -> JointTrajectory | None:
        """Take a measurement and the commands (4, 3) [rad]; return what is to be done, if any."""
        if not self.stop.is_over or (self._trial is None and not self._is_asked):
            return self.stop.update(now)
        joint = self.fault.joint
        if self._trial is not None:
            end, before, displacement = self._trial
            if now.time < end + _TRIAL_PAUSE:
                return None
            turned = float(now.joint_positions.flat[joint] - before.flat[joint])
            self._trial = None
            self.is_over = turned / displacement > 0.5
            self._has_failed_again = not self.is_over
            return None if self.is_over else self._turn(now, commanded, before)
        self._is_asked = False
        before = np.clip(now.joint_positions, self._robot.lower, self._robot.upper)
        middle = (self._robot.lower.flat[joint] + self._robot.upper.flat[joint]) / 2.0
        displacement = _TRIAL if before.flat[joint] < middle else -_TRIAL
        goal = before.copy()
        goal.flat[joint] += displacement
        trajectory = self._turn(now, commanded, goal)
        self._trial = (trajectory.end, before, displacement)
        return trajectory

    def _turn(self, now: Stance, commanded: Array, goal: Array) -> JointTrajectory:
        # From what is commanded: a joint that hangs free may be far from it.
        return posture_trajectory(
            self._robot,
            commanded.reshape(-1),
            goal,
            now.time + SafeStopOptions().reaction,
            _TRIAL_TIME,
            SafeStopOptions().sample_period,
        )
