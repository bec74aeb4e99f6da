"""
The action that ``gait_node`` serves where nav2_msgs is installed.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

from nav_msgs.msg import Odometry, Path
from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from quad_common.errors import QuadError
from quad_common.plan import Plan, turning_points
from quad_common.ros.goal_actions import GoalAction, GoalPort
from quad_common.ros.ros_node import QuadNode
from quad_common.task_result import FollowCode, TaskOutcome, TaskResult
from quad_gait.gait_topics import GaitTopics
from quad_gait.parameters import GaitParameters
from quad_gait.path_task import PathTask
from quad_gait.state.robot_state import RobotState
from quad_gait.supervisor import Supervisor

try:
    from nav2_msgs.action import FollowPath
except ImportError:
    FollowPath = None

_PERIOD = 0.1
"""Time between two feedbacks on the wall clock [s]."""

NAV2_CONTROLLER = 'FollowPath'
"""What Nav2's configurations and behavior trees call the controller."""


class GaitActions:
    """
    The following of paths as Nav2's action; without nav2_msgs there is none.

    Parameters
    ----------
    node : QuadNode
        The node.
    supervisor : Supervisor
        What decides.
    topics : GaitTopics
        What is published of it.
    read_path : callable
        Returns the plan on the map that a path holds, or None, or raises a QuadError.
    """

    def __init__(
        self,
        node: QuadNode[GaitParameters],
        supervisor: Supervisor,
        topics: GaitTopics,
        read_path: Callable[[Path], Plan | None],
    ) -> None:
        self._node = node
        self._supervisor = supervisor
        self._topics = topics
        self._read_path = read_path
        self._task = PathTask(supervisor)
        self._action: GoalAction | None = None
        self._reported_at = self._updated_at = 0.0
        self._silent_from = time.monotonic()
        if FollowPath is None:
            node.get_logger().info('nav2_msgs is not installed: no actions are served')
            return
        port = GoalPort(self._accept, self._begin, self._cancel)
        self._action = GoalAction(node, FollowPath, 'follow_path', port)
        node.create_timer(_PERIOD, self._look, clock=Clock(clock_type=ClockType.STEADY_TIME))

    @property
    def is_followed(self) -> bool:
        """Whether the plan that is followed came by the action."""
        return self._task.is_followed

    def update(self, state: RobotState, odometry: Odometry) -> None:
        """Look how the task goes, after the supervisor has decided; report on it."""
        action = self._action
        self._updated_at = time.monotonic()
        if action is None or not action.is_active:
            return
        result = self._task.update(state.time)
        if result is not None:
            action.finish(result)
        elif abs(time.monotonic() - self._reported_at) > _PERIOD:
            self._reported_at = time.monotonic()
            speed = odometry.twist.twist.linear
            action.report(
                FollowPath.Feedback(
                    distance_to_goal=self._supervisor.distance_left(state.pose),
                    speed=math.hypot(speed.x, speed.y),
                )
            )

    def _look(self) -> None:
        """Let no goal wait for ever for odometry; a clock that stands still stops waiting, too."""
        action = self._action
        if action is None or not action.is_active or self._node.clock_check.problem() is not None:
            self._silent_from = time.monotonic()
            return
        silence = time.monotonic() - max(self._updated_at, self._silent_from)
        if silence > self._node.parameters.odom_timeout:
            result = self._task.wait(silence)
            if result is not None:
                action.finish(result)
                self._topics.publish_followed()

    def _accept(self, request: Any) -> None:
        """Accept any goal of an active node: what is wrong with it is said in the result."""
        self._node.check_active()

    def _begin(self, request: Any) -> None:
        assert self._action is not None
        try:
            plan = self._read_path(request.path)
        except QuadError as error:
            self._node.report_error(error)
            self._action.finish(_refused(FollowCode.INVALID_PATH, str(error)))
            return
        if request.controller_id not in ('', NAV2_CONTROLLER):
            why = f"there is one controller, '{NAV2_CONTROLLER}'"
            self._action.finish(_refused(FollowCode.INVALID_CONTROLLER, why))
        elif plan is None:
            self._action.finish(_refused(FollowCode.INVALID_PATH, 'the path has no poses'))
        else:
            # A path of Nav2's planners has a pose every few centimetres.
            plan = Plan.through(turning_points(plan.corners), plan.poses[-1].yaw)
            result = self._task.begin(plan)
            if result is None:
                self._topics.publish_unfollowed()
            else:
                self._action.finish(result)

    def _cancel(self) -> None:
        self._task.cancel()
        self._topics.publish_followed()


def _refused(code: FollowCode, message: str) -> TaskResult:
    return TaskResult(TaskOutcome.ABORTED, code, message)
