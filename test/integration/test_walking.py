"""A robot walks to its goal: planner, gait and simulator on real topics."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from harness import SENSOR, START, Bench
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory

from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.ros_conversions import seconds_from_time

pytestmark = pytest.mark.ros

GOAL = Pose2D(1.3, 2.2, math.pi / 2)


def test_probe(bench: Bench):
    bench.start_robot(backend='bullet')
    margins = bench.hear(Float64, 'stability_margin')
    lead = []
    def on(m):
        t0 = seconds_from_time(m.header.stamp) + m.points[0].time_from_start.sec + 1e-9*m.points[0].time_from_start.nanosec
        lead.append((bench.time, t0 - bench.time))
    bench.node.create_subscription(JointTrajectory, 'joint_trajectory', on, 10)
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)
    print(bench.time, min(m.data for m in margins), lead)
    assert 0
