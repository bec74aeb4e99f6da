"""Sit, stand and stop; gaits that change in the middle of a walk."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from harness import EVERY_SAMPLE, LATCHED, OK, SLOWLY, START, Bench
from nav_msgs.msg import Odometry, Path
from rcl_interfaces.srv import GetParameters, SetParameters
from rclpy.parameter import Parameter
from scipy.interpolate import CubicHermiteSpline
from trajectory_msgs.msg import JointTrajectory

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import pose_from_message
from quad_common.trajectory.joint_trajectory import JointTrajectory as Trajectory
from quad_gait.cycle.posture import crouching_joint_angles
from quad_gait.ros_conversions import joints_from_message
from quad_planner.ros_conversions import path_message
from quad_sim.ros_conversions import trajectory_from_message

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
GOAL = Pose2D(2.0, 1.2, 0.0)


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what the robot does."""
    return composed_bench


def joints_away_from(bench: Bench, posture: np.ndarray) -> float:
    """Return how far the joints are from a posture [rad]."""
    positions = joints_from_message(bench.joint_states, ROBOT).positions
    return float(np.abs(positions - posture.reshape(-1)).max())


def height(bench: Bench) -> float:
    return bench.odometry.pose.pose.position.z


def assert_stays(bench: Bench) -> None:
    """Check that the robot does not move for ten seconds."""
    here, since = bench.pose, bench.elapsed
    bench.wait_until('ten seconds go by', lambda: bench.elapsed > since + 10.0)
    assert bench.pose.distance_to(here) < 1e-6


def give_goal_and_wait_for_plan(bench: Bench, goal: Pose2D) -> None:
    before = len(bench.plans)
    bench.give_goal(goal)
    bench.wait_until('there is a plan', lambda: len(bench.plans) > before)


def start_on_empty_floor(bench: Bench, **gait_parameters: object) -> None:
    """Start simulator and gait; the test's plans need no planner."""
    # A wave goes on at its speed only while each cycle is answered before it ends.
    bench.start('sim_node', map_file='none', real_time_factor=SLOWLY)
    bench.start('gait_node', **gait_parameters)
    bench.wait_for_status('gait_node', 'standing', level=OK)


def give_plan(bench: Bench, *poses: Pose2D) -> None:
    """Publish a plan, as a planner would."""
    message = path_message(Plan(poses), 'map', Time())
    bench.publisher(Path, 'plan', LATCHED).publish(message)


def set_parameter(bench: Bench, name: str, value: object) -> Any:
    """Set a parameter of the gait node; return the result."""
    request = SetParameters.Request(parameters=[Parameter(name, value=value).to_parameter_msg()])
    [result] = bench.call('gait_node/set_parameters', SetParameters, request).results
    return result


def get_parameter(bench: Bench, name: str) -> str:
    request = GetParameters.Request(names=[name])
    [value] = bench.call('gait_node/get_parameters', GetParameters, request).values
    return value.string_value


def test_a_robot_sits_down_in_the_middle_of_a_walk_until_it_is_told_to_stand(bench: Bench):
    bench.start_robot(real_time_factor=SLOWLY)
    bench.client('sit')
    upright = height(bench)
    assert upright == pytest.approx(ROBOT.standing_height, abs=1e-3)
    bench.give_goal(GOAL)
    bench.wait_for_walking()

    answer = bench.call('sit')
    assert answer.success
    assert 'sits down, until stand is called' in answer.message
    bench.wait_for_status('gait_node', 'sitting: sitting on request', level=OK)
    assert height(bench) < 0.8 * upright
    assert joints_away_from(bench, crouching_joint_angles(ROBOT)) < 0.02
    nearer = Pose2D(1.9, 1.2, 0.0)
    give_goal_and_wait_for_plan(bench, nearer)
    assert_stays(bench)
    assert bench.activity == 'sitting'

    assert bench.call('stand').success
    bench.wait_for_status('gait_node', 'standing: stopped on request', level=OK)
    assert height(bench) == pytest.approx(upright, abs=1e-3)
    assert joints_away_from(bench, ROBOT.initial_joint_angles) < 0.02
    assert_stays(bench)
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)


