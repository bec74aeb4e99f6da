"""
Moving all joints to a posture: the core of standing up and sitting down.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.behaviour import GO_ON, Behaviour, Command, Done
from quad_gait.cycle.posture import posture_trajectory
from quad_gait.state.robot_state import RobotState

Array = NDArray[np.float64]


class TakePosture(Behaviour):
    """Gives one trajectory out, and is done when it is."""

    def update(self, state: RobotState) -> Command | Done:
        """Wait for the trajectory's end."""
        return GO_ON if state.time < self._is_settled_at else Done(Activity.STANDING)

    def _move_to(self, posture: Array, state: RobotState) -> JointTrajectory:
        """Return the trajectory to a posture, shape (4, 3) [rad]."""
        options, gate = self._options, self._joints.gate
        measured = state.joints.reshape(-1)
        start = gate.limits.clip(measured)
        lead_time = max(options.lead_time, gate.time_to(state.time, measured, start))
        trajectory = posture_trajectory(
            self._robot,
            start,
            posture,
            stamp=state.time + lead_time,
            duration=options.stand_up_time,
            sample_period=options.sample_period,
        )
        self._cycles.clear()
        self._guidance.begun = None
        self._joints.busy_until = trajectory.end
        return trajectory
