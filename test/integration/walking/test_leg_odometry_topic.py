"""What the legs tell of a walk in physics: where they led, and how steadily."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip('rclpy')
pytest.importorskip('pybullet')

from builtin_interfaces.msg import Time
from rclpy.serialization import serialize_message

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.ros.pose_conversions import pose_from_message, seconds_from_time
from quad_planner.ros_conversions import path_message

pytestmark = pytest.mark.ros

GOAL = Pose2D(0.7, 0.0, 0.3)


class Heard:
    """A topic's publisher with a subscriber that misses nothing."""

    def __init__(self):
        self.messages = []
        self.publish = self.messages.append

    def get_subscription_count(self):
        return 1


def test_the_legs_tell_the_way_and_the_margins_are_positive_throughout_a_crawl(make_node):
    robot = make_node('bullet')
    legs, margins, measured, truth = Heard(), Heard(), Heard(), []
    topics, take_odometry = robot.node._topics, robot.callbacks['odom']
    topics._leg_odometry, topics._margins, topics._measured_margins = legs, margins, measured

    def note_and_take(message):
        truth.append(message)
        take_odometry(message)

    robot.callbacks['odom'] = note_and_take
    robot.run(1.0)
    path = path_message(Plan((robot.simulation.observe().pose, GOAL)), 'odom', Time())
    # It is taken apart by the node itself.
    robot.tell('plan', serialize_message(path))
    while not robot.said[-1][1].startswith('arrived'):
        assert robot.simulation.time < 120.0, robot.said[-1]
        robot.run(1.0)

    for message in legs.messages:
        assert (message.header.frame_id, message.child_frame_id) == ('odom', 'base_link')
        assert message.header.frame_id == truth[0].header.frame_id
    stamps = [seconds_from_time(message.header.stamp) for message in legs.messages]
    assert all(a < b for a, b in pairwise(stamps))
    # The instants of joint_states, 50 a second.
    np.testing.assert_allclose(np.multiply(stamps, 50.0), np.rint(np.multiply(stamps, 50.0)))

    duration = seconds_from_time(truth[-1].header.stamp) - seconds_from_time(truth[0].header.stamp)
    for heard in (margins, measured):
        # Ten in a second, each the least since the last.
        assert len(heard.messages) == pytest.approx(10.0 * duration, rel=0.1)
        assert min(message.data for message in heard.messages) > 0.0

    by_stamp = {seconds_from_time(message.header.stamp): message for message in truth}
    first, last = (legs.messages[k] for k in (0, -1))
    told = pose_from_message(first.pose.pose).inverse() @ pose_from_message(last.pose.pose)
    first, last = (by_stamp[seconds_from_time(m.header.stamp)] for m in (first, last))
    true = pose_from_message(first.pose.pose).inverse() @ pose_from_message(last.pose.pose)
    distance = math.hypot(true.x, true.y)
    assert distance > 0.65
    assert told.distance_to(true) < 0.03 * distance
    assert abs(wrap_angle(told.yaw - true.yaw)) < 0.03
    height = last.pose.pose.position.z
    assert legs.messages[-1].pose.pose.position.z == pytest.approx(height, abs=0.01)
