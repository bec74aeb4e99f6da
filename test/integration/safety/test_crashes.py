"""Whatever node ends in the middle of a walk, the others bear it, and the walk goes on."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip('rclpy')

from harness import EVERY_SAMPLE, OK, PHYSICS, SLOWLY, STALE, START, WARN, Bench
from nav_msgs.msg import Odometry

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import pose_from_message, seconds_from_time

pytestmark = pytest.mark.ros

GOAL = Pose2D(1.8, 1.2, 0.0)
ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)


def stands_still(bench: Bench) -> bool:
    """Whether the robot rests on four feet in its initial posture."""
    names = bench.joint_states.name
    order = [names.index(name) for name in ROBOT.joint_names]
    positions = np.array(bench.joint_states.position)[order]
    at_rest = np.abs(bench.joint_states.velocity).max() < 0.02
    height = bench.odometry.pose.pose.position.z
    return (
        at_rest
        and np.abs(positions - POSTURE).max() < 0.05
        and abs(height - ROBOT.standing_height) < 0.02
    )


def has_fallen(bench: Bench) -> bool:
    return bench.statuses['sim_node'].values['has_fallen'] == 'True'


def test_a_walk_outlives_its_planner(composed_bench: Bench):
    bench = composed_bench
    # By default a plan waits for its planner after some seconds of the wall clock.
    bench.start_robot({'planner_timeout': 0.0}, real_time_factor=SLOWLY)
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.kill('planner_node')
    bench.wait_for_arrival(GOAL)

    bench.start('planner_node')
    bench.wait_for_status('planner_node', 'ready', level=OK)
    further = Pose2D(2.1, 1.2, 0.0)
    bench.give_goal(further)
    bench.wait_for_arrival(further)


def test_without_its_gait_node_the_robot_stands_until_it_is_back(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot(backend=PHYSICS, real_time_factor=SLOWLY)
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.kill('gait_node')
    moved_at = bench.elapsed

    def has_come_to_rest() -> bool:
        nonlocal moved_at
        if not stands_still(bench):
            moved_at = bench.elapsed
        return bench.elapsed - moved_at > 5.0

    bench.wait_until('the robot stands for five seconds', has_come_to_rest)
    assert not has_fallen(bench)
    assert not bench.is_near(GOAL)
    bench.wait_for_status('planner_node', 'no gait_node follows it any more', level=WARN)

    bench.start('gait_node')
    bench.wait_for_arrival(GOAL)
    assert not has_fallen(bench)


def test_a_robot_that_is_reset_walks_again_from_its_start(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot(backend=PHYSICS, real_time_factor=SLOWLY)
    bench.client('reset')
    heard = bench.hear(Odometry, 'odom', EVERY_SAMPLE)
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    before = len(heard)
    assert bench.call('reset').success

    def was_at_start() -> bool:
        poses = (pose_from_message(message.pose.pose) for message in heard[before:])
        return any(pose.distance_to(START) < 0.02 for pose in poses)

    bench.wait_until('the robot is back at its start', was_at_start)
    # By one subscription: which of two hears a message first is open.
    stamps = [seconds_from_time(message.header.stamp) for message in heard]
    assert all(a <= b for a, b in pairwise(stamps)), 'time must not go back'
    bench.wait_for_arrival(GOAL)
    assert not has_fallen(bench)


def test_a_simulator_that_comes_back_with_time_at_zero_is_walked_on(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot(real_time_factor=SLOWLY)
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.kill('sim_node')
    for node in ('planner_node', 'gait_node'):
        bench.wait_for_status(node, 'stale clock', level=STALE)

    last = bench.odometry
    bench.start('sim_node')
    bench.wait_until('odometry comes again', lambda: bench.odometry is not last)
    bench.wait_for_arrival(GOAL)
    bench.wait_for_status('planner_node', 'plan of', level=OK)
