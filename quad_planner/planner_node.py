"""
The node that turns an occupancy grid and a goal into a plan of turning points.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_planner.__main__ import main as start

    raise SystemExit(start())

import time
from collections.abc import Callable
from typing import Any

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetPlan
from rclpy.clock import Clock
from rclpy.clock_type import ClockType
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from quad_common.errors import PlannerError, QuadError
from quad_common.frames.map_frame import MapFrame
from quad_common.plan import LONGEST_PLAN, Plan
from quad_common.robot.robot import load_robot
from quad_common.ros.height_map_conversions import height_map_from_message
from quad_common.ros.map_frame_listener import MapFrameListener
from quad_common.ros.pose_conversions import (
    most_plan_bytes,
    nanoseconds_from_time,
    plan_from_message,
    pose_from_message,
    seconds_from_time,
)
from quad_common.ros.ros_node import OK, STALE, WARN, QuadNode
from quad_common.ros.run_node import run_node
from quad_planner.grid.inflation import combined_obstacles
from quad_planner.grid.traversability import GroundLimits
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import pace_from_parameters, planner_from_parameters
from quad_planner.ros_conversions import grid_from_message, path_message, plan_markers
from quad_planner.session.latest_request import LatestRequest
from quad_planner.session.planning_map import PlanningMap
from quad_planner.session.planning_session import PlanningSession, SessionOptions

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_EVERY_PLAN = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_HEARTBEAT = 0.5
"""Time between two heartbeats on the wall clock [s]."""

_LONG = 3.0
"""Compiled code that is there is ready sooner [s]."""


class PlannerNode(QuadNode[PlannerParameters]):
    """Plans when a goal comes, when a map changes, and when the robot leaves its path."""

    def __init__(self, **kwargs: Any) -> None:
        super().__init__('planner_node', PlannerParameters, **kwargs)
        p = self.parameters
        robot = load_robot(p.robot)
        self._pace = pace_from_parameters(p)
        # Searches run beside the executor: a newer goal or map must be heard meanwhile.
        self._requests: LatestRequest[Any] = LatestRequest(self.call_soon)
        self._planner = planner_from_parameters(
            p, robot, self._pace, time.monotonic, self._requests.is_superseded
        )
        self._frame = MapFrame('map', p.correction_time_constant)
        planning_map = PlanningMap(
            self._planner,
            self._frame,
            GroundLimits.of(robot, p.step_height, p.largest_slope),
            p.occupied_threshold,
            steps_over_low=p.low_obstacles == 'step_over',
            warn=self.get_logger().warning,
        )
        options = SessionOptions(p.replan_distance, p.odom_timeout)
        self._session = PlanningSession(planning_map, self._requests, self, options)
        self._outlines: tuple[Any, ...] = ()
        self._last_stamp = 0

        self._plan_publisher = self.create_publisher(Path, 'plan', _LATCHED)
        self._marker_publisher = self.create_publisher(MarkerArray, 'plan_markers', _LATCHED)
        self._heartbeats = self.create_publisher(Header, 'plan/heartbeat', 10)
        self.create_subscription(OccupancyGrid, 'map', self._on_map, _LATCHED)
        self.create_subscription(PointCloud2, 'height_map', self._on_height_map, _LATCHED)
        self.create_subscription(PoseStamped, 'goal_pose', self._on_goal, 10)
        most_bytes = most_plan_bytes(LONGEST_PLAN)
        self.create_subscription(
            Path, 'plan/followed', self._on_followed, _EVERY_PLAN, most_bytes=most_bytes
        )
        self.create_subscription(Odometry, p.odom_topic, self._on_odometry, qos_profile_sensor_data)
        self._corrections = MapFrameListener(self, self._frame, p.correction_timeout)
        self.create_service(GetPlan, 'get_plan', self._on_get_plan)
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(_HEARTBEAT, self._on_heartbeat, clock=clock)
        # Once the executor has the node: what is answered before would reach nobody.
        self._beginning = self.create_timer(0.0, self._on_beginning, clock=clock)
        self.update_status()

    # What the session has published and said

    def publish_plan(self, plan: Plan | None) -> int:
        """Publish a plan, or take the last one back; return its stamp, each another one [ns]."""
        self._last_stamp = max(self.get_clock().now().nanoseconds, self._last_stamp + 1)
        stamp = Time(sec=self._last_stamp // 10**9, nanosec=self._last_stamp % 10**9)
        self._plan_publisher.publish(path_message(plan, self._frame.name, stamp))
        self._publish_markers()
        return self._last_stamp

    def show_map(self) -> None:
        """Show the safety boundary of the map."""
        prepared = self._planner.prepared
        assert prepared is not None
        self._outlines = combined_obstacles(prepared.grid, prepared.forbidden).outlines
        self._publish_markers()

    def say(self, sentence: str) -> None:
        """Log a sentence."""
        self.get_logger().info(sentence)

    def update_status(self) -> None:
        """Say what the planner does, or what it waits for."""
        session, topic = self._session, self.parameters.odom_topic
        clock_problem = self.clock_problem()
        old_correction = self._corrections.problem()
        goal = session.pending_goal
        if clock_problem is not None:
            self.report(STALE, clock_problem)
        elif self._planner.prepared is None and session.problem is None:
            self.report(WARN, "no map: waiting for one on 'map'")
        elif self._requests.is_busy and goal is None:
            self.report(OK, 'getting the searches ready: once after an installation they compile')
        elif goal is not None:
            self.report(OK, f'searching a way to ({goal.x:.2f}, {goal.y:.2f}) m')
        elif session.problem is not None:
            self.report_error(session.problem)
        elif not session.has_pose:
            self.report(WARN, f"no odometry: waiting for it on '{topic}'")
        elif session.silence:
            self.report(
                WARN,
                f"silent odometry: none on '{topic}' for {session.silence:.0f} s; "
                'plans wait for the robot to say where it is',
            )
        elif old_correction:
            self.report(WARN, f'old localisation: {old_correction}')
        elif session.plan is None:
            self.report(OK, "ready: waiting for a goal on 'goal_pose'")
        else:
            self.report(OK, self._described(session.plan), error_code=0)

    def _described(self, plan: Plan) -> str:
        session = self._session
        text = f'plan of {len(plan.poses)} turning points, {plan.length:.2f} m'
        if session.planned_from is not None and self._pace is not None:
            time_ = self._pace.walking_time(session.planned_from, plan)
            text += f', {time_:.0f} s to walk ({self.parameters.gait})'
        return f'{text}: it has ended' if session.has_ended else text

    def _publish_markers(self) -> None:
        stamp = self.get_clock().now().to_msg()
        self._marker_publisher.publish(
            plan_markers(self._session.plan, self._outlines, self._frame.name, stamp)
        )

    # What is heard

    def _on_map(self, message: OccupancyGrid) -> None:
        grid = grid_from_message(message, self.parameters.largest_map)
        self._session.take_grid(grid, message.header.frame_id or 'map')

    def _on_height_map(self, message: PointCloud2) -> None:
        frame = message.header.frame_id
        self._session.take_heights(height_map_from_message(message, (frame,)), frame)

    def _on_goal(self, message: PoseStamped) -> None:
        try:
            goal = pose_from_message(message.pose, 'goal')
        except PlannerError as error:
            self._session.problem = error
            raise
        self._session.give_goal(message.header.frame_id, goal)

    def _on_odometry(self, message: Odometry) -> None:
        pose, _ = self._corrections.locate(message)
        self._session.take_pose(seconds_from_time(message.header.stamp), pose)

    def _on_followed(self, message: Path) -> None:
        plan = plan_from_message(message)
        header = message.header
        self._session.take_followed(nanoseconds_from_time(header.stamp), header.frame_id, plan)

    def _on_heartbeat(self) -> None:
        now = self.get_clock().now()
        self._heartbeats.publish(Header(stamp=now.to_msg(), frame_id=self._frame.name))
        self._session.tick(time.monotonic(), now.nanoseconds * 1e-9)

    def _on_get_plan(
        self, request: GetPlan.Request, response: GetPlan.Response
    ) -> GetPlan.Response:
        """Answer with a plan, or with an empty path and the reason on diagnostics."""
        stamp = self.get_clock().now().to_msg()
        plan, poses = None, []
        try:
            for stamped, what in ((request.start, 'start'), (request.goal, 'goal')):
                # Unlike a topic, a request is meant for this planner: its map goes without saying.
                frame = stamped.header.frame_id or self._frame.name
                pose = pose_from_message(stamped.pose, what)
                poses.append(self._session.pose_on_map(frame, pose, what))
            plan = self._planner.plan(*poses)
        except QuadError as error:
            self.report_error(error)
        response.plan = path_message(plan, self._frame.name, stamp)
        return response

    # Beginning and end

    def _on_beginning(self) -> None:
        self._beginning.cancel()
        # A goal that came even before is not given up for it.
        if not self._requests.is_busy:
            self._requests.submit(self._warm_up, self._on_warm)

    def _warm_up(self) -> float:
        began = time.monotonic()
        self._planner.warm_up()
        return time.monotonic() - began

    def _on_warm(self, result: Callable[[], float]) -> None:
        took = result()
        if took > _LONG:
            self.get_logger().info(f'the searches were compiled in {took:.0f} s; they are kept')
        self.update_status()

    def destroy_node(self) -> None:
        """Give up what is being searched, and end."""
        self._requests.close()
        super().destroy_node()


def main(args: list[str] | None = None) -> int:
    """Run the planner node."""
    return run_node(PlannerNode, args)
