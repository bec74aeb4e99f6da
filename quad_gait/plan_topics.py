"""
The plans that ``gait_node`` subscribes to.
"""

from __future__ import annotations

from nav_msgs.msg import Path
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Header

from quad_common.frames.map_frame import MapFrame
from quad_common.plan import Plan
from quad_common.ros.pose_conversions import most_plan_bytes, plan_from_message
from quad_common.ros.ros_node import QuadNode
from quad_gait.gait_actions import GaitActions
from quad_gait.gait_topics import GaitTopics
from quad_gait.parameters import GaitParameters
from quad_gait.planner_watch import PlannerWatch
from quad_gait.supervisor import Supervisor

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


class PlanTopics:
    """
    Hands plans on to the supervisor, those of topics and those of actions.

    Parameters
    ----------
    node : QuadNode
        The node.
    supervisor : Supervisor
        What decides.
    topics : GaitTopics
        What is published of it.
    frame : MapFrame
        Relation of frames to the map's.
    planner : PlannerWatch
        Whether the planner lives.
    """

    def __init__(
        self,
        node: QuadNode[GaitParameters],
        supervisor: Supervisor,
        topics: GaitTopics,
        frame: MapFrame,
        planner: PlannerWatch,
    ) -> None:
        self._node = node
        self._supervisor = supervisor
        self._topics = topics
        self._frame = frame
        self._planner = planner
        self.actions = GaitActions(node, supervisor, topics, self._read_plan)
        """Action by which paths are followed."""
        p = node.parameters
        plan_qos = _LATCHED if p.transient_local_plan else QoSProfile(depth=1)
        most_bytes = most_plan_bytes(p.longest_plan)
        node.create_subscription(Path, 'plan', self._on_plan, plan_qos, most_bytes=most_bytes)
        node.create_subscription(Header, 'plan/heartbeat', planner.take_heartbeat, 10)

    def _read_plan(self, message: Path) -> Plan | None:
        """Return the plan on the map that a path holds; None if it is empty."""
        plan = plan_from_message(message, self._node.parameters.longest_plan)
        if plan is not None:
            self._node.check_active()
            plan = self._frame.plan_on_map(message.header.frame_id, plan)
        self._planner.take_plan()
        return plan

    def _on_plan(self, message: Path) -> None:
        plan = self._read_plan(message)
        if plan is None and self.actions.is_followed:
            # It takes back what came on the topic.
            return
        self._supervisor.set_plan(plan)
        is_followed = plan is not None and self._supervisor.wanted_plan is plan
        self._topics.take_plan(message, is_followed)
