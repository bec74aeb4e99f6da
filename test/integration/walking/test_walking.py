"""A robot walks to its goal: planner, gait and simulator on real topics."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip('rclpy')

from harness import PHYSICS, SLOWLY, START, Bench
from std_msgs.msg import Float64
from trajectory_msgs.msg import JointTrajectory

from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import seconds_from_time
from quad_sim.ros_conversions import trajectory_from_message

pytestmark = pytest.mark.ros

GOAL = Pose2D(1.3, 1.8, math.pi / 2)


def test_a_goal_is_reached(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot(backend=PHYSICS)
    margins = bench.hear(Float64, 'stability_margin')
    heard = bench.hear(JointTrajectory, 'joint_trajectory')
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)

    [plan] = bench.plans
    assert plan.poses[0].distance_to(START) < 0.01
    for here, there in pairwise(plan.poses):
        assert here.yaw == pytest.approx(here.heading_to(there), abs=1e-6)
    assert plan.poses[-1].distance_to(GOAL) < 1e-6
    assert plan.poses[-1].yaw == pytest.approx(GOAL.yaw)

    said = bench.statuses['sim_node'].values
    # Whether trajectories come late is a matter of the machine: it simulates as fast as it can.
    assert (said['contacts'], said['has_fallen']) == ('', 'False')
    assert min(message.data for message in margins) >= 0.0

    trajectories = [trajectory_from_message(message) for message in heard]
    assert len(trajectories) >= 5
    for before, after in pairwise(trajectories):
        assert after.joint_names == before.joint_names
        assert after.stamp + after.times[0] >= before.end
        np.testing.assert_allclose(after.positions[0], before.positions[-1], atol=1e-6)
    for trajectory in trajectories:
        np.testing.assert_allclose(trajectory.velocities[[0, -1]], 0.0, atol=1e-6)


def test_robots_in_namespaces_walk_on_topics_of_their_own(domain):
    with Bench(namespace='robot1') as bench:
        goal = Pose2D(1.5, 1.2, 0.0)
        bench.start_robot()
        bench.give_goal(goal)
        bench.wait_for_arrival(goal)
        topics = dict(bench.node.get_topic_names_and_types())
        ours = {'map', 'goal_pose', 'odom', 'plan', 'joint_trajectory', 'joint_states'}
        assert {f'/robot1/{name}' for name in ours} <= set(topics)
        assert not {f'/{name}' for name in ours} & set(topics)
        assert seconds_from_time(bench.odometry.header.stamp) > 0.0


def test_a_robot_that_is_stopped_stands_until_it_gets_another_goal(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot(real_time_factor=SLOWLY)
    bench.client('stop')
    bench.give_goal(Pose2D(2.0, 1.2, 0.0))
    bench.wait_for_walking()
    assert bench.call('stop').success
    bench.wait_for_status('gait_node', 'standing: stopped on request')
    stopped, since = bench.pose, bench.elapsed
    bench.wait_until('ten seconds go by', lambda: bench.elapsed > since + 10.0)
    assert bench.pose.distance_to(stopped) < 1e-6
    assert not bench.is_near(Pose2D(2.0, 1.2, 0.0))
    nearer = Pose2D(1.7, 1.2, 0.0)
    bench.give_goal(nearer)
    bench.wait_for_arrival(nearer)
