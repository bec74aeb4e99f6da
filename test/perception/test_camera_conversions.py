"""What the camera knows, as messages."""

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from nav_msgs.msg import Odometry

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.ros.pose_conversions import pose_from_message, pose_message
from quad_perception.ros_conversions import fused_odometry, robot_transforms
from quad_perception.tracking.pose_fusion import PoseFusion

pytestmark = pytest.mark.ros

COVARIANCE = np.diag([1e-4, 1e-4, 1e-4])


def legs_at(pose, time=3):
    message = Odometry(child_frame_id='base_link')
    message.header.frame_id = 'odom'
    message.header.stamp = Time(sec=time)
    message.pose.pose = pose_message(pose)
    message.pose.pose.position.z = 0.4
    return message


def pose_of(transform):
    rotation, translation = transform.transform.rotation, transform.transform.translation
    return Pose2D(translation.x, translation.y, 2.0 * math.atan2(rotation.z, rotation.w))


def matrix(pose):
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return np.array([(c, -s, pose.x), (s, c, pose.y), (0.0, 0.0, 1.0)])


@pytest.mark.parametrize('seed', range(5))
def test_map_to_odom_is_the_fused_pose_after_the_legs_undone(seed):
    # map_T_odom = map_T_base @ inverse(odom_T_base)
    rng = np.random.default_rng(seed)
    fusion = PoseFusion()
    legs = Pose2D(*rng.uniform(-3.0, 3.0, 3))
    fusion.add_odometry(1.0, legs)
    fusion.add_picture(1.0, Pose2D(*rng.uniform(-3.0, 3.0, 3)), COVARIANCE)
    legs = legs @ Pose2D(0.3, 0.05, 0.4)
    fusion.add_odometry(3.0, legs)
    message = legs_at(legs)
    fused = pose_from_message(fused_odometry(message, fusion, 'map').pose.pose)
    transforms = robot_transforms(message, fusion.correction, 'map', 'base_footprint')
    found = {t.child_frame_id: t for t in transforms}
    parents = {t.child_frame_id: t.header.frame_id for t in transforms}
    assert parents == {'odom': 'map', 'base_link': 'odom', 'base_footprint': 'base_link'}
    assert all(t.header.stamp == message.header.stamp for t in transforms)
    expected = matrix(fused) @ np.linalg.inv(matrix(legs))
    assert matrix(pose_of(found['odom'])) == pytest.approx(expected, abs=1e-9)
    there = pose_of(found['odom']) @ pose_of(found['base_link'])
    for place in (there, there @ pose_of(found['base_footprint'])):
        assert place.distance_to(fused) < 1e-9
        assert wrap_angle(place.yaw - fused.yaw) == pytest.approx(0.0, abs=1e-9)
    assert found['base_link'].transform.translation.z == 0.4
    assert found['base_footprint'].transform.translation.z == -0.4


def test_while_the_camera_does_not_know_only_the_legs_tell():
    children = {t.child_frame_id for t in robot_transforms(legs_at(Pose2D(1, 2, 3)), None, '', '')}
    assert 'odom' not in children
    assert 'base_link' in children
