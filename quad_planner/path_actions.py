"""
Planning as Nav2's actions: what ``planner_node`` serves where nav2_msgs is installed.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any

from quad_common.errors import PlannerError, QuadError
from quad_common.plan import Plan
from quad_common.ros.goal_actions import GoalAction, GoalPort
from quad_common.ros.pose_conversions import duration_from_seconds
from quad_common.ros.ros_node import QuadNode
from quad_planner.navigation.path_request import check_planner, path_work
from quad_planner.parameters import PlannerParameters
from quad_planner.ros_conversions import goals_of, path_message, placed_pose
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.session_ports import Requests

try:
    from nav2_msgs.action import ComputePathThroughPoses, ComputePathToPose
except ImportError:
    ComputePathThroughPoses = ComputePathToPose = None

_THROUGH = 100
"""By so much the codes of ComputePathThroughPoses are higher than those of ComputePathToPose."""

_UNKNOWN_ERROR = 200


class PathActions:
    """
    Planning as Nav2's planner server serves it; the robot does not move for it.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : PlanningSession
        Its session.
    requests : Requests
        The part that works on these searches.
    """

    def __init__(
        self, node: QuadNode[PlannerParameters], session: PlanningSession, requests: Requests
    ) -> None:
        self._node = node
        self._session = session
        self._requests = requests
        to_pose = GoalPort(self._accept, partial(self._begin, 0), partial(self._cancel, 0))
        through = GoalPort(self._accept, partial(self._begin, 1), partial(self._cancel, 1))
        self._actions = (
            GoalAction(node, ComputePathToPose, 'compute_path_to_pose', to_pose),
            GoalAction(node, ComputePathThroughPoses, 'compute_path_through_poses', through),
        )

    def _accept(self, request: Any) -> None:
        """Accept any goal of an active node: what is wrong with it is said in the result."""
        self._node.check_active()

    def _begin(self, index: int, request: Any) -> None:
        self._actions[1 - index].preempt()
        action, began = self._actions[index], time.monotonic()

        def done(result: Callable[[], Plan]) -> None:
            self._answer(action, began, result)

        try:
            check_planner(request.planner_id, self._node.parameters.method)
            start = placed_pose(request.start, 'start') if request.use_start else None
            work = path_work(self._session, start, goals_of(request))
        except QuadError as error:
            self._refuse(action, error)
            return
        self._requests.submit(work, done)

    def _cancel(self, index: int) -> None:
        self._requests.submit(lambda: None, lambda result: result())
        self._actions[index].canceled(self._actions[index].type.Result())

    def _answer(self, action: GoalAction, began: float, result: Callable[[], Plan]) -> None:
        try:
            plan = result()
        except QuadError as error:
            self._refuse(action, error)
            return
        stamp = self._node.get_clock().now().to_msg()
        action.succeed(
            action.type.Result(
                path=path_message(plan, self._session.map.frame.name, stamp),
                planning_time=duration_from_seconds(time.monotonic() - began),
            )
        )

    def _refuse(self, action: GoalAction, error: QuadError) -> None:
        self._node.report_error(error)
        code = error.code if isinstance(error, PlannerError) else _UNKNOWN_ERROR
        offset = 0 if action is self._actions[0] else _THROUGH
        action.abort(action.type.Result(error_code=code + offset, error_msg=str(error)))
