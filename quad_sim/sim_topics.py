"""
What ``sim_node`` publishes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from geometry_msgs.msg import TransformStamped
from nav_msgs.msg import OccupancyGrid, Odometry
from rclpy.node import Node
from rclpy.qos import (
    DurabilityPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image, Imu, JointState, PointCloud2
from std_msgs.msg import String
from visualization_msgs.msg import MarkerArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.urdf import published_urdf
from quad_common.ros.height_map_conversions import height_map_message
from quad_common.ros.image_conversions import camera_info_message, image_message
from quad_common.ros.pose_conversions import (
    base_transform,
    camera_transform,
    footprint_transform,
    grid_message,
    pose_transform,
    time_from_seconds,
)
from quad_common.ros.transform_publisher import TransformPublisher
from quad_common.vision.color_parameters import color_from
from quad_sim.batch_topics import BatchTopics
from quad_sim.parameters import SimParameters
from quad_sim.ros_conversions import (
    imu_message,
    joint_state_message,
    obstacles_message,
    odometry_message,
    true_odometry_message,
)
from quad_sim.sim_session import SensorReadings, SimSession
from quad_sim.world.simulated_camera import Picture

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class SimTopics:
    """
    The publishers of a simulation; what does not change is published at once.

    Parameters
    ----------
    node : Node
        The node.
    parameters : SimParameters
        Its parameters.
    session : SimSession
        What is simulated.
    """

    def __init__(self, node: Node, parameters: SimParameters, session: SimSession) -> None:
        p = self._parameters = parameters
        self._world = session.scenery.world
        self._joint_names = session.robot.joint_names
        sensor = qos_profile_sensor_data
        self._node = node
        self._clock = node.create_publisher(Clock, '/clock', _CLOCK) if p.publish_clock else None
        self._odometry = node.create_publisher(Odometry, 'odom', sensor)
        self._truth = node.create_publisher(Odometry, 'odom/truth', sensor)
        self._corrections = node.create_publisher(TransformStamped, 'map_to_odom', 10)
        self._joint_states = node.create_publisher(JointState, 'joint_states', sensor)
        self._imu = node.create_publisher(Imu, 'imu', sensor)
        frequent = self._clock, self._imu, self._joint_states, self._odometry
        self._batches = BatchTopics(node, *filter(None, frequent))
        self._description = node.create_publisher(String, 'robot_description', _LATCHED)
        self._map = node.create_publisher(OccupancyGrid, 'map', _LATCHED)
        self._height_map = node.create_publisher(PointCloud2, 'height_map', _LATCHED)
        self._obstacles = node.create_publisher(MarkerArray, 'obstacles/present', _LATCHED)
        self._camera = session.camera
        if self._camera is not None:
            self._images = node.create_publisher(Image, 'ceiling_camera/image_raw', sensor)
            self._infos = node.create_publisher(CameraInfo, 'ceiling_camera/camera_info', sensor)
        self._transforms = TransformPublisher(node, p.publish_tf)
        self._publish_fixed(session)

    def _publish_fixed(self, session: SimSession) -> None:
        """Publish the robot, its maps and the frames that do not move."""
        p, scenery, zero = self._parameters, session.scenery, time_from_seconds(0.0)
        self._description.publish(String(data=published_urdf(session.robot)))
        if scenery.grid is not None:
            self._map.publish(grid_message(scenery.grid, p.map_frame, zero))
        if scenery.height_map is not None:
            self._height_map.publish(height_map_message(scenery.height_map, p.map_frame, zero))
        self.publish_obstacles(session)
        fixed = []
        if session.has_exact_odometry:
            fixed.append(pose_transform(Pose2D(0.0, 0.0, 0.0), p.map_frame, p.odom_frame, zero))
        if self._camera is not None:
            model = self._camera.model
            fixed.append(camera_transform(model, p.map_frame, p.camera_frame, zero))
        self._transforms.publish_static(*fixed)

    def publish_clock(self, time: float) -> None:
        """Publish simulated time [s], unless another simulator does."""
        if self._clock is not None:
            self._batches.publish(self._clock, Clock(clock=time_from_seconds(time)))

    def publish_obstacles(self, session: SimSession) -> None:
        """Publish which obstacles stand."""
        p, obstacles = self._parameters, cast(Any, session.simulation.obstacles)
        color = color_from(p, 'obstacle_color')
        self._obstacles.publish(obstacles_message(obstacles, p.map_frame, color))

    def clock_problem(self) -> str:
        """Say that somebody else publishes another time; empty if nobody does."""
        publishers = self._node.count_publishers('/clock')
        if self._clock is None or publishers < 2:
            return ''
        return (
            f'/clock has {publishers} publishers, and time leaps between theirs: give each '
            'simulation a ROS_DOMAIN_ID of its own, or set publish_clock:=false for all but one'
        )

    def publish_picture(self, time: float, take: Callable[[], Picture]) -> None:
        """Publish what the camera sees at a time [s]; without a subscriber none is taken."""
        assert self._camera is not None
        frame, stamp = self._parameters.camera_frame, time_from_seconds(time)
        if self._infos.get_subscription_count() > 0:
            self._infos.publish(camera_info_message(self._camera.model, frame, stamp))
        if self._images.get_subscription_count() > 0:
            self._images.publish(image_message(take(), frame, stamp))

    def publish_readings(self, readings: SensorReadings) -> None:
        """Publish what was measured."""
        p, truth = self._parameters, readings.truth
        stamp = time_from_seconds(truth.time)
        odometry = odometry_message(readings.odometry, p, readings.odometry_noise, stamp)
        # Heading, then joints, then pose: who receives the next knows what belongs to it.
        publish = self._batches.publish
        if self._batches.is_wanted or self._imu.get_subscription_count() > 0:
            publish(self._imu, imu_message(truth, p, readings.imu_noise, stamp))
        publish(self._joint_states, joint_state_message(truth, self._joint_names, stamp))
        if readings.correction is not None:
            transform = pose_transform(readings.correction, p.map_frame, p.odom_frame, stamp)
            self._corrections.publish(transform)
            self._transforms.publish(transform)
        publish(self._odometry, odometry)
        if self._truth.get_subscription_count() > 0:
            self._truth.publish(true_odometry_message(truth, p, stamp))
        if self._transforms.is_active:
            ground = float(self._world.ground_at(truth.position[:2]))
            footprint = footprint_transform(odometry, p.footprint_frame, ground)
            self._transforms.publish(base_transform(odometry), footprint)
        self._batches.send()

    def send_batches(self) -> None:
        """Publish what waits for more to come, if it has waited."""
        self._batches.send()
