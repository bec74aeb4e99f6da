"""
What ``viewer_node`` receives of one robot.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial
from typing import Any, Protocol, cast

from diagnostic_msgs.msg import DiagnosticArray
from geometry_msgs.msg import PolygonStamped, PoseStamped
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import Image, JointState, PointCloud2
from std_msgs.msg import Bool, Float64, String
from visualization_msgs.msg import MarkerArray

from quad_common.errors import QuadError
from quad_common.frames.map_frame import MapFrame
from quad_common.planar_pose import Pose2D
from quad_common.ros.guarded_node import taken_apart
from quad_common.ros.height_map_conversions import height_map_from_message
from quad_common.ros.image_conversions import rgb_from_image
from quad_common.ros.map_conversions import grid_from_message
from quad_common.ros.map_frame_listener import MapFrameListener
from quad_common.ros.pose_conversions import (
    most_plan_bytes,
    plan_from_message,
    pose_from_message,
    seconds_from_time,
)
from quad_common.ros.ros_node import QuadNode
from quad_view.parameters import ViewerParameters
from quad_view.ros_conversions import (
    body_on_map,
    boundary_from_markers,
    corners_from_polygon,
    footholds_from_markers,
    joints_from_message,
    obstacles_from_markers,
    said_by,
    velocity_from_message,
)
from quad_view.scene.floor import floor_picture, surface_of
from quad_view.scene.robot_model import model_from_urdf
from quad_view.scene.robot_view import RobotView

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)

_MOST_BYTES = 1_000_000
"""Size of the largest message that is shown, of those that hold many others."""

_MOST_LINES = 4_000_000
"""Size of the largest message with obstacles or the lines around them: 170 000 corners."""

_MOST_PICTURE = 64_000_000
"""Size of the largest message of a picture: 20 megapixels."""

_CORRECTION_TIMEOUT = 60.0
"""The planner and the gait say sooner that corrections are old [s]."""


def _full_name(prefix: str, topic: str) -> str:
    """Return a topic's name in a robot's namespace; a name of all robots begins with a slash."""
    return topic if topic.startswith('/') else f'{prefix}{topic}'


class SampledTopics:
    """
    Subscriptions that are looked at, not waited for: only the newest message is ever taken apart.

    A robot that is simulated at many times real time publishes thousands of messages a second, of
    which a page shows thirty.

    Parameters
    ----------
    node : Node
        A node that no executor has.
    prefix : str
        Of the topics' names.
    """

    def __init__(self, node: Node, prefix: str) -> None:
        self._node = node
        self._prefix = prefix
        self._taken: dict[str, tuple[Any, Callable[[bytes], None]]] = {}

    def create_subscription(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: Any, **options: Any
    ) -> None:
        """Have the newest message handed on at each look."""
        name = _full_name(self._prefix, topic)
        # The executor of another node calls nothing of this one.
        subscription = self._node.create_subscription(kind, name, lambda message: None, qos)
        most = options.get('most_bytes', _MOST_BYTES)
        take = partial(taken_apart, kind, f"message on '{name}'", most, callback)
        self._taken[topic] = subscription, take

    def end(self, *topics: str) -> None:
        """Take no more of topics, of all if none is given."""
        for topic in topics or tuple(self._taken):
            if topic in self._taken:
                self._node.destroy_subscription(self._taken.pop(topic)[0])

    def look(self) -> list[QuadError]:
        """Hand on what has come since the last look; return why messages could not be used."""
        problems = []
        for subscription, take in list(self._taken.values()):
            with subscription.handle:
                taken = subscription.handle.take_message(subscription.msg_type, True)
            if taken is not None:
                try:
                    take(taken[0])
                except QuadError as error:
                    problems.append(error)
        return problems


class NamedTopics:
    """
    Makes a node's subscriptions and publishers in a robot's namespace.

    Parameters
    ----------
    node : QuadNode
        The node.
    prefix : str
        Of the topics' names.
    """

    def __init__(self, node: QuadNode[Any], prefix: str) -> None:
        self._node = node
        self._prefix = prefix
        self._subscriptions: list[Any] = []
        self._publishers: list[Any] = []

    def create_subscription(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: Any, **options: Any
    ) -> Any:
        """Subscribe; see :meth:`GuardedNode.create_subscription`."""
        name = _full_name(self._prefix, topic)
        subscription = self._node.create_subscription(kind, name, callback, qos, **options)
        self._subscriptions.append(subscription)
        return subscription

    def create_publisher(self, kind: Any, topic: str, qos: Any) -> Any:
        """Make a publisher."""
        publisher = self._node.create_publisher(kind, _full_name(self._prefix, topic), qos)
        self._publishers.append(publisher)
        return publisher

    def end(self) -> None:
        """Receive and publish nothing more."""
        while self._subscriptions:
            self._node.destroy_subscription(self._subscriptions.pop())
        while self._publishers:
            self._node.destroy_publisher(self._publishers.pop())

    def get_logger(self) -> Any:
        """Return the node's logger."""
        return self._node.get_logger()


