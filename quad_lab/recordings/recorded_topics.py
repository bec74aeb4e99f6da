"""
The topics that are recorded, and how each is published.

A recording keeps how a topic was published (its quality of service), so that it is played back to
whoever subscribes: a latched map reaches a node that starts after it.
"""

from __future__ import annotations

import enum
import importlib
from dataclasses import dataclass, replace
from typing import Any


class Delivery(enum.Enum):
    """How messages of a topic are delivered."""

    SENSOR = 'as soon as possible, or not at all'
    RELIABLE = 'every one'
    LATCHED = 'every one, the last one also to whoever subscribes later'


@dataclass(frozen=True)
class RecordedTopic:
    """A topic of a robot."""

    name: str
    """Name relative to the robot's namespace; one of the whole system begins with a slash."""
    kind: str
    """Type of its messages, as ``package/msg/Name``."""
    delivery: Delivery
    """How it is published."""
    depth: int = 10
    """Number of messages that its publisher keeps."""
    is_on_demand: bool = False
    """Whether it is published for subscribers only, and takes the nodes time then."""

    def in_namespace(self, namespace: str) -> str:
        """Return its full name for a robot's namespace, which may be empty."""
        if self.name.startswith('/'):
            return self.name
        return f'/{namespace}/{self.name}' if namespace else f'/{self.name}'

    def message_type(self) -> Any:
        """Return the class of its messages; None where its package is not installed."""
        package, _, name = self.kind.partition('/msg/')
        try:
            return getattr(importlib.import_module(f'{package}.msg'), name)
        except ImportError:
            return None


CLOCK = RecordedTopic('/clock', 'rosgraph_msgs/msg/Clock', Delivery.SENSOR, 1)
ODOMETRY = RecordedTopic('odom', 'nav_msgs/msg/Odometry', Delivery.SENSOR, 5)
JOINT_STATES = RecordedTopic('joint_states', 'sensor_msgs/msg/JointState', Delivery.SENSOR, 5)
DESCRIPTION = RecordedTopic('robot_description', 'std_msgs/msg/String', Delivery.LATCHED, 1)
GOAL = RecordedTopic('goal_pose', 'geometry_msgs/msg/PoseStamped', Delivery.RELIABLE)
GOAL_MARKER = RecordedTopic('goal_marker', 'geometry_msgs/msg/PoseStamped', Delivery.RELIABLE)
PUSH = RecordedTopic('push', 'geometry_msgs/msg/WrenchStamped', Delivery.RELIABLE)
IMU = RecordedTopic('imu', 'sensor_msgs/msg/Imu', Delivery.SENSOR, 5)
TRUTH = RecordedTopic('odom/truth', 'nav_msgs/msg/Odometry', Delivery.SENSOR, 5, is_on_demand=True)
TRANSFORMS = RecordedTopic('tf', 'tf2_msgs/msg/TFMessage', Delivery.RELIABLE, 100)
FIXED_TRANSFORMS = RecordedTopic('tf_static', 'tf2_msgs/msg/TFMessage', Delivery.LATCHED, 100)
"""Several nodes publish them, each its own, and all count."""
SHARED_TRANSFORMS = replace(TRANSFORMS, name='/tf')
SHARED_FIXED_TRANSFORMS = replace(FIXED_TRANSFORMS, name='/tf_static')
"""Where robots in namespaces meet, each with a prefix of its frames."""
CORRECTIONS = RecordedTopic('map_to_odom', 'geometry_msgs/msg/TransformStamped', Delivery.RELIABLE)

RECORDED = (
    CLOCK,
    DESCRIPTION,
    RecordedTopic('map', 'nav_msgs/msg/OccupancyGrid', Delivery.LATCHED, 1),
    RecordedTopic('height_map', 'sensor_msgs/msg/PointCloud2', Delivery.LATCHED, 1),
    TRANSFORMS,
    FIXED_TRANSFORMS,
    CORRECTIONS,
    IMU,
    JOINT_STATES,
    ODOMETRY,
    RecordedTopic('odom/camera', 'nav_msgs/msg/Odometry', Delivery.SENSOR, 5),
    GOAL,
    GOAL_MARKER,
    RecordedTopic('cmd_vel', 'geometry_msgs/msg/Twist', Delivery.RELIABLE),
    RecordedTopic('plan', 'nav_msgs/msg/Path', Delivery.LATCHED, 1),
    RecordedTopic('plan/followed', 'nav_msgs/msg/Path', Delivery.LATCHED, 1),
    RecordedTopic('plan_markers', 'visualization_msgs/msg/MarkerArray', Delivery.LATCHED, 1),
    RecordedTopic('obstacles', 'visualization_msgs/msg/MarkerArray', Delivery.RELIABLE),
    RecordedTopic('obstacles/present', 'visualization_msgs/msg/MarkerArray', Delivery.LATCHED, 1),
    PUSH,
    RecordedTopic('joint_trajectory', 'trajectory_msgs/msg/JointTrajectory', Delivery.RELIABLE),
    RecordedTopic('footholds', 'visualization_msgs/msg/MarkerArray', Delivery.RELIABLE),
    RecordedTopic('stability_margin', 'std_msgs/msg/Float64', Delivery.RELIABLE),
    RecordedTopic('emergency_stop/active', 'std_msgs/msg/Bool', Delivery.LATCHED, 1),
    RecordedTopic('emergency_stop/held', 'std_msgs/msg/Bool', Delivery.LATCHED, 1),
    RecordedTopic('diagnostics', 'diagnostic_msgs/msg/DiagnosticArray', Delivery.RELIABLE),
    TRUTH,
    RecordedTopic('odom/legs', 'nav_msgs/msg/Odometry', Delivery.SENSOR, 5, is_on_demand=True),
    RecordedTopic(
        'stability_margin/measured',
        'std_msgs/msg/Float64',
        Delivery.RELIABLE,
        is_on_demand=True,
    ),
    RecordedTopic(
        'support_polygon',
        'geometry_msgs/msg/PolygonStamped',
        Delivery.RELIABLE,
        is_on_demand=True,
    ),
)
"""Every topic of a robot that is recorded where it is published."""

BATCHES = RecordedTopic('batches', 'std_msgs/msg/UInt8MultiArray', Delivery.RELIABLE, 500)
"""Where sim_node publishes what is frequent in batches."""

BATCHED = frozenset({CLOCK, IMU, JOINT_STATES, ODOMETRY})
"""Topics whose messages are in them."""
