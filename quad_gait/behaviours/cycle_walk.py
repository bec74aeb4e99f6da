"""
Walking by cycles: each is planned as a whole, at the end of the last one.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, Command, Done, Shared, Walk
from quad_gait.behaviours.guidance import PlannedMotion
from quad_gait.behaviours.wishes import Wish
from quad_gait.following.cycle_planner import CyclePlanner
from quad_gait.following.motion_sequence import ScheduledCycle, schedule
from quad_gait.following.step import Departure, Step
from quad_gait.state.robot_state import RobotState

_FIRST_STAMP = 1e-3
"""Time before which no cycle starts, for a stamp of zero would mean "on arrival" [s]."""

_LAST_MOMENT = 0.05
"""Least time between giving a cycle out and the end of the one that it follows [s]."""


class CycleWalk(Walk):
    """Goes on cycle by cycle until nothing is wanted, or another gait must begin at rest."""

    def __init__(self, shared: Shared) -> None:
        super().__init__(shared)
        options = shared.options
        self._planner = CyclePlanner(
            shared.robot, shared.compensation, options.sample_period, options.tracking_gain
        )
        # When the cycle began whose successor was decided on last.
        self._decided_after = -math.inf

    def take(self, wish: Wish) -> None:
        """Take notice of nothing: the ground is flat."""

    def in_contact_at(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are planned to be down at a time [s], shape (4,)."""
        return self._cycles.in_contact_at(time)

    def footholds(self) -> NDArray[np.float64]:
        """Return the footholds at the end of the last planned cycle, (4, 3) [m]."""
        last = self._cycles.last
        return np.empty((0, 3)) if last is None else last.pose.transform(last.cycle.feet[-1])

    def forget(self) -> None:
        """Know of no cycle."""
        self._cycles.clear()

    def come_to_rest(self, state: RobotState) -> bool:
        """Let the stop follow the cycle that runs; return whether the robot still moves."""
        current = self._cycles.at(state.time)
        if current is not None and current.cycle.exit:
            self._let_stop(current)
            self._decided_after = current.start
        return current is not None or super().come_to_rest(state)

    def begin(self, state: RobotState, done: Done) -> Command | Done:
        """Begin to move."""
        assert done.step is not None
        step, planner, options = done.step, self._planner, self._options
        try:
            planned = planner.begin(self._guidance.gait_pair, step, state.joints)
        except GaitError as error:
            self._report.say(Activity.STOPPED, str(error))
            return GO_ON
        # Back to back with the last cycle, unless that is too late to be received in time.
        earliest = state.time + options.lead_time - planned.cycle.gait.motion_start
        start = max(self._joints.busy_until, earliest, _FIRST_STAMP)
        self._cycles.clear()
        return Command(self._given(schedule(planned, start, state.pose), step, state, start))

    def update(self, state: RobotState) -> Command | Done:
        """Go on shortly before the cycle ends; be done when the robot is at rest."""
        current = self._cycles.at(state.time)
        if current is None or not current.cycle.exit:
            return GO_ON if state.time < self._is_settled_at else Done(Activity.STANDING)
        end = current.end
        is_time = end - self._options.lead_time <= state.time < end - _LAST_MOMENT
        if not is_time or self._decided_after == current.start:
            return GO_ON
        self._decided_after = current.start
        return Command(self._go_on(state, current))

    def _go_on(self, state: RobotState, current: ScheduledCycle) -> JointTrajectory | None:
        """Decide for a robot in motion; None lets the stop follow that was given out."""
        guidance, planner = self._guidance, self._planner
        ahead = planner.end_with_slip(current, state.time)
        end = state.pose @ ahead
        start = Departure(end, state.motion_pose @ ahead, planner.speed, planner.gear)
        try:
            step = guidance.next_in_motion(state, current.pose_at(state.time), start)
            pair = guidance.gait_pair
            if step is None or pair.of(step) is not planner.gear:
                self._let_stop(current)
                return None
            planned = planner.go_on(pair, step, current.cycle)
        except GaitError as error:
            self._report.limit = str(error)
            self._let_stop(current)
            return None
        cycle = planned.cycle
        if cycle.limit and pair.order_of(step) != cycle.gait:
            # Another order of the legs can do more, but is taken up at rest only.
            self._let_stop(current)
            return None
        return self._given(schedule(planned, current.end, end), step, state, state.time)

    def _given(
        self, planned: list[ScheduledCycle], step: Step, state: RobotState, since: float
    ) -> JointTrajectory:
        """Return what was planned as a trajectory, and note it."""
        cycles, cycle = self._cycles, planned[0].cycle
        cycles.replace(*planned)
        self._joints.busy_until = cycles.end
        motion = PlannedMotion(cycle.motion, planned[-1].end_pose, cycle.limit)
        self._guidance.note_begun(state, step, motion)
        return cycles.trajectory(self._robot, since)

    def _let_stop(self, current: ScheduledCycle) -> None:
        """Let the stop that follows this cycle happen: it was given out with it."""
        following = self._cycles.at(current.end)
        if following is not None:
            self._cycles.replace(following)