class Subscriber(Protocol):
    """What makes subscriptions for a robot: a node, or a recording in its place."""

    def create_subscription(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: Any, **options: Any
    ) -> Any:
        """Have messages of a topic, named within the robot's namespace, handed on."""


class RobotTopics:
    """
    Receives what is shown of a robot.

    Parameters
    ----------
    named : Subscriber
        For topics of which every message counts.
    sampled : Subscriber
        For topics of which the newest message counts.
    view : RobotView
        What is known of the robot.
    parameters : ViewerParameters
        Names of topics and frames.
    clock : callable
        Returns the time at which something is received [s].
    """

    def __init__(
        self,
        named: Subscriber,
        sampled: Subscriber,
        view: RobotView,
        parameters: ViewerParameters,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        p = self._parameters = parameters
        self._view = view
        self._clock = clock
        self._frame = MapFrame(p.map_frame)
        self._map = MapFrameListener(cast(Any, named), self._frame, _CORRECTION_TIMEOUT)
        sampled.create_subscription(JointState, 'joint_states', self._on_joints, _NEWEST)
        sampled.create_subscription(Odometry, p.odom_topic, self._on_odometry, _NEWEST)
        sampled.create_subscription(Float64, 'stability_margin', self._on_margin, _NEWEST)
        sampled.create_subscription(PolygonStamped, 'support_polygon', self._on_support, _NEWEST)
        named.create_subscription(String, 'robot_description', self._on_description, _LATCHED)
        named.create_subscription(OccupancyGrid, 'map', self._on_map, _LATCHED)
        named.create_subscription(PointCloud2, 'height_map', self._on_height_map, _LATCHED)
        most_bytes = most_plan_bytes()
        named.create_subscription(Path, 'plan', self._on_plan, _LATCHED, most_bytes=most_bytes)
        named.create_subscription(
            MarkerArray, 'plan_markers', self._on_plan_markers, _LATCHED, most_bytes=_MOST_LINES
        )
        named.create_subscription(PoseStamped, 'goal_pose', self._on_goal, 10)
        named.create_subscription(
            MarkerArray, 'footholds', self._on_footholds, 10, most_bytes=_MOST_BYTES
        )
        named.create_subscription(
            MarkerArray, 'obstacles/present', self._on_obstacles, _LATCHED, most_bytes=_MOST_LINES
        )
        named.create_subscription(Bool, 'emergency_stop/active', self._on_stopped, _LATCHED)
        named.create_subscription(
            DiagnosticArray, 'diagnostics', self._on_diagnostics, 10, most_bytes=_MOST_BYTES
        )

    def receive_pictures(self, sampled: Subscriber) -> None:
        """Receive a camera's pictures from now on."""
        p = self._parameters
        sampled.create_subscription(
            Image, p.picture_topic, self._on_picture, _NEWEST, most_bytes=_MOST_PICTURE
        )

    def _on_joints(self, message: JointState) -> None:
        self._view.note_joints(joints_from_message(message))

    def _on_odometry(self, message: Odometry) -> None:
        planar, odometry = self._map.locate(message)
        self._view.note_pose(*body_on_map(message, planar, odometry), self._clock())
        stamp = seconds_from_time(message.header.stamp)
        self._view.plot(stamp, velocity_from_message(message))

    def _on_margin(self, message: Float64) -> None:
        self._view.note(margin=float(message.data))

    def _on_support(self, message: PolygonStamped) -> None:
        frame = self._frame.on_map(message.header.frame_id, Pose2D(0.0, 0.0, 0.0))
        if frame is not None:
            self._view.note(support=frame.transform(corners_from_polygon(message)))

    def _on_description(self, message: String) -> None:
        self._view.note(model=model_from_urdf(message.data))

    def _on_map(self, message: OccupancyGrid) -> None:
        self._view.note(floor=floor_picture(grid_from_message(message)))

    def _on_height_map(self, message: PointCloud2) -> None:
        heights = height_map_from_message(message, self._frame.frames_on_map)
        self._view.note(surface=surface_of(heights))

    def _on_plan(self, message: Path) -> None:
        plan = plan_from_message(message)
        if plan is not None:
            plan = self._frame.plan_on_map(message.header.frame_id, plan)
        self._view.note_plan(plan)

    def _on_plan_markers(self, message: MarkerArray) -> None:
        self._view.note(boundary=boundary_from_markers(message))

    def _on_goal(self, message: PoseStamped) -> None:
        self._view.note(goal=pose_from_message(message.pose, 'goal'))

    def _on_footholds(self, message: MarkerArray) -> None:
        self._view.note(footholds=footholds_from_markers(message))

    def _on_obstacles(self, message: MarkerArray) -> None:
        self._view.note(obstacles=obstacles_from_markers(message))

    def _on_stopped(self, message: Bool) -> None:
        self._view.note(is_stopped=bool(message.data))

    def _on_picture(self, message: Image) -> None:
        self._view.note(picture=rgb_from_image(message))

    def _on_diagnostics(self, message: DiagnosticArray) -> None:
        now = self._clock()
        self._view.note_said(
            {status.name.rsplit('/', 1)[-1]: said_by(status, now) for status in message.status}
        )
