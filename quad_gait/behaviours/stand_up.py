"""
Regaining the posture in which the robot stands.
"""

from __future__ import annotations

import numpy as np

from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import Command, Done
from quad_gait.behaviours.take_posture import TakePosture
from quad_gait.state.robot_state import RobotState


class StandUp(TakePosture):
    """Moves all joints to the posture between two motions."""

    def begin(self, state: RobotState, done: Done) -> Command | Done:
        """Stand up from wherever the joints are."""
        posture = self._joints.posture
        trajectory = self._move_to(posture, state)
        away = np.abs(state.joints - posture).max()
        self._report.say(
            Activity.STANDING_UP, f'{away:.2f} rad from the initial posture: regaining it'
        )
        return Command(trajectory)
