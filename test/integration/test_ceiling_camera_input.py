"""The ceiling camera's node, fed with pictures and odometry that the test makes: no simulator."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import TransformStamped
from harness import ERROR, OK, SENSOR, Bench
from nav_msgs.msg import Odometry
from sensor_msgs.msg import CameraInfo, Image

from quad_common.camera import CameraModel
from quad_common.markers import RobotMarker
from quad_common.planar_pose import Pose2D
from quad_common.robot import load_robot
from quad_common.ros_conversions import (
    camera_info_message,
    image_message,
    pose_from_message,
    pose_message,
)

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
MARKER = RobotMarker.on(ROBOT)
CAMERA = CameraModel.looking_down((4.0, 4.0, 6.0), 0.0, 1.4)
START = Pose2D(3.0, 3.0, 0.5)
BOX = ((5.0, 5.0), (5.6, 5.0), (5.6, 5.4), (5.0, 5.4))
"""An obstacle without height [m]."""


def picture(robot: Pose2D | None = START) -> np.ndarray:
    """Paint a room with an obstacle and, unless told otherwise, the robot's discs."""
    image = np.full((640, 640, 3), 200, np.uint8)
    corners = CAMERA.project([(x, y, 0.0) for x, y in BOX])
    cv2.fillPoly(image, [corners.round().astype(np.int32)], (205, 50, 35))
    if robot is not None:
        height = ROBOT.standing_height + MARKER.height
        for side, colour in ((0.5, MARKER.front_colour), (-0.5, MARKER.rear_colour)):
            at = robot @ Pose2D(side * MARKER.disc_distance, 0.0, 0.0)
            dot(image, at, height, MARKER.disc_radius, colour)
    return image


def dot(image: np.ndarray, at: Pose2D, height: float, radius: float, colour) -> None:
    """Paint a disc."""
    turn = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    rim = [(at.x + radius * np.cos(a), at.y + radius * np.sin(a), height) for a in turn]
    pixels = 256.0 * (CAMERA.project(rim) - 0.5)
    cv2.fillPoly(image, [pixels.round().astype(np.int32)], colour, shift=8)


class Room:
    """Publishes what a camera and a robot's legs would, at 10 Hz."""

    def __init__(self, bench: Bench) -> None:
        self.image: np.ndarray | Image | None = picture()
        """Published, unless there is none."""
        self.legs: Pose2D | None = Pose2D(0.0, 0.0, 0.0)
        """Likewise, as odometry."""
        self.frame = 'odom'
        """Of the odometry."""
        self.has_info = True
        self._bench = bench
        self._images = bench.publisher(Image, 'ceiling_camera/image_raw', SENSOR)
        self._infos = bench.publisher(CameraInfo, 'ceiling_camera/camera_info', SENSOR)
        self._odometry = bench.publisher(Odometry, 'odom/legs', SENSOR)
        bench.node.create_timer(0.1, self._publish)

    def _publish(self) -> None:
        stamp = self._bench.node.get_clock().now().to_msg()
        if self.has_info:
            self._infos.publish(camera_info_message(CAMERA, 'ceiling_camera', stamp))
        if self.legs is not None:
            message = Odometry(child_frame_id='base_link')
            message.header.frame_id, message.header.stamp = self.frame, stamp
            message.pose.pose = pose_message(self.legs)
            message.pose.pose.position.z = 0.3
            self._odometry.publish(message)
        if isinstance(self.image, Image):
            self.image.header.stamp = stamp
            self._images.publish(self.image)
        elif self.image is not None:
            self._images.publish(image_message(self.image, 'ceiling_camera', stamp))


@pytest.fixture
def room(bench: Bench):
    """Start the node, and what it hears."""
    bench.start('ceiling_camera_node', use_sim_time=False, largest_age=1.0)
    return Room(bench)


def pose_of(transform: TransformStamped) -> Pose2D:
    message = pose_message(Pose2D(0.0, 0.0, 0.0))
    translation = transform.transform.translation
    message.position.x, message.position.y = translation.x, translation.y
    message.orientation = transform.transform.rotation
    return pose_from_message(message)


def test_map_to_odom_is_the_cameras_correction_of_the_legs(bench: Bench, room: Room):
    TFMessage = pytest.importorskip('tf2_msgs.msg').TFMessage
    moving = bench.hear(TFMessage, 'tf', 100)
    fixed = bench.hear(TFMessage, 'tf_static', 10)
    room.legs = Pose2D(-1.0, 2.0, 2.5)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    bench.wait_until('transforms', lambda: len(moving) > 10 and fixed)
    [camera] = fixed[-1].transforms
    assert (camera.header.frame_id, camera.child_frame_id) == ('map', 'ceiling_camera')
    assert camera.transform.translation.z == 6.0
    by_child = {t.child_frame_id: t for t in moving[-1].transforms}
    assert set(by_child) == {'odom', 'base_link', 'base_footprint'}
    assert by_child['odom'].header.frame_id == 'map'
    assert by_child['base_link'].header.frame_id == 'odom'
    assert by_child['base_link'].transform.translation.z == 0.3
    assert by_child['base_footprint'].transform.translation.z == 0.0
    assert pose_of(by_child['base_link']).distance_to(room.legs) < 1e-9
    pose = pose_of(by_child['odom']) @ pose_of(by_child['base_link'])
    assert pose.distance_to(START) < 0.03
    assert pose.yaw == pytest.approx(START.yaw, abs=0.05)


def test_odometry_on_the_map_has_nothing_to_correct_and_is_refused(bench: Bench, room: Room):
    room.frame = 'map'
    bench.wait_for_status('ceiling_camera_node', "it is in frame 'map'; it must be", level=ERROR)
    room.frame = 'odom'
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
