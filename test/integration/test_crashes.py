"""Whatever node ends in the middle of a walk, the others bear it, and the walk goes on."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rclpy')

from harness import OK, STALE, START, Bench

from quad_common.planar_pose import Pose2D
from quad_common.robot import load_robot

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


def test_a_walk_outlives_its_planner(bench: Bench):
    bench.start_robot()
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.kill('planner_node')
    bench.wait_for_arrival(GOAL)

    bench.start('planner_node')
    bench.wait_for_status('planner_node', 'ready', level=OK)
    further = Pose2D(2.1, 1.2, 0.0)
    bench.give_goal(further)
    bench.wait_for_arrival(further)


def test_without_its_gait_node_the_robot_stands_until_it_is_back(bench: Bench):
    bench.start_robot(backend='bullet')
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.kill('gait_node')
    bench.wait_until('the robot stands still', lambda: stands_still(bench))
    stopped = bench.pose
    since = bench.elapsed
    bench.wait_until('five seconds go by', lambda: bench.elapsed > since + 5.0)
    assert stands_still(bench)
    assert not has_fallen(bench)
    assert bench.pose.distance_to(stopped) < 0.005
    assert not bench.is_near(GOAL)

    bench.start('gait_node')
    bench.wait_for_arrival(GOAL)
    assert not has_fallen(bench)


def test_a_robot_that_is_reset_walks_again_from_its_start(bench: Bench):
    bench.start_robot(backend='bullet')
    bench.give_goal(GOAL)
    bench.wait_for_walking(distance=0.3)
    before = bench.elapsed
    assert bench.call('reset').success
    bench.wait_until('the robot is back', lambda: bench.pose.distance_to(START) < 0.02)
    assert bench.time >= before, 'time must not go back'
    bench.wait_for_arrival(GOAL)
    assert not has_fallen(bench)


def test_a_simulator_that_comes_back_with_time_at_zero_is_walked_on(bench: Bench):
    bench.start_robot()
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.kill('sim_node')
    for node in ('planner_node', 'gait_node'):
        bench.wait_for_status(node, 'stale clock', level=STALE)
    ended_at = bench.time

    bench.start('sim_node')
    bench.wait_until('time starts again', lambda: bench.time < ended_at)
    bench.wait_for_arrival(GOAL)
    bench.wait_for_status('planner_node', 'plan of', level=OK)
