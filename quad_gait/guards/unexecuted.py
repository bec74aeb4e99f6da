"""
Trajectories that are not executed: the robot plans nothing, but for a trial now and then.
"""

from __future__ import annotations

from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, PASS, Command, Done, Shared
from quad_gait.behaviours.routine import Routine
from quad_gait.guards.execution_check import ExecutionCheck
from quad_gait.guards.guard import Guard
from quad_gait.state.robot_state import RobotState


class Unexecuted(Guard):
    """Lets the routine go on for a while at times, to see whether joints follow again."""

    def __init__(self, shared: Shared, routine: Routine) -> None:
        super().__init__(shared, routine)
        self._check = ExecutionCheck()
        # What was given out in the last trial.
        self._tried: JointTrajectory | None = None

    def update(self, state: RobotState) -> Command | Done:
        """Pause or try, for as long as no joint follows."""
        if state.problem:
            # Joints that are not measured say nothing of who moves them.
            return PASS
        check = self._check
        check.update(state.time, self._joints.unfollowed)
        if not check.is_wrong:
            return PASS
        if check.has_tried and self._tried is None:
            # Nothing is to be done, so nothing is expected.
            self._joints.expect_nothing()
            check.end()
            self._report.say(Activity.STANDING, self._guidance.why_standing)
            return GO_ON
        command = GO_ON
        if check.is_pausing:
            self._routine.forget()
            self._tried = None
        else:
            command = self._routine.update(state)
            self._tried = command.trajectory or self._tried
        self._report.say(Activity.NOT_EXECUTED, str(check))
        return command
