"""The ceiling camera's node: map, goal and pose from pictures, and what it says without them."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped, PoseWithCovarianceStamped
from harness import ERROR, EVERY_SAMPLE, LATCHED, OK, SENSOR, Bench
from nav_msgs.msg import OccupancyGrid, Odometry
from sensor_msgs.msg import Image

from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_from_message, pose_message

pytestmark = pytest.mark.ros

SIM = {
    'backend': 'bullet',
    # Pictures take long to draw: they are to come at the pace in which a test looks at them.
    'real_time_factor': 5.0,
    'camera': True,
    'camera_rate': 4.0,
    'map_file': 'none',
    'start_pose': [3.0, 3.0, 0.5],
    'publish_map': False,
}
START = Pose2D(3.0, 3.0, 0.5)


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what the camera tells."""
    return composed_bench


def start(bench: Bench) -> None:
    bench.start('ceiling_camera_node')
    bench.start('sim_node', **SIM)
    bench.start('gait_node', odom_topic='odom/camera', leg_odometry_start='origin')


def test_pictures_tell_where_the_robot_and_the_goal_are(bench: Bench):
    poses = bench.hear(PoseWithCovarianceStamped, 'ceiling_camera/robot_pose')
    fused = bench.hear(Odometry, 'odom/camera', EVERY_SAMPLE)
    maps = bench.hear(OccupancyGrid, 'map', LATCHED)
    goals = bench.hear(PoseStamped, 'goal_pose')
    drawn = bench.hear(Image, 'ceiling_camera/image_annotated', SENSOR)
    start(bench)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    bench.wait_until('a map, poses and a drawn picture', lambda: maps and poses and fused and drawn)
    for message in (poses[-1].pose.pose, fused[-1].pose.pose):
        pose = pose_from_message(message)
        assert pose.distance_to(START) < 0.03
        assert pose.yaw == pytest.approx(START.yaw, abs=0.05)
    assert fused[-1].header.frame_id == 'map'
    bench.wait_for_status('gait_node', 'standing', level=OK)
    goal = Pose2D(5.0, 5.0, 1.0)
    marker = PoseStamped(pose=pose_message(goal))
    marker.header.frame_id = 'map'
    with bench.publishing('goal_marker', marker):
        bench.wait_until('a goal', lambda: bool(goals))
    assert pose_from_message(goals[-1].pose).distance_to(goal) < 0.03


def test_without_a_camera_it_says_what_it_waits_for(bench: Bench):
    bench.start('ceiling_camera_node')
    bench.start('sim_node', **(SIM | {'camera': False}))
    bench.wait_for_status('ceiling_camera_node', 'no camera_info')


def test_a_picture_of_another_encoding_is_refused_in_one_sentence(bench: Bench):
    start(bench)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
    depth = Image(encoding='32FC1', width=4, height=4, step=16, data=bytes(64))
    with bench.publishing('ceiling_camera/image_raw', depth, SENSOR):
        bench.wait_for_status('ceiling_camera_node', '32FC1', level=ERROR)
    bench.wait_for_status('ceiling_camera_node', 'are seen', level=OK)
