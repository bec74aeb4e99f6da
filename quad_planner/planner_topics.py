"""
What ``planner_node`` publishes.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Path
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Bool, Header
from visualization_msgs.msg import MarkerArray

from quad_common.frames.map_frame import MapFrame
from quad_common.plan import Plan
from quad_common.ros.pose_conversions import (
    most_plan_bytes,
    nanoseconds_from_time,
    plan_from_message,
    pose_from_message,
)
from quad_common.ros.ros_node import QuadNode
from quad_planner.grid.combined_obstacles import combined_obstacles
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.ros_conversions import path_message, plan_markers
from quad_planner.session.planning_session import PlanningSession

_EVERY_PLAN = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class PlannerTopics:
    """
    The publishers of a planner, and what becomes of its session's decisions.

    Parameters
    ----------
    node : QuadNode
        The node.
    frame : MapFrame
        Whose name is that of the map.
    """

    def __init__(self, node: QuadNode[Any], frame: MapFrame) -> None:
        self._node = node
        self._frame = frame
        self._plan: Plan | None = None
        self._outlines: tuple[NDArray[np.float64], ...] = ()
        self._last_stamp = 0
        self._plans = node.create_publisher(Path, 'plan', _LATCHED)
        self._markers = node.create_publisher(MarkerArray, 'plan_markers', _LATCHED)
        self._heartbeats = node.create_publisher(Header, 'plan/heartbeat', 10)

    def publish_plan(self, plan: Plan | None) -> int:
        """Publish a plan, or take the last one back; return its stamp, each another one [ns]."""
        self._last_stamp = max(self._node.get_clock().now().nanoseconds, self._last_stamp + 1)
        stamp = Time(sec=self._last_stamp // 10**9, nanosec=self._last_stamp % 10**9)
        self._plans.publish(path_message(plan, self._frame.name, stamp))
        self._plan = plan
        self._publish_markers()
        return self._last_stamp

    def show_map(self, prepared: InflatedMap) -> None:
        """Show the safety boundary of the map."""
        self._outlines = combined_obstacles(prepared.grid, prepared.forbidden).outlines
        self._publish_markers()

    def publish_heartbeat(self) -> None:
        """Publish that the planner lives."""
        stamp = self._node.get_clock().now().to_msg()
        self._heartbeats.publish(Header(stamp=stamp, frame_id=self._frame.name))

    def say(self, sentence: str) -> None:
        """Log a sentence."""
        self._node.get_logger().info(sentence)

    def warn(self, sentence: str) -> None:
        """Log what a user should know."""
        self._node.get_logger().warning(sentence)

    def update_status(self) -> None:
        """Report what goes on."""
        self._node.update_status()

    def _publish_markers(self) -> None:
        stamp = self._node.get_clock().now().to_msg()
        markers = plan_markers(self._plan, self._outlines, self._frame.name, stamp)
        self._markers.publish(markers)


class GaitTopics:
    """
    Tells a session what the gait says of its plans: which it follows, and where it has no footing.

    An emergency stop that the gait was asked for is remembered, for the gait node after it.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : PlanningSession
        What plans again.
    """

    def __init__(self, node: QuadNode[Any], session: PlanningSession) -> None:
        self._node, self._session = node, session
        self._was_seen = False
        node.create_subscription(
            Path, 'plan/followed', self._on_followed, _EVERY_PLAN, most_bytes=most_plan_bytes()
        )
        node.create_subscription(PoseStamped, 'plan/impassable', self._on_impassable, 10)
        # A joint controller does not say that it holds the joints, as a simulator does.
        held = node.create_publisher(Bool, 'emergency_stop/held', _LATCHED)
        node.create_subscription(Bool, 'emergency_stop/active', held.publish, _LATCHED)

    def problem(self) -> str:
        """Return that the gait node that followed plans is gone, as a sentence; empty if not."""
        is_there = self._node.count_publishers('plan/followed') > 0
        self._was_seen |= is_there
        if is_there or not self._was_seen:
            return ''
        return "no gait_node follows it any more: nobody publishes 'plan/followed'"

    def _on_followed(self, message: Path) -> None:
        if self._node.rest_note():
            return
        plan, header = plan_from_message(message), message.header
        self._session.take_followed(nanoseconds_from_time(header.stamp), header.frame_id, plan)

    def _on_impassable(self, message: PoseStamped) -> None:
        place = pose_from_message(message.pose, 'pose without footing')
        self._session.take_impassable(message.header.frame_id, place)
