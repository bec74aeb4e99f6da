"""
A robot that has fallen: its joints hold where they are, until it is asked to stand.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, PASS, Command, Done, Shared
from quad_gait.behaviours.routine import Routine
from quad_gait.behaviours.wishes import Stand, Wish
from quad_gait.guards.guard import Guard
from quad_gait.state.robot_state import RobotState

_LEAST_DELAY = 0.05
"""Least time after which the joints are to hold [s]."""

_TELLING = math.radians(30.0)
"""Change of the tilt from that which was said last, beyond which the new one is said [rad]."""


class Fallen(Guard):
    """Stops all joints where they are, once."""

    def __init__(self, shared: Shared, routine: Routine) -> None:
        super().__init__(shared, routine)
        self._has_fallen = False
        self._said = self._tilt = 0.0

    def take(self, wish: Wish) -> str:
        """Let the robot stand up again, if it is upright."""
        if not isinstance(wish, Stand):
            return ''
        self._has_fallen = False
        if self._tilt <= self._options.largest_tilt:
            return ''
        return (
            f'the robot stays as it is while its body is tilted by '
            f'{math.degrees(self._tilt):.0f} degrees: set it upright, then call stand again'
        )

    def update(self, state: RobotState) -> Command | Done:
        """Stop the joints when the body tilts too far; then wait."""
        self._tilt = state.tilt
        if state.tilt > self._options.largest_tilt:
            return self._fall(state)
        if not self._has_fallen:
            return PASS
        self._report.say(
            Activity.FALLEN, 'the robot has fallen and is upright again; it waits for stand'
        )
        return GO_ON

    def _fall(self, state: RobotState) -> Command:
        is_new = not self._has_fallen
        self._has_fallen = True
        failed = self._joints.failed
        self._guidance.abandon()
        # A body that rolls on is not told of at every measurement: each new sentence is logged.
        if is_new or abs(state.tilt - self._said) > _TELLING:
            self._said = state.tilt
        self._report.say(
            Activity.FALLEN,
            f'the robot has fallen: the body is tilted by {math.degrees(self._said):.0f} degrees'
            + ('' if failed is None else f'; {failed}'),
        )
        self._routine.forget()
        return Command(self._held(state)) if is_new and state.has_joints else GO_ON

    def _held(self, state: RobotState) -> JointTrajectory:
        gate, measured = self._joints.gate, state.joints.reshape(-1)
        target = gate.limits.clip(measured)
        duration = gate.time_to(state.time, measured, target)
        return JointTrajectory(
            joint_names=self._robot.joint_names,
            stamp=state.time + max(_LEAST_DELAY, duration),
            times=np.array([0.0]),
            positions=target[None],
            velocities=np.zeros_like(target)[None],
        )
