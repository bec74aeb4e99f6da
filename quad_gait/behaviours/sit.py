"""
Lowering the body as far as it goes.
"""

from __future__ import annotations

from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import Command, Done
from quad_gait.behaviours.take_posture import TakePosture
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.state.robot_state import RobotState


class Sit(TakePosture):
    """Moves all joints to the crouching posture."""

    def begin(self, state: RobotState, done: Done) -> Command | Done:
        """Sit down from wherever the joints are."""
        trajectory = self._move_to(crouching_joint_angles(self._robot), state)
        # From there the robot stands up to its initial posture, however it stood before.
        self._joints.posture = self._robot.initial_joint_angles
        self._report.say(Activity.SITTING_DOWN, 'sitting down on request')
        return Command(trajectory)
