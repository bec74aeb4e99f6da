"""
A robot at rest: it decides what to do next.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.planar_pose import STILL
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
        guidance, report = self._guidance, self._report
        guidance.use_new_wishes(state.pose)
        if not state.has_joints:
            report.say(Activity.WAITING, state.problem or 'no joint states yet')
            return GO_ON
        if not state.is_at_rest:
            self._wait_for_rest(state)
            return GO_ON
        self._moving_since = math.inf
        self._still_since = min(self._still_since, state.time)
        is_to_sit = guidance.is_to_sit
        posture = self._crouching if is_to_sit else self._joints.posture
        if not np.abs(state.joints - posture).max() < self._options.posture_tolerance:
            if state.time < self._still_since + _STILL_TIME:
                # It may be in the middle of a cycle that another node began.
                return GO_ON
            return Done(Activity.SITTING_DOWN if is_to_sit else Activity.STANDING_UP)
        if is_to_sit:
            report.say(Activity.SITTING, 'sitting on request; it waits for stand')
            return GO_ON
        return self._next_step(state)

    def _next_step(self, state: RobotState) -> Command | Done:
        guidance = self._guidance
        problem = guidance.lack_of_progress(state)
        if problem is not None:
            guidance.give_up(Activity.BLOCKED, problem)
            return GO_ON
        try:
            step = guidance.next_step(state.time, state.pose, state.motion_pose, STILL)
        except GaitError as error:
            self._report.say(Activity.STOPPED, str(error))
            return GO_ON
        return GO_ON if step is None else Done(Activity.WALKING, step)

    def _wait_for_rest(self, state: RobotState) -> None:
        """Begin nothing while the joints move; give up what never comes to rest."""
        report, guidance = self._report, self._guidance
        self._still_since = math.inf
        self._moving_since = min(self._moving_since, state.time)
        if guidance.has_wish and state.time > self._moving_since + _LONGEST_UNREST:
            guidance.give_up(
                Activity.STOPPED,
                f'the joints have not come to rest for {_LONGEST_UNREST:g} s: '
                f'{state.what_moves}; is something else moving them, or has a drive failed?',
            )
        # A robot may swing a little after a cycle: worth a word only if it lasts.
        elif state.time > self._is_settled_at + _PATIENCE:
            is_said = report.activity is Activity.WAITING
            is_said = is_said and report.reason.startswith(_STILL_MOVING)
            # Once, and not again with every measurement's numbers.
            if report.activity is not Activity.STOPPED and not is_said:
                report.say(Activity.WAITING, f'{_STILL_MOVING}: {state.what_moves}')

    @cached_property
    def _crouching(self) -> Array:
        return crouching_joint_angles(self._robot)
