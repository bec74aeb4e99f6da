"""A robot that is told of two places by turns walks to neither."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from harness import WARN
from rclpy.serialization import serialize_message

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_transform, time_from_seconds
from quad_planner.ros_conversions import path_message

pytestmark = pytest.mark.ros


def test_a_plan_waits_while_two_localisers_disagree_and_goes_on_when_they_agree(make_node):
    robot = make_node(gait='trot')
    robot.run(0.3)
    plan = Plan((Pose2D(0.0, 0.0, 0.0), Pose2D(1.5, 0.0, 0.0)))
    robot.tell('plan', serialize_message(path_message(plan, 'map', time_from_seconds(1.0))))

    def correct(x):
        place = pose_transform(Pose2D(x, 0.0, 0.0), 'map', 'odom', time_from_seconds(1.0))
        robot.tell('map_to_odom', place)
        robot.run(0.1)

    for step in range(20):
        # By less than the path's tolerance: nothing else would stop the robot.
        correct(0.4 * (step % 2))
    place = robot.simulation.observe().pose
    for step in range(20):
        correct(0.4 * (step % 2))
    assert robot.simulation.observe().pose.distance_to(place) < 0.01
    level, words = robot.said[-1]
    assert level == WARN
    assert words.startswith('waiting: it is not known where in the map the robot is')
    assert "'map' -> 'odom' leaps again and again: do two publishers disagree?" in words
    for _ in range(70):
        correct(0.0)
    assert robot.simulation.observe().pose.x > place.x + 0.1
