"""
What the joints have been commanded, until when, and whether they follow.

All trajectories leave by here: the last gate lets them through, and the fault detector expects
them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.faults.command_gate import CommandGate
from quad_gait.faults.joint_fault import JointFault
from quad_gait.faults.joint_fault_detector import JointFaultDetector
from quad_gait.state.robot_state import RobotState

Array = NDArray[np.float64]


class CommandedJoints:
    """
    Remembers what was given out, and compares it with what the joints do.

    Parameters
    ----------
    robot : Robot
        The robot.
    is_watched : bool
        Whether joints that do not answer are looked for.
    """

    def __init__(self, robot: Robot, is_watched: bool) -> None:
        self._robot = robot
        self._detector = JointFaultDetector(robot)
        self._is_watched = is_watched
        self.gate = CommandGate(robot)
        """The gate through which every trajectory leaves."""
        self.posture: Array = robot.initial_joint_angles
        """Posture in which the robot stands between two motions, shape (4, 3) [rad]."""
        self.busy_until = -math.inf
        """Time at which the last motion is done [s]; minus infinity if it does not count."""
        self.fault: JointFault | None = None
        """The joint that was found at the last measurement not to answer."""
        self.failed: JointFault | None = None
        """The joint that is known not to answer; whoever acts on a fault notes it."""
        self.unfollowed = 0.0
        """Time for which the joints have not followed what was given out [s]."""
        self.late = 0.0
        """Time for which they followed it late, since the beginning [s]."""

    def stand(self) -> None:
        """Let the robot stand in its initial posture from now on."""
        self.posture = self._robot.initial_joint_angles

    def watch(self, state: RobotState) -> None:
        """Compare the joints with their commands; a robot that was moved has none."""
        if state.was_moved:
            self.forget()
        self.fault = None
        if state.joint_positions is not None and not state.problem and self._is_watched:
            self.fault = self._detector.update(
                state.measured_at, state.joint_positions, state.joint_efforts
            )
            self.unfollowed = self._detector.unfollowed
            self.late = self._detector.late

    def forget(self) -> None:
        """Know nothing of what the joints are commanded: something else has moved them."""
        self.gate.forget()
        self.expect_nothing()

    def expect_nothing(self) -> None:
        """Expect no longer that what was given out before is executed."""
        self._detector.forget()
        self.unfollowed = 0.0

    def recover(self) -> None:
        """Trust a joint again that has failed, and stand in the initial posture."""
        self.failed = None
        self.expect_nothing()
        self.stand()

    def give(
        self, trajectory: JointTrajectory, time: float, measured: Array | None
    ) -> JointTrajectory:
        """
        Let a trajectory out.

        Parameters
        ----------
        trajectory : JointTrajectory
            For all joints.
        time : float
            Now [s].
        measured : ndarray, shape (12,), or None
            Where the joints are [rad]; None if nothing is known of them.

        Returns
        -------
        JointTrajectory
            As it is to be given out.

        Raises
        ------
        TrajectoryError
            If the joints could not follow it; then it is not to be given out.
        """
        if measured is None:
            measured = self._robot.initial_joint_angles.reshape(-1)
        given = self.gate.admit(trajectory, time, measured)
        self._detector.expect(given, time)
        return given
