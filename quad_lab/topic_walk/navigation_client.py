"""
A client of Nav2's actions that does what nav2_simple_commander's BasicNavigator does.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav2_msgs.action import (
    ComputePathThroughPoses,
    ComputePathToPose,
    FollowPath,
    NavigateThroughPoses,
    NavigateToPose,
)
from nav_msgs.msg import Path
from rclpy.action import ActionClient
from rclpy.node import Node

from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_message

_PATIENCE = 60.0
"""Time on the wall clock in which a server has to be there, and to answer [s]."""


class NavigationClient:
    """
    Gives goals to a robot's action servers, one at a time, and waits for what they answer.

    Parameters
    ----------
    node : Node
        The node that it makes its clients for.
    spin_once : callable
        Runs callbacks of the node for a moment; it may raise if something has ended.
    """

    def __init__(self, node: Node, spin_once: Callable[[], object]) -> None:
        self._node = node
        self._spin_once = spin_once
        self._clients: dict[str, ActionClient] = {}
        self._handle: Any = None
        self._result: Any = None
        self.feedback: list[Any] = []
        """Feedback about the goal that was given last."""

    def go_to_pose(self, pose: Pose2D, frame: str = 'map') -> bool:
        """Give a goal to ``navigate_to_pose``; return whether it is accepted."""
        goal = NavigateToPose.Goal(pose=stamped(pose, frame))
        return self._give(NavigateToPose, 'navigate_to_pose', goal)

    def go_through_poses(self, poses: Sequence[Pose2D]) -> bool:
        """Give a goal to ``navigate_through_poses``; return whether it is accepted."""
        goal = NavigateThroughPoses.Goal(poses=[stamped(pose) for pose in poses])
        return self._give(NavigateThroughPoses, 'navigate_through_poses', goal)

    def follow_path(self, path: Path, controller_id: str = '') -> bool:
        """Give a goal to ``follow_path``; return whether it is accepted."""
        goal = FollowPath.Goal(path=path, controller_id=controller_id)
        return self._give(FollowPath, 'follow_path', goal)

    def get_path(
        self, goals: Sequence[Pose2D], start: Pose2D | None = None, planner_id: str = ''
    ) -> Any:
        """Return the result of planning through poses, from the robot or from a start."""
        where = {} if start is None else {'start': stamped(start), 'use_start': True}
        if len(goals) == 1:
            goal = ComputePathToPose.Goal(goal=stamped(goals[0]), planner_id=planner_id, **where)
            self._give(ComputePathToPose, 'compute_path_to_pose', goal)
        else:
            goal = ComputePathThroughPoses.Goal(
                goals=[stamped(pose) for pose in goals], planner_id=planner_id, **where
            )
            self._give(ComputePathThroughPoses, 'compute_path_through_poses', goal)
        self.wait_until(self.is_complete)
        return self.result

    @property
    def is_given(self) -> bool:
        """Whether the goal that was given last was accepted."""
        return self._handle is not None

    def is_complete(self) -> bool:
        """Return whether the goal that was given last has ended."""
        return self._result is not None and bool(self._result.done())

    @property
    def status(self) -> int:
        """Status of the goal that has ended, of action_msgs/GoalStatus."""
        return int(self._result.result().status)

    @property
    def result(self) -> Any:
        """Result of the goal that has ended."""
        return self._result.result().result

    def result_future(self) -> Any:
        """Return the future of the result of the goal that was given last."""
        return self._result

    def cancel(self) -> bool:
        """Cancel the goal; return whether it is being canceled."""
        future = self._handle.cancel_goal_async()
        self.wait_until(future.done)
        return bool(future.result().goals_canceling)

    def wait_until(self, condition: Callable[[], bool], patience: float = _PATIENCE) -> None:
        """Run callbacks until a condition holds; TimeoutError after some time on the wall clock."""
        deadline = time.monotonic() + patience
        while not condition():
            self._spin_once()
            if time.monotonic() > deadline:
                raise TimeoutError(f'nothing was answered in {patience:g} s')

    def _give(self, action_type: Any, name: str, goal: Any) -> bool:
        if name not in self._clients:
            self._clients[name] = ActionClient(self._node, action_type, name)
        client = self._clients[name]
        self.wait_until(client.server_is_ready)
        self.feedback = feedback = []
        self._handle = self._result = None
        future = client.send_goal_async(goal, lambda message: feedback.append(message.feedback))
        self.wait_until(future.done)
        handle = future.result()
        if not handle.accepted:
            return False
        self._handle, self._result = handle, handle.get_result_async()
        return True


def stamped(pose: Pose2D, frame: str = 'map') -> PoseStamped:
    """Write a pose with its frame."""
    message = PoseStamped(pose=pose_message(pose))
    message.header.frame_id = frame
    return message
