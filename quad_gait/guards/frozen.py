"""
The emergency stop: all joints are held, until it is released and the robot asked to stand.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import EmergencyStopOn, RobotStaysStill
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, PASS, Command, Done, Shared
from quad_gait.behaviours.routine import Routine
from quad_gait.behaviours.wishes import Freeze, Release, Sit, Stand, Wish
from quad_gait.guards.guard import Guard
from quad_gait.state.robot_state import RobotState

Array = NDArray[np.float64]

_FREEZING_TIME = 0.02
"""Time in which an emergency stop brings the joints to rest [s]."""

_RELEASED = 'the emergency stop was released; it waits for stand'


class Frozen(Guard):
    """Holds the joints while the emergency stop is on, and lets nothing begin after it."""

    def __init__(self, shared: Shared, routine: Routine) -> None:
        super().__init__(shared, routine)
        self._is_on = False
        self._waits_for_stand = False

    @property
    def refusal(self) -> str:
        """Why nothing new is to be begun."""
        if self._is_on:
            return 'the emergency stop is on'
        return _RELEASED if self._waits_for_stand else ''

    def take(self, wish: Wish) -> str:
        """Take notice of the emergency stop, its release, and what may follow."""
        if isinstance(wish, Freeze):
            self._is_on = self._waits_for_stand = True
            self._guidance.stop()
            self._guidance.abandon()
            self._routine.forget()
            self._report.limit = ''
            self._report.say(Activity.EMERGENCY_STOP, 'all joints hold until it is released')
            return 'all joints hold until the emergency stop is released'
        if isinstance(wish, Release):
            if not self._is_on:
                return 'the emergency stop was not on'
            self._is_on = False
            # Whoever executes trajectories may have stopped by itself, before the hold that was
            # given out: the joints are where they are measured, and all of them are sound.
            self._joints.forget()
            return (
                'the emergency stop is released; call stand to make the robot stand and walk again'
            )
        if isinstance(wish, Stand):
            if self._is_on:
                raise EmergencyStopOn()
            if self._waits_for_stand:
                self._waits_for_stand = False
                self._report.say(Activity.STANDING, self._guidance.why_standing)
        elif isinstance(wish, Sit) and self._waits_for_stand:
            raise RobotStaysStill(self.refusal)
        return ''

    def update(self, state: RobotState) -> Command | Done:
        """Hold; a robot that falls after the release is no longer this behaviour's."""
        if self._is_on:
            return GO_ON
        if not self._waits_for_stand or state.tilt > self._options.largest_tilt:
            return PASS
        # Not even a joint that fails is a reason to move.
        self._report.say(Activity.STOPPED, _RELEASED)
        return GO_ON

    def hold(self, time: float, measured: Array) -> JointTrajectory:
        """Return what brings all joints, (12,) [rad], to rest at once at a time [s]."""
        gate = self._joints.gate
        position, velocity = gate.command(time, measured)
        # A cubic that only slows down goes on by a third of its velocity times its duration.
        limits = gate.limits
        rest = limits.clip(position + velocity * (_FREEZING_TIME / 3.0))
        return JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=0.0,
            times=np.array([_FREEZING_TIME]),
            positions=rest[None],
            velocities=np.zeros_like(rest)[None],
        )
