"""The ceiling camera's node, fed with pictures and odometry that the test makes: no simulator."""

from __future__ import annotations

import math
from collections.abc import Sequence

import cv2
import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, TransformStamped
from harness import ERROR, EVERY_SAMPLE, LATCHED, OK, SENSOR, WARN, Bench
from nav_msgs.msg import OccupancyGrid, Odometry
from sensor_msgs.msg import CameraInfo, Image

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.image_conversions import (
    camera_info_message,
    image_message,
)
from quad_common.ros.pose_conversions import (
    pose_from_message,
    pose_message,
)
from quad_common.vision.camera import CameraModel
from quad_common.vision.markers import GoalMarker, RobotMarker

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
MARKER = RobotMarker.on(ROBOT)
GOAL = GoalMarker()
CAMERA = CameraModel.looking_down((4.0, 4.0, 6.0), 0.0, 1.4)
START = Pose2D(3.0, 3.0, 0.5)
BOX = ((5.0, 5.0), (5.6, 5.0), (5.6, 5.4), (5.0, 5.4))
"""An obstacle without height [m]."""


def picture(robot: Pose2D | None = START, goals: Sequence[Pose2D] = ()) -> np.ndarray:
    """Paint a room with an obstacle, markers of goals and, unless told otherwise, the robot's."""
    image = np.full((640, 640, 3), 200, np.uint8)
    corners = CAMERA.project([(x, y, 0.0) for x, y in BOX])
    cv2.fillPoly(image, [corners.round().astype(np.int32)], (205, 50, 35))
    for goal in goals:
        dot(image, goal, GOAL.height, GOAL.radius, GOAL.color)
        ahead = goal @ Pose2D(GOAL.heading_distance, 0.0, 0.0)
        dot(image, ahead, GOAL.height, GOAL.heading_radius, GOAL.heading_color)
    if robot is not None:
        height = ROBOT.standing_height + MARKER.height
        for side, color in ((0.5, MARKER.front_color), (-0.5, MARKER.rear_color)):
            at = robot @ Pose2D(side * MARKER.disc_distance, 0.0, 0.0)
            dot(image, at, height, MARKER.disc_radius, color)
    return image


