"""
The actions of ``planner_node``.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_common.ros.ros_node import QuadNode
from quad_planner.navigation_actions import IS_INSTALLED, NavigationActions
from quad_planner.parameters import PlannerParameters
from quad_planner.path_actions import PathActions
from quad_planner.session.latest_request import LatestRequest
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.session_ports import Requests


class PlannerActions:
    """
    Navigation and planning as Nav2's actions; without nav2_msgs there are none.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : PlanningSession
        Its session.
    pace : callable
        Returns the gait's pace, or None where it is not known.
    requests : Requests, optional
        The part that works on searches which are not for the robot; one of their own if not given.
    """

    def __init__(
        self,
        node: QuadNode[PlannerParameters],
        session: PlanningSession,
        pace: Callable[[], WalkingTimeModel | None],
        requests: Requests | None = None,
    ) -> None:
        self._navigation: NavigationActions | None = None
        # Paths that are asked for do not end the search for the robot's, nor the reverse.
        self._requests = requests or LatestRequest[Any](node.call_soon)
        if not IS_INSTALLED:
            node.get_logger().info('nav2_msgs is not installed: no actions are served')
            return
        self._navigation = NavigationActions(node, session, pace)
        PathActions(node, session, self._requests)

    def take_parameters(self, parameters: PlannerParameters) -> None:
        """Go on under other conditions."""
        if self._navigation is not None:
            self._navigation.take_parameters(parameters)

    def close(self) -> None:
        """Give up what is being searched."""
        self._requests.close()
