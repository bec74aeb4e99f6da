"""
Sensors that have fallen silent: what was given out comes to its end, and nothing begins.
"""

from __future__ import annotations

from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, PASS, Command, Done, Shared
from quad_gait.behaviours.routine import Routine
from quad_gait.guards.guard import Guard
from quad_gait.state.robot_state import RobotState


class Silent(Guard):
    """Waits at rest for the sensors that a walk needs."""

    def __init__(self, shared: Shared, routine: Routine) -> None:
        super().__init__(shared, routine)
        self._lacks_sensors = False

    def update(self, state: RobotState) -> Command | Done:
        """Bring the robot to rest while something is missing."""
        report = self._report
        if not state.problem or not state.has_joints:
            if self._lacks_sensors:
                self._lacks_sensors = False
                report.limit = ''
            return PASS
        self._lacks_sensors = True
        if self._routine.come_to_rest(state):
            report.limit = f'the robot comes to rest: {state.problem}'
        else:
            report.limit = ''
            report.say(Activity.WAITING, state.problem)
        return GO_ON
