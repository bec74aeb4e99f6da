"""
A robot at rest: it decides what to do next.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, Behaviour, Command, Done, Shared
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.state.robot_state import RobotState

Array = NDArray[np.float64]

_PATIENCE = 1.0
"""Time for the joints to come to rest after a cycle [s]."""

_LONGEST_UNREST = 8.0
"""Time after which joints that have not come to rest never will: the robot gives up [s]."""

_STILL_TIME = 0.5
"""Time for which a robot out of its posture must be still before it is made to stand up [s]."""

_STILL_MOVING = 'the joints are still moving'


class Standing(Behaviour):
    """Waits for rest, for the posture and for a step to take; says why it waits."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        self._still_since = math.inf
        self._moving_since = math.inf

    def forget(self) -> None:
        """Know nothing of how long the joints have moved, or been still."""
        self._still_since = self._moving_since = math.inf

    def update(self, state: RobotState) -> Command | Done:
        """Hand over to what is next, if it is time."""
        if state.time < self._is_settled_at:
            return GO_ON
        is_to_sit = self._guidance.is_to_sit
        is_still = state.has_joints and state.is_at_rest
        is_in_posture = is_still and self._is_in_posture(state)
        is_ready = is_in_posture and not is_to_sit
        try:
            step = self._guidance.next_at_rest(state, is_ready)
        except GaitError as error:
            self._report.say(Activity.STOPPED, str(error))
            step = None
        if is_ready:
            self._note_rest(state)
            return GO_ON if step is None else Done(self._guidance.gaits.manner_of(step), step)
        if not state.has_joints:
            self._report.say(Activity.WAITING, state.problem or 'no joint states yet')
            return GO_ON
        if not is_still:
            self._wait_for_rest(state)
            return GO_ON
        self._note_rest(state)
        if is_in_posture:
            self._report.say(Activity.SITTING, 'sitting on request; it waits for stand')
            return GO_ON
        if state.time < self._still_since + _STILL_TIME:
            # It may be in the middle of a cycle that another node began.
            return GO_ON
        return Done(Activity.SITTING_DOWN if is_to_sit else Activity.STANDING_UP)

    def _is_in_posture(self, state: RobotState) -> bool:
        """Return whether the robot, which is still, is as it should be between two motions."""
        posture = self._crouching if self._guidance.is_to_sit else self._joints.posture
        return bool(np.abs(state.joints - posture).max() < self._options.posture_tolerance)

    def _note_rest(self, state: RobotState) -> None:
        self._moving_since = math.inf
        self._still_since = min(self._still_since, state.time)

    def _wait_for_rest(self, state: RobotState) -> None:
        """Begin nothing while the joints move; give up what never comes to rest."""
        report = self._report
        self._still_since = math.inf
        self._moving_since = min(self._moving_since, state.time)
        if state.time > self._moving_since + _LONGEST_UNREST:
            reason = (
                f'the joints have not come to rest for {_LONGEST_UNREST:g} s: '
                f'{state.what_moves}; is something else moving them, or has a drive failed?'
            )
            if self._guidance.give_up_going(reason):
                return
        # A robot may swing a little after a cycle: worth a word only if it lasts.
        if state.time > self._is_settled_at + _PATIENCE:
            is_said = report.activity is Activity.WAITING
            is_said = is_said and report.reason.startswith(_STILL_MOVING)
            # Once, and not again with every measurement's numbers.
            if report.activity is not Activity.STOPPED and not is_said:
                report.say(Activity.WAITING, f'{_STILL_MOVING}: {state.what_moves}')

    @cached_property
    def _crouching(self) -> Array:
        return crouching_joint_angles(self._robot)
