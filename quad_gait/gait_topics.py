"""
What ``gait_node`` publishes.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import PolygonStamped, PoseStamped
from nav_msgs.msg import Odometry, Path
from numpy.typing import NDArray
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import PointCloud2
from std_msgs.msg import Float64, Header
from trajectory_msgs.msg import JointTrajectory as JointTrajectoryMessage
from visualization_msgs.msg import MarkerArray

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_message
from quad_common.ros.ros_node import QuadNode
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.parameters import GaitParameters
from quad_gait.ros_conversions import (
    foothold_markers,
    leg_odometry_message,
    point_cloud_message,
    polygon_message,
    trajectory_message,
)
from quad_gait.state.leg_odometry import LegOdometry
from quad_gait.state.robot_state import RobotState
from quad_gait.supervisor import Supervisor
from quad_gait.trajectory_actions import TrajectoryGoals

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_HEARTBEAT = 0.1
"""Time between two heartbeats, in the time of the measurements [s]; 0 where each measurement is to
be answered at once: of a robot that keeps its balance, or whose feet feel for the ground."""

_POLYGON_PERIOD = 0.1
"""Time between two support polygons of the same feet [s]: they stand, and to find their polygon
takes half as long as a decision."""

_MARGIN_PERIOD = 0.1
"""Time between two margins [s]: to publish one takes as long as to find it."""

_TAKES_JOINTS = 'each takes the joints from the others'
_TAKES_PLANS = "each planner's plan takes the place of the others'"


class GaitTopics:
    """
    The publishers of the gait, and what becomes of its supervisor's decisions.

    Parameters
    ----------
    node : QuadNode
        The node.
    supervisor : Supervisor
        What decides.
    parameters : GaitParameters
        Its parameters.
    """

    def __init__(
        self, node: QuadNode[Any], supervisor: Supervisor, parameters: GaitParameters
    ) -> None:
        self._node = node
        self._supervisor = supervisor
        self._is_uneven = parameters.is_uneven
        # On uneven ground, and in balance, it is decided at every measurement: whoever simulates
        # is to wait for that from the first one on.
        self._answers_each = parameters.is_uneven or parameters.balance
        self._is_stamped = parameters.stamped_cmd_vel
        self._received, self._last_stamp = Path(), Time()
        self._followed: Plan | None = None
        self._stops = 0
        self._last_footholds: NDArray[np.float64] | None = None
        self._trajectories = node.create_publisher(JointTrajectoryMessage, 'joint_trajectory', 10)
        self._goals = TrajectoryGoals(node, parameters.trajectory_action)
        self._margins = node.create_publisher(Float64, 'stability_margin', 10)
        self._measured_margins = node.create_publisher(Float64, 'stability_margin/measured', 10)
        self._polygons = node.create_publisher(PolygonStamped, 'support_polygon', 10)
        self._footholds = node.create_publisher(MarkerArray, 'footholds', 10)
        self._leg_odometry = node.create_publisher(Odometry, 'odom/legs', qos_profile_sensor_data)
        self._followed_plans = node.create_publisher(Path, 'plan/followed', _LATCHED)
        self._heartbeats = node.create_publisher(Header, 'gait/heartbeat', 10)
        self._impassable: Pose2D | None = None
        self._felt_count = 0
        if parameters.is_uneven:
            self._no_footing = node.create_publisher(PoseStamped, 'plan/impassable', 10)
            self._felt = node.create_publisher(PointCloud2, 'height_map/felt', _LATCHED)
        self._least, self._least_measured = LeastSince(_MARGIN_PERIOD), LeastSince(_MARGIN_PERIOD)
        self._last_heartbeat = self._last_polygon = -math.inf
        self._polygon_contacts = b''

    def problems(self) -> tuple[str, ...]:
        """Say what is wrong with who publishes what, as sentences; empty ones if nothing is."""
        return (
            self._cmd_vel_problem(),
            self._rivals_problem('joint_trajectory', _TAKES_JOINTS),
            self._rivals_problem('plan/heartbeat', _TAKES_PLANS),
            self._goals.problem(),
        )

    def _rivals_problem(self, topic: str, harm: str) -> str:
        """Say that a topic which is one node's has several publishers; empty if it has not."""
        # With the name as it is remapped, for a joint controller; `count_publishers` does not.
        publishers = len(self._node.get_publishers_info_by_topic(topic))
        if publishers < 2:
            return ''
        return (
            f'{topic} has {publishers} publishers, and {harm}: '
            'end all but one, or give each robot a namespace or a ROS_DOMAIN_ID of its own'
        )

    def _cmd_vel_problem(self) -> str:
        """Say that steering is published as the type that is not subscribed to; empty if not."""
        other = 'Twist' if self._is_stamped else 'TwistStamped'
        publishers = self._node.get_publishers_info_by_topic('cmd_vel')
        if not any(info.topic_type == f'geometry_msgs/msg/{other}' for info in publishers):
            return ''
        is_stamped, wanted = ('true', 'false') if self._is_stamped else ('false', 'true')
        return (
            f'cmd_vel is published as geometry_msgs/{other} and stamped_cmd_vel is {is_stamped}: '
            f'that steering is not received; set it to {wanted}'
        )

    def publish_decision(
        self, trajectory: JointTrajectory | None, state: RobotState, frame: str, stamp: Time
    ) -> None:
        """Publish what was decided at a state, with poses in a frame."""
        self.publish_trajectory(trajectory)
        if trajectory is not None:
            self._publish_footholds(frame, stamp)
        self._publish_stability(state, frame, stamp)
        if self._is_uneven:
            self._publish_impassable(frame, stamp)
            self._publish_felt(frame, stamp)
        self.publish_followed()
        self._publish_heartbeat(state.time, stamp)

    def publish_trajectory(self, trajectory: JointTrajectory | None, is_last: bool = False) -> None:
        """Publish a trajectory, if there is one; the last one holds the joints in any case."""
        if trajectory is not None:
            message = trajectory_message(trajectory)
            self._trajectories.publish(message)
            self._goals.send(message, is_last)

    def publish_leg_odometry(self, odometry: LegOdometry, frame: str, stamp: Time) -> None:
        """Publish the pose by legs, for whoever subscribes."""
        if self._leg_odometry.get_subscription_count() > 0:
            self._leg_odometry.publish(leg_odometry_message(odometry, frame, stamp))

    def take_plan(self, received: Path, is_followed: bool) -> None:
        """Take note of what was received as a plan, and publish what is followed now."""
        self._last_stamp = received.header.stamp
        if is_followed:
            self._received = received
        self.publish_followed()

    def publish_followed(self) -> None:
        """
        Publish the plan that is followed when it is another one; an empty path for none.

        One without a frame says that the robot was stopped, also if it followed none: its goal,
        which may wait for a path, is given up.
        """
        followed, stops = self._supervisor.wanted_plan, self._supervisor.stops
        has_ended = followed is not self._followed
        self._followed = followed
        if stops != self._stops:
            self._stops = stops
            self._followed_plans.publish(Path(header=Header(stamp=self._last_stamp)))
            has_ended = followed is not None
        if has_ended:
            path = self._received
            self._followed_plans.publish(path if followed else Path(header=path.header))

    def publish_unfollowed(self) -> None:
        """Publish that no plan of the topic is followed: the one that is came otherwise."""
        was_followed = self._followed is not None
        self._followed = self._supervisor.wanted_plan
        if was_followed:
            self._followed_plans.publish(Path(header=self._received.header))

    def _publish_heartbeat(self, time: float, stamp: Time) -> None:
        """Publish up to when measurements are answered, after all that answers them."""
        period = 0.0 if self._answers_each else _HEARTBEAT
        if not 0.0 <= time - self._last_heartbeat < period:
            self._last_heartbeat = time
            self._heartbeats.publish(Header(stamp=stamp))

    def _publish_impassable(self, frame: str, stamp: Time) -> None:
        """Publish a pose from which there was no footing ahead, once."""
        place = self._supervisor.impassable
        if place is not None and place is not self._impassable:
            header = Header(frame_id=frame, stamp=stamp)
            self._no_footing.publish(PoseStamped(header=header, pose=pose_message(place)))
        self._impassable = place

    def _publish_felt(self, frame: str, stamp: Time) -> None:
        """Publish where feet have met the ground, when one more has."""
        felt = self._supervisor.felt_ground
        if felt.count != self._felt_count:
            self._felt_count = felt.count
            self._felt.publish(point_cloud_message(felt.points, frame, stamp))

    def _publish_footholds(self, frame: str, stamp: Time) -> None:
        """Publish the next footholds when they are others: on uneven ground they seldom are."""
        footholds = self._supervisor.footholds()
        last = self._last_footholds
        if len(footholds) and (last is None or not np.array_equal(footholds, last)):
            self._last_footholds = footholds
            self._footholds.publish(foothold_markers(footholds, frame, stamp))

    def _publish_stability(self, state: RobotState, frame: str, stamp: Time) -> None:
        """Publish margins and support polygon, those that take time for subscribers only."""
        planned, in_contact = self._supervisor.support, self._supervisor.in_contact_at(state.time)
        is_wanted = self._measured_margins.get_subscription_count() > 0
        is_measured = self._is_uneven or is_wanted
        measured = state.stability_margin(in_contact) if is_measured else math.nan
        # Uneven ground is not planned for a cycle ahead: there the real feet count.
        margin = measured if self._is_uneven else planned.margin_at(state.time)
        if (least := self._least.take(state.time, margin)) is not None:
            self._margins.publish(Float64(data=least))
        if is_wanted and (least := self._least_measured.take(state.time, measured)) is not None:
            self._measured_margins.publish(Float64(data=least))
        if self._polygons.get_subscription_count() > 0 and self._is_polygon_due(state, in_contact):
            if self._is_uneven:
                polygon = state.support_polygon(in_contact)
            else:
                polygon = planned.polygon_at(state.time, state.pose)
            self._polygons.publish(polygon_message(polygon, frame, stamp))

    def _is_polygon_due(self, state: RobotState, in_contact: NDArray[np.bool_]) -> bool:
        """Return whether other feet stand, or the last polygon was published some time ago."""
        contacts = in_contact.tobytes()
        is_due = not 0.0 <= state.time - self._last_polygon < _POLYGON_PERIOD
        if not is_due and contacts == self._polygon_contacts:
            return False
        self._last_polygon, self._polygon_contacts = state.time, contacts
        return True


class LeastSince:
    """
    The least of numbers, once in a while.

    Parameters
    ----------
    period : float
        Time from one to the next [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._least, self._told_at = math.inf, -math.inf

    def take(self, time: float, number: float) -> float | None:
        """
        Take a number at a time [s]; what is not finite counts as none.

        Return the least since the last one; None if that was a moment ago, or there is none.
        """
        if math.isfinite(number):
            self._least = min(self._least, number)
        # Stamps of measurements are not exact multiples of their period.
        is_due = not 0.0 <= time - self._told_at < self._period - 1e-6
        if not is_due or math.isinf(self._least):
            return None
        least, self._least, self._told_at = self._least, math.inf, time
        return least
