"""
Trajectories as goals of a joint controller's action, where control_msgs is installed.
"""

from __future__ import annotations

import time
from collections import deque
from functools import partial
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from trajectory_msgs.msg import JointTrajectory

from quad_common.errors import MissingOptionalDependency
from quad_common.ros.guarded_node import GuardedNode
from quad_gait.goal_watch import GoalWatch

try:
    from control_msgs.action import FollowJointTrajectory
    from control_msgs.msg import JointTolerance
except ImportError:
    FollowJointTrajectory = None

_INSTALL = 'sudo apt install ros-jazzy-control-msgs; without a ROS installation: make control'

_ANY = -1.0
"""Tolerance that is none."""

_MOST_UNANSWERED = 50
"""Number of goals that are kept while a server does not answer: rclpy keeps each for good."""


class TrajectoryGoals:
    """
    Sends each trajectory as a goal, which replaces the one before, and watches what becomes of it.

    Parameters
    ----------
    node : GuardedNode
        The node.
    name : str
        Name of the action; empty for none.

    Raises
    ------
    MissingOptionalDependency
        If there is to be one, and control_msgs is not installed.
    """

    def __init__(self, node: GuardedNode, name: str) -> None:
        self._node = node
        self._client: Any = None
        self._watch = GoalWatch(name)
        self._followed: Any = None
        self._sent: deque[Any] = deque()
        if not name:
            return
        if FollowJointTrajectory is None:
            raise MissingOptionalDependency('control_msgs', _INSTALL)
        self._client = ActionClient(node, FollowJointTrajectory, name)

    def send(self, trajectory: JointTrajectory, is_last: bool = False) -> None:
        """
        Send a trajectory, if there is an action.

        Parameters
        ----------
        trajectory : JointTrajectory
            What is to be followed from now on.
        is_last : bool
            Whether the joints must hold, whatever becomes of it: if it is rejected, the goal that
            is followed is canceled.
        """
        if self._client is None:
            return
        if not self._client.server_is_ready():
            self._watch.missed(time.monotonic())
            return
        goal = FollowJointTrajectory.Goal(
            trajectory=trajectory,
            # What a controller does about joints that lag is hold them, perhaps on two feet. The
            # gait sees it too, and stops on four.
            path_tolerance=[
                JointTolerance(name=joint, position=_ANY, velocity=_ANY, acceleration=_ANY)
                for joint in trajectory.joint_names
            ],
        )
        number = self._watch.sent(time.monotonic())
        answer = self._client.send_goal_async(goal)
        self._keep(answer)
        answered = partial(self._on_answer, number, is_last)
        answer.add_done_callback(self._node.guarded(answered, 'an answer to a trajectory'))

    def _keep(self, answer: Any) -> None:
        """Wait for an answer, and no longer for the oldest of too many."""
        while self._sent and self._sent[0].done():
            self._sent.popleft()
        if len(self._sent) == _MOST_UNANSWERED:
            self._sent.popleft().cancel()
        self._sent.append(answer)

    def problem(self) -> str:
        """Say what is wrong with the action; empty if nothing is, or there is none."""
        if self._client is None:
            return ''
        return self._watch.problem(time.monotonic(), self._client.server_is_ready())

    def _on_answer(self, number: int, is_last: bool, answer: Any) -> None:
        if answer.cancelled():
            return
        handle = answer.result()
        if handle is None or not handle.accepted:
            self._watch.rejected(number, time.monotonic())
            if is_last and self._followed is not None:
                self._followed.cancel_goal_async()
            return
        self._watch.accepted(number)
        self._followed = handle
        ended = self._node.guarded(partial(self._on_end, number), 'the end of a trajectory')
        handle.get_result_async().add_done_callback(ended)

    def _on_end(self, number: int, answer: Any) -> None:
        said, now = answer.result(), time.monotonic()
        if said.status == GoalStatus.STATUS_CANCELED:
            self._watch.taken_over(number, now)
        elif said.status != GoalStatus.STATUS_SUCCEEDED:
            self._watch.given_up(number, said.result.error_code, said.result.error_string, now)
