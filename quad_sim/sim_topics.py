"""
What ``sim_node`` publishes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from rclpy.qos import (
    DurabilityPolicy,
    QoSProfile,
    ReliabilityPolicy,
    qos_profile_sensor_data,
)
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo, Image
from visualization_msgs.msg import MarkerArray

from quad_common.ros.image_conversions import camera_info_message, image_message
from quad_common.ros.pose_conversions import camera_transform, time_from_seconds
from quad_common.ros.ros_node import QuadNode
from quad_common.ros.transform_publisher import TransformPublisher
from quad_common.vision.color_parameters import color_from
from quad_sim.entities.obstacle_conversions import obstacles_message
from quad_sim.parameters import SimParameters
from quad_sim.sim_session import SimSession
from quad_sim.simulated_robot import SensorReadings
from quad_sim.simulated_robot_topics import RobotTopics
from quad_sim.world.simulated_camera import Picture

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
_CLOCK = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class SimTopics:
    """
    The publishers of a simulation: of the world, and of each robot.

    Parameters
    ----------
    node : QuadNode
        The node.
    session : SimSession
        What is simulated.
    """

    def __init__(self, node: QuadNode[SimParameters], session: SimSession) -> None:
        p = self._parameters = node.parameters
        self._node, self._session = node, session
        self._clock = node.create_publisher(Clock, '/clock', _CLOCK) if p.publish_clock else None
        self._obstacles = node.create_publisher(MarkerArray, 'obstacles/present', _LATCHED)
        self._camera = session.camera
        if self._camera is not None:
            sensor = qos_profile_sensor_data
            self._images = node.create_publisher(Image, 'ceiling_camera/image_raw', sensor)
            self._infos = node.create_publisher(CameraInfo, 'ceiling_camera/camera_info', sensor)
        self._transforms = TransformPublisher(node, p.publish_tf)
        self._robots: dict[str, RobotTopics] = {}
        self.match_robots()
        self.publish_obstacles()

    def match_robots(self) -> None:
        """Have topics for the robots that there are now, and for no others."""
        robots = self._session.robots
        for name in [name for name in self._robots if name not in robots]:
            self._robots.pop(name).destroy()
        for name in [name for name in robots if name not in self._robots]:
            made = RobotTopics(
                self._node, self._session, robots[name], self._transforms, self._clock
            )
            self._robots[name] = made
        fixed = [part for robot in self._robots.values() for part in robot.fixed_transforms]
        if self._camera is not None:
            p, zero = self._parameters, time_from_seconds(0.0)
            fixed.append(camera_transform(self._camera.model, p.map_frame, p.camera_frame, zero))
        self._transforms.publish_static(*fixed)

    def publish_clock(self, time: float) -> None:
        """Publish simulated time [s], unless another simulator does."""
        if self._clock is not None:
            data = serialize_message(Clock(clock=time_from_seconds(time)))
            self._clock.publish(data)
            for robot in self._robots.values():
                robot.keep_clock(self._clock, data)

    def publish_obstacles(self) -> None:
        """Publish which obstacles stand."""
        p, obstacles = self._parameters, cast(Any, self._session.simulation.obstacles)
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

    def publish_readings(self, readings: SensorReadings, name: str = '') -> None:
        """Publish what was measured of a robot; its name is empty if it is alone."""
        self._robots[name].publish_readings(readings)

    def send_batches(self) -> None:
        """Publish the batches that wait for more to come, if they have waited."""
        for robot in self._robots.values():
            robot.send_batches()
