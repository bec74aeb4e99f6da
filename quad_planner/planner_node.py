"""
The node that turns an occupancy grid and a goal into a plan of turning points.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_planner.__main__ import main as start

    raise SystemExit(start())

import time
from typing import Any

from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.qos import qos_profile_sensor_data

from quad_common.errors import PlannerError
from quad_common.frames.map_frame import MapFrame
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.map_frame_listener import MapFrameListener
from quad_common.ros.pose_conversions import (
    orientation_from_odometry,
    pose_from_message,
    seconds_from_time,
)
from quad_common.ros.ros_node import STALE, WARN, QuadNode
from quad_common.ros.run_node import run_node
from quad_common.rotations import tilt_from_quaternion
from quad_planner import planner_setup
from quad_planner.map_topics import MapTopics
from quad_planner.parameters import PlannerParameters
from quad_planner.plan_services import PlanService
from quad_planner.planner_actions import PlannerActions
from quad_planner.planner_status import SessionProblems, session_status
from quad_planner.planner_topics import GaitTopics, PlannerTopics
from quad_planner.session.latest_request import LatestRequest
from quad_planner.session.session_ports import Requests
from quad_planner.traffic_topics import TrafficTopics

_HEARTBEAT = 0.5
"""Time between two heartbeats on the wall clock [s]."""


class PlannerNode(QuadNode[PlannerParameters]):
    """Plans when a goal comes, when a map changes, and when the robot leaves its path."""

    def __init__(self, requests: Requests | None = None, **kwargs: Any) -> None:
        super().__init__('planner_node', PlannerParameters, **kwargs)
        p = self.parameters
        self._pace = planner_setup.pace_from_parameters(p)
        # Searches run beside the executor: a newer goal or map must be received meanwhile.
        self._requests = requests or LatestRequest[Any](self.call_soon)
        frame = MapFrame('map', p.correction_time_constant)
        self._topics = PlannerTopics(self, frame)
        self._session = planner_setup.session_from_parameters(
            p, load_robot(p.robot), frame, self._requests, self._topics, time.monotonic
        )
        self._maps = MapTopics(self, self._session)
        self.create_subscription(PoseStamped, 'goal_pose', self._on_goal, 10)
        self.create_subscription(Odometry, p.odom_topic, self._on_odometry, qos_profile_sensor_data)
        self._gait = GaitTopics(self, self._session)
        self._traffic = TrafficTopics(self, self._session, requests)
        self._corrections = MapFrameListener(self, frame, p.correction_timeout)
        self._plans = PlanService(self, self._session, requests)
        self._actions = PlannerActions(self, self._session, lambda: self._pace, requests)
        self.manage(self._session.withdraw_goal)
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_HEARTBEAT, self._on_heartbeat, clock=clock)
        # Once the executor has the node: what is answered before would not be received.
        self._beginning = self.create_timer(0.0, self._on_beginning, clock=clock)
        self._warn_of_costs(p)
        self.update_status()

    def update_status(self) -> None:
        """Report what the planner does, or what it waits for."""
        if (problem := self.clock_check.problem()) is not None:
            self.report(STALE, problem, is_waiting=True)
        elif self.rest_note():
            self.report(WARN, self.rest_note(), is_waiting=True)
        else:
            problems = SessionProblems(
                self._corrections.problem(),
                self._gait.problem(),
                self._maps.refusal,
                self._traffic.problem(),
            )
            self.report_status(session_status(self._session, self.parameters, self._pace, problems))

    def take_parameters(self, parameters: PlannerParameters) -> None:
        """Plan by other parameters."""
        self._pace = planner_setup.change_planner(
            self._session, self.parameters, parameters, self._requests, time.monotonic
        )
        self._actions.take_parameters(parameters)
        self._warn_of_costs(parameters)

    def _warn_of_costs(self, parameters: PlannerParameters) -> None:
        if problem := planner_setup.unheeded_costs(parameters):
            self.get_logger().warning(problem)

    def _on_goal(self, message: PoseStamped) -> None:
        self.check_active()
        try:
            goal = pose_from_message(message.pose, 'goal')
        except PlannerError as error:
            self._session.problem = error
            raise
        self._session.give_goal(message.header.frame_id, goal)

    def _on_odometry(self, message: Odometry) -> None:
        pose, _ = self._corrections.locate(message)
        stamp = seconds_from_time(message.header.stamp)
        self.clock_check.take_stamp(message.header.stamp)
        self._session.take_pose(stamp, pose)
        self._traffic.update(stamp, tilt_from_quaternion(orientation_from_odometry(message)))

    def _on_heartbeat(self) -> None:
        self._topics.publish_heartbeat()
        self._session.tick(time.monotonic(), self.get_clock().now().nanoseconds * 1e-9)

    def _on_beginning(self) -> None:
        self._beginning.cancel()
        self._session.warm_up(time.monotonic)

    def destroy_node(self) -> None:
        """Give up what is being searched, and end."""
        self._requests.close()
        self._traffic.close()
        self._plans.close()
        self._actions.close()
        super().destroy_node()


def main(args: list[str] | None = None) -> int:
    """Run the planner node."""
    return run_node(PlannerNode, args)
