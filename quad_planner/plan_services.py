"""
The services of ``planner_node``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from nav_msgs.srv import GetPlan

from quad_common.errors import QuadError
from quad_common.plan import Plan
from quad_common.ros.ros_node import QuadNode
from quad_planner.navigation.path_request import path_work
from quad_planner.ros_conversions import ends_from_request, path_message
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.request_queue import RequestQueue
from quad_planner.session.session_ports import Requests


class PlanService:
    """
    Answers requests for plans, each when its search has ended: the node goes on meanwhile.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : PlanningSession
        Its session.
    requests : Requests, optional
        The part that works on these searches; one of its own if not given.
    """

    def __init__(
        self, node: QuadNode[Any], session: PlanningSession, requests: Requests | None = None
    ) -> None:
        self._node, self._session = node, session
        self._requests = requests or RequestQueue[Plan](node.call_soon)
        service = node.create_service(GetPlan, 'get_plan', self._on_request)
        self._send: Callable[[Any, Any], None] = service.send_response
        # Executors hand it what the callback returns; rclpy knows no other answer than that, and
        # its events executor no coroutines.
        service.send_response = self._send_when_found

    def close(self) -> None:
        """Give up what is being searched."""
        self._requests.close()

    def _on_request(
        self, request: GetPlan.Request, response: GetPlan.Response
    ) -> GetPlan.Response | Callable[[], Plan]:
        """Return the search, or an empty path with the reason on diagnostics."""
        try:
            start, goal = ends_from_request(request)
            return path_work(self._session, start, (goal,))
        except QuadError as error:
            return self._refused(error)

    def _send_when_found(
        self, response: GetPlan.Response | Callable[[], Plan], header: Any
    ) -> None:
        if isinstance(response, GetPlan.Response):
            self._send(response, header)
            return
        try:
            self._requests.submit(response, partial(self._answer, header))
        except QuadError as error:
            self._send(self._refused(error), header)

    def _answer(self, header: Any, result: Callable[[], Plan]) -> None:
        try:
            response = self._response(result())
        except QuadError as error:
            response = self._refused(error)
        except Exception:
            # A defect is reported by the net around this; who asked is answered all the same.
            self._send(self._response(None), header)
            raise
        self._send(response, header)

    def _refused(self, error: QuadError) -> GetPlan.Response:
        self._node.report_error(error)
        return self._response(None)

    def _response(self, plan: Plan | None) -> GetPlan.Response:
        stamp = self._node.get_clock().now().to_msg()
        return GetPlan.Response(plan=path_message(plan, self._session.map.frame.name, stamp))