def test_a_robot_that_was_stopped_walks_when_its_goal_is_given_again(bench: Bench):
    bench.start_robot(real_time_factor=SLOWLY)
    bench.client('stop')
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    answer = bench.call('stop')
    assert answer.success
    assert 'stops at the end of its gait cycle, on four feet' in answer.message
    bench.wait_for_status('gait_node', 'standing: stopped on request', level=OK)
    assert joints_away_from(bench, ROBOT.initial_joint_angles) < 0.02
    assert_stays(bench)
    assert bench.says('gait_node', 'standing: stopped on request')
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)


def test_a_robot_changes_its_gait_in_the_middle_of_a_walk_without_a_jump(bench: Bench):
    start_on_empty_floor(bench)
    heard = bench.hear(JointTrajectory, 'joint_trajectory')
    goal = Pose2D(3.2, 1.2, 0.0)
    give_plan(bench, START, goal)
    bench.wait_for_walking()

    refused = set_parameter(bench, 'gait', 'gallop')
    assert not refused.successful
    assert "'gait' is 'gallop'; it must be one of " in refused.reason
    assert 'wave' in refused.reason
    assert get_parameter(bench, 'gait') == 'crawl'
    # The refusal itself may be what the node said last.
    bench.wait_until(
        'walking as before',
        lambda: bench.statuses['gait_node'].values.get('gait') == 'crawl',
    )

    for gait in ('wave', 'crawl'):
        assert set_parameter(bench, 'gait', gait).successful
        bench.wait_until(
            f'walking with the {gait} gait',
            lambda gait=gait: (
                bench.statuses['gait_node'].values.get('gait') == gait
                and bench.activity == 'walking'
            ),
        )
        assert get_parameter(bench, 'gait') == gait
        bench.wait_for_walking(0.2)
    bench.wait_for_arrival(goal)
    assert bench.statuses['gait_node'].values['gait'] == 'crawl'
    trajectories = [trajectory_from_message(message) for message in heard]
    # The wave keeps its speed: its trajectories replace one another before they end.
    assert any(b.stamp + b.times[0] < a.end - 1.0 for a, b in pairwise(trajectories))
    assert_no_jump(trajectories)


def assert_no_jump(trajectories: list[Trajectory]) -> None:
    """Check that each trajectory is smooth, and begins as the last one goes on there."""
    for trajectory in trajectories:
        steps = np.diff(trajectory.positions, axis=0) / np.diff(trajectory.times)[:, None]
        assert (np.abs(steps) <= 1.01 * ROBOT.velocity.reshape(-1)).all()
    for before, after in pairwise(trajectories):
        begin = after.stamp + after.times[0]
        position, velocity = before.positions[-1], np.zeros(12)
        if begin < before.end:
            assert begin >= before.stamp + before.times[0] - 1e-9
            spline = CubicHermiteSpline(
                before.stamp + before.times, before.positions, before.velocities
            )
            position, velocity = spline(begin), spline(begin, 1)
        np.testing.assert_allclose(after.positions[0], position, atol=1e-3)
        np.testing.assert_allclose(after.velocities[0], velocity, atol=0.05)


def test_an_l_is_walked_sideways_with_crab_and_round_the_corner_with_arc(bench: Bench):
    start_on_empty_floor(bench, turning='crab')
    heard = bench.hear(Odometry, 'odom', EVERY_SAMPLE)
    corner, goal = Pose2D(1.6, 1.2, math.pi / 2), Pose2D(1.6, 1.6, 0.0)
    give_plan(bench, START, corner, goal)
    bench.wait_for_arrival(goal)
    poses = [pose_from_message(message.pose.pose) for message in heard]
    assert max(abs(pose.yaw) for pose in poses) < 0.1
    assert min(pose.distance_to(corner) for pose in poses) < 0.05

    assert set_parameter(bench, 'turning', 'arc').successful
    heard.clear()
    corner, end = Pose2D(2.2, 1.6, -math.pi / 2), Pose2D(2.2, 1.0, -math.pi / 2)
    give_plan(bench, goal, corner, end)
    bench.wait_for_arrival(end)
    poses = [pose_from_message(message.pose.pose) for message in heard]
    nearest = min(poses, key=corner.distance_to)
    assert 0.04 < nearest.distance_to(corner) < 0.15
    assert nearest.yaw == pytest.approx(-math.pi / 4, abs=0.35)