def dot(image: np.ndarray, at: Pose2D, height: float, radius: float, color) -> None:
    """Paint a disc."""
    turn = np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False)
    rim = [(at.x + radius * np.cos(a), at.y + radius * np.sin(a), height) for a in turn]
    pixels = 256.0 * (CAMERA.project(rim) - 0.5)
    cv2.fillPoly(image, [pixels.round().astype(np.int32)], color, shift=8)


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what becomes of pictures."""
    return composed_bench


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
    assert by_child['base_footprint'].header.frame_id == 'base_link'
    assert by_child['base_footprint'].transform.translation.z == pytest.approx(-0.3)
    assert pose_of(by_child['base_link']).distance_to(room.legs) < 1e-9
    pose = pose_of(by_child['odom']) @ pose_of(by_child['base_link'])
    assert pose.distance_to(START) < 0.03
    assert pose.yaw == pytest.approx(START.yaw, abs=0.05)


def test_odometry_on_the_map_has_nothing_to_correct_and_is_refused(bench: Bench, room: Room):
    room.frame = 'map'
    bench.wait_for_status('ceiling_camera_node', "it is in frame 'map'; it must be", level=ERROR)
    room.frame = 'odom'
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)


def spoilt(name: str) -> np.ndarray | Image:
    """Make a picture that cannot be used."""
    return {
        'black': np.zeros((640, 640, 3), np.uint8),
        'white': np.full((640, 640, 3), 255, np.uint8),
        'of another size': np.full((480, 640, 3), 200, np.uint8),
        'of depths': Image(encoding='32FC1', width=4, height=4, step=16, data=bytes(64)),
        'cut off': Image(encoding='rgb8', width=640, height=640, step=1920, data=bytes(64)),
    }[name]


@pytest.mark.parametrize(
    ('name', 'words'),
    [
        ('black', 'the picture is black: 100 % of it is darker'),
        ('white', 'the picture is overexposed: 100 % of it is white'),
        ('of another size', "'rgb' is"),
        ('of depths', '32FC1'),
        ('cut off', 'rgb8'),
    ],
)
def test_a_bad_picture_is_said_and_the_last_good_map_stays(bench: Bench, room: Room, name, words):
    maps = bench.hear(OccupancyGrid, 'map', LATCHED)
    fused = bench.hear(Odometry, 'odom/camera', EVERY_SAMPLE)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    bench.wait_until('a map', lambda: bool(maps))
    heard = len(maps)
    room.image = spoilt(name)
    bench.wait_for_status('ceiling_camera_node', words, level=ERROR)
    stops_when_too_old(bench, fused)
    assert len(maps) == heard
    # Who comes late hears the last good one.
    late = bench.hear(OccupancyGrid, 'map', LATCHED)
    bench.wait_until('the map', lambda: bool(late))
    assert late[0].data == maps[-1].data
    room.image = picture()
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)


def stops_when_too_old(bench: Bench, fused: list[Odometry]) -> None:
    """Wait until no fused pose is published any more: then the gait stops the robot."""

    def is_quiet() -> bool:
        seen = len(fused)
        later = [False]
        timer = bench.node.create_timer(0.5, lambda: later.__setitem__(0, True))
        bench.wait_until('half a second', lambda: later[0])
        bench.node.destroy_timer(timer)
        return len(fused) == seen

    bench.wait_until('no fused pose', is_quiet)


def test_a_frozen_picture_is_said_while_the_legs_walk(bench: Bench, room: Room):
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    fused = bench.hear(Odometry, 'odom/camera', EVERY_SAMPLE)
    room.legs = Pose2D(0.2, 0.0, 0.0)
    bench.wait_for_status('ceiling_camera_node', 'frozen: it has not changed', level=ERROR)
    stops_when_too_old(bench, fused)
    room.image = picture(START @ room.legs)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)


def test_a_robot_out_of_sight_is_carried_on_by_its_legs_and_then_not_known(
    bench: Bench, room: Room
):
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    fused = bench.hear(Odometry, 'odom/camera', EVERY_SAMPLE)
    room.image = picture(None)
    bench.wait_for_status('ceiling_camera_node', 'the robot is not seen', level=WARN)
    stops_when_too_old(bench, fused)
    room.image = picture()
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    heard = len(fused)
    bench.wait_until('fused poses', lambda: len(fused) > heard)
    assert pose_from_message(fused[-1].pose.pose).distance_to(START) < 0.03


def test_of_two_goals_none_is_taken_and_the_last_one_stays(bench: Bench, room: Room):
    goals = bench.hear(PoseStamped, 'goal_pose')
    first, second = Pose2D(2.0, 5.0, 1.0), Pose2D(5.0, 3.0, 0.0)
    room.image = picture(goals=[first])
    bench.wait_until('the goal', lambda: bool(goals))
    room.image = picture(goals=[first, second])
    bench.wait_for_status('ceiling_camera_node', 'the goal is seen 2 times, at', level=WARN)
    room.image = picture(goals=[second])
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    bench.wait_until('the second goal', lambda: len(goals) > 1)
    said = [pose_from_message(goal.pose) for goal in goals]
    assert all(goal.distance_to(place) < 0.03 for goal, place in zip(said, (first, second)))
    assert len(said) == 2


def test_what_falls_silent_is_missed(bench: Bench, room: Room):
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    room.legs = None
    bench.wait_for_status('ceiling_camera_node', "no odometry: waiting for it on 'odom/legs'")
    room.legs = Pose2D(0.0, 0.0, 0.0)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    room.image = None
    bench.wait_for_status('ceiling_camera_node', 'the last picture is', level=WARN)
    room.image = picture()
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)


def test_pictures_without_camera_info_wait_for_it(bench: Bench):
    bench.start('ceiling_camera_node', use_sim_time=False)
    room = Room(bench)
    room.has_info = False
    bench.wait_for_status('ceiling_camera_node', "no camera_info: waiting for it on 'ceiling_")
    room.has_info = True
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)


def test_hostile_input_is_refused_and_the_room_is_still_seen(bench: Bench, room: Room):
    maps = bench.hear(OccupancyGrid, 'map', LATCHED)
    fused = bench.hear(Odometry, 'odom/camera', EVERY_SAMPLE)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    for topic, message, words in hostile_inputs():
        with (
            bench.publishing(topic, message, SENSOR),
            bench.expects('ceiling_camera_node', words, level=ERROR),
        ):
            pass
        bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    heard = len(fused)
    bench.wait_until('fused poses', lambda: len(fused) > heard)
    for message in fused:
        assert pose_from_message(message.pose.pose).distance_to(START) < 0.03
        assert np.isfinite([message.twist.twist.linear.x, *message.pose.covariance]).all()
    # Not one of them led to another map.
    assert len(maps) == 1


def hostile_inputs() -> list[tuple[str, object, str]]:
    """Return topics, messages, and what is said of them."""
    info = [camera_info_message(CAMERA, 'ceiling_camera', Time()) for _ in range(3)]
    info[0].width = info[0].height = 2**32 - 1
    info[1].k[0] = 1e300
    info[2].d[0] = math.nan
    legs = [Odometry(child_frame_id='base_link') for _ in range(5)]
    for message in legs:
        message.header.frame_id = 'odom'
        message.header.stamp = Time(sec=1)
        message.pose.pose = pose_message(Pose2D(0.0, 0.0, 0.0))
    legs[1].pose.pose.orientation.z = 1e308
    legs[2].twist.twist.linear.x = math.nan
    legs[3].header.frame_id = 'x' * 10_000_000
    legs[4].header.stamp = Time(sec=2**31 - 1, nanosec=999_999_999)
    old = image_message(picture(), 'ceiling_camera', Time(sec=1))
    huge = Image(encoding='rgb8', width=2**31, height=2**31, step=2**32 - 1, data=bytes(64))
    huge.header.stamp = Time(sec=2**31 - 2)
    return [
        ('ceiling_camera/camera_info', info[0], '4294967295 x 4294967295 pixels'),
        ('ceiling_camera/camera_info', info[1], 'its focal lengths are 1e+300'),
        ('ceiling_camera/camera_info', info[2], 'of its lens D is not from'),
        ('odom/legs', legs[0], 'its stamp is 1.000 s; it must be after'),
        ('odom/legs', legs[1], 'the odometry is not a pose: its quaternion'),
        ('odom/legs', legs[2], 'its twist is (nan'),
        ('odom/legs', legs[3], '10000000 characters'),
        ('odom/legs', legs[4], 'its stamp is 2147483648.000 s; it must be after'),
        ('ceiling_camera/image_raw', old, 'its stamp is 1.000 s; it must be after'),
        ('ceiling_camera/image_raw', huge, '2147483648 x 2147483648 pixels'),
    ]
