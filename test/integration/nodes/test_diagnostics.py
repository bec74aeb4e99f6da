"""Every node says what it waits for, and what it does."""

from __future__ import annotations

import re
import time
from itertools import count

import numpy as np
import pytest

pytest.importorskip('rclpy')

import rclpy
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped
from harness import OK, STALE, WARN, Bench
from nav_msgs.msg import Odometry
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import Header
from trajectory_msgs.msg import JointTrajectory

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import grid_message, pose_message, time_from_seconds

pytestmark = pytest.mark.ros


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what nodes say."""
    return composed_bench


@pytest.fixture
def other_context(domain):
    """Give the context of somebody who is not in the nodes' process."""
    context = rclpy.Context()
    rclpy.init(context=context)
    yield context
    context.try_shutdown()


def odometry_at(x: float, y: float) -> Odometry:
    message = Odometry()
    message.header.frame_id = 'odom'
    message.pose.pose = pose_message(Pose2D(x, y, 0.0))
    return message


def silent_for(bench: Bench) -> int:
    """Read for how long the planner says that odometry is silent [s]."""
    said = re.search(r'for (\d+) s; plans wait', bench.statuses['planner_node'].message)
    return 0 if said is None else int(said[1])


def stamped(message):
    """Make copies of a message, each a tenth of a second later, as a sensor does."""
    seconds = count(1)

    def make():
        message.header.stamp = time_from_seconds(next(seconds) / 10.0)
        return message

    return make


def test_the_planner_says_what_it_waits_for(bench: Bench):
    bench.start('planner_node', use_sim_time=False)
    bench.wait_for_status('planner_node', "no map: waiting for one on 'map'", level=WARN)
    free = OccupancyGrid(np.zeros((80, 80), np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
    bench.publish_map(grid_message(free, 'map', Time()))
    bench.wait_for_status('planner_node', "no odometry: waiting for it on 'odom'", level=WARN)
    with bench.publishing('odom', odometry_at(1.0, 1.0)):
        bench.wait_for_status('planner_node', "ready: waiting for a goal on 'goal_pose'", level=OK)
        bench.give_goal(Pose2D(3.0, 3.0, 0.0))
        bench.wait_for_status('planner_node', 'plan of', level=OK, code=0)
    bench.wait_for_status('planner_node', "silent odometry: none on 'odom' for", level=WARN)
    # From where the robot was seen last no plan is made any more.
    bench.give_goal(Pose2D(3.0, 1.0, 0.0))
    bench.wait_until('the planner still waits', lambda: silent_for(bench) >= 4)
    assert len(bench.plans) == 1
    with bench.publishing('odom', odometry_at(1.0, 1.0)):
        bench.wait_until('the plan that waited', lambda: len(bench.plans) == 2)
    assert bench.plan.poses[-1] == Pose2D(3.0, 1.0, 0.0)


def test_the_gait_node_says_what_it_waits_for(bench: Bench):
    bench.start('gait_node', use_sim_time=False, odom_timeout=1.0)
    bench.wait_for_status('gait_node', "no odometry: waiting for it on 'odom'", level=WARN)
    robot = load_robot('titan_viii')
    joints = JointState(
        name=list(robot.joint_names), position=robot.initial_joint_angles.reshape(-1).tolist()
    )
    odometry = odometry_at(1.0, 1.0)
    with bench.publishing('odom', stamped(odometry)):
        bench.wait_for_status('gait_node', 'no joint states yet', level=WARN)
        with bench.publishing('joint_states', stamped(joints)):
            bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)
    bench.wait_for_status('gait_node', 'no odometry', level=WARN)
    with bench.publishing('odom', odometry):
        bench.wait_for_status('gait_node', 'stale odometry: it comes', level=WARN)


def test_without_a_clock_the_nodes_ask_for_one(bench: Bench):
    for node in ('planner_node', 'gait_node'):
        bench.start(node)
    for node in ('planner_node', 'gait_node'):
        bench.wait_for_status(node, 'no clock: use_sim_time is true', level=STALE)


def test_a_paused_clock_is_stale_until_it_goes_on(bench: Bench):
    bench.start_robot()
    assert bench.call('pause').success
    bench.wait_for_status('sim_node', 'paused', level=OK)
    for node in ('planner_node', 'gait_node'):
        bench.wait_for_status(node, 'stale clock: simulated time stands still at', level=STALE)
    paused_at = bench.time
    assert bench.call('unpause').success
    bench.wait_for_status('sim_node', 'running', level=OK)
    bench.wait_for_status('planner_node', 'ready', level=OK)
    bench.wait_for_status('gait_node', 'standing', level=OK)
    assert bench.time > paused_at


def test_simulated_time_that_is_not_used_is_said_while_the_robot_walks(bench: Bench):
    bench.start('sim_node', map_file='none')
    bench.start('gait_node', use_sim_time=False)
    said = bench.wait_for_status(
        'gait_node', 'standing: no plan to follow; use_sim_time', level=WARN
    )
    assert said.message.endswith('with a simulator set it to true')
    true = Parameter('use_sim_time', value=True).to_parameter_msg()
    request = SetParameters.Request(parameters=[true])
    assert bench.call('gait_node/set_parameters', SetParameters, request).results[0].successful
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)


def test_odometry_of_another_time_than_that_of_the_clock_is_said(bench: Bench):
    bench.start('sim_node', map_file='none')
    bench.start('gait_node', odom_topic='robot/odom')
    odometry = odometry_at(1.0, 1.0)

    def of_today():
        odometry.header.stamp = time_from_seconds(time.time())
        return odometry

    with bench.publishing('robot/odom', of_today):
        said = bench.wait_for_status('gait_node', 'use_sim_time is true', level=WARN)
    assert said.message.endswith('after the time of /clock: set it to false on a real robot')


def test_a_robot_of_another_simulator_rightly_does_without_the_clock(bench: Bench):
    other = bench.node.create_publisher(Clock, '/clock', 1)
    bench.start('sim_node', map_file='none', publish_clock=False)
    bench.start('gait_node', use_sim_time=False)
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)
    with bench.publishing('/clock', Clock(clock=time_from_seconds(5000.0))):
        bench.wait_until('it simulates', lambda: bench.elapsed > 4.0)
    assert bench.statuses['gait_node'].message == 'standing: no plan to follow'
    bench.node.destroy_publisher(other)


def test_a_second_clock_is_noticed_and_said_until_it_is_gone(bench: Bench):
    bench.start('sim_node', map_file='none')
    bench.wait_for_status('sim_node', 'running', level=OK)
    other = bench.node.create_publisher(Clock, '/clock', 1)
    said = bench.wait_for_status('sim_node', 'running; /clock has 2 publishers', level=WARN)
    assert 'ROS_DOMAIN_ID' in said.message
    assert 'publish_clock:=false' in said.message
    bench.node.destroy_publisher(other)
    bench.wait_until('it runs alone', lambda: bench.statuses['sim_node'].message == 'running')


def test_a_simulator_without_a_clock_leaves_it_to_others(bench: Bench):
    other = bench.node.create_publisher(Clock, '/clock', 1)
    bench.start('sim_node', map_file='none', publish_clock=False)
    bench.wait_until('it simulates', lambda: bench.elapsed > 2.0)
    assert bench.node.count_publishers('/clock') == 1
    assert bench.wait_for_status('sim_node', 'running').message == 'running'
    bench.node.destroy_publisher(other)


def wait_for_publishers(bench: Bench, count: int) -> None:
    """Wait until so many publishers of steering are known; that takes real time."""
    bench.wait_until(
        f'{count} publishers are known',
        lambda: bench.node.count_publishers('cmd_vel') == count,
        simulated_timeout=3600.0,
    )


@pytest.mark.parametrize(
    ('is_stamped', 'other', 'wanted'), [(False, TwistStamped, 'true'), (True, Twist, 'false')]
)
def test_steering_of_the_type_that_is_not_received_is_said(
    bench: Bench, other_context, capfd, is_stamped, other, wanted
):
    bench.start('sim_node', map_file='none')
    bench.start('gait_node', stamped_cmd_vel=is_stamped)
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)
    # Who publishes another type does so from elsewhere: one process knows one type of a topic.
    stranger = rclpy.create_node('stranger', context=other_context)
    publisher = stranger.create_publisher(other, 'cmd_vel', 10)
    wait_for_publishers(bench, 1)
    said = bench.wait_for_status('gait_node', 'cmd_vel is published as', level=WARN).message
    assert said.endswith(
        f'cmd_vel is published as geometry_msgs/{other.__name__} and stamped_cmd_vel is '
        f'{str(is_stamped).lower()}: that steering is not received; set it to {wanted}'
    )
    bench.wait_until('some seconds', lambda: bench.elapsed > 4.0)
    assert 1 <= capfd.readouterr().err.count('that steering is not received') <= 2
    stranger.destroy_publisher(publisher)
    wait_for_publishers(bench, 0)
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)


@pytest.mark.parametrize(
    ('topic', 'kind', 'others'),
    [('joint_trajectory', JointTrajectory, 1), ('plan/heartbeat', Header, 2)],
)
def test_somebody_else_who_commands_or_plans_is_said_for_as_long_as_he_does(
    bench: Bench, topic, kind, others
):
    bench.start('sim_node', map_file='none')
    bench.start('gait_node')
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)
    made = [bench.node.create_publisher(kind, topic, 10) for _ in range(others)]
    said = bench.wait_for_status('gait_node', f'{topic} has 2 publishers', level=WARN)
    assert said.message.startswith('standing: no plan to follow; ')
    bench.node.destroy_publisher(made[0])
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)


def test_what_is_missing_at_the_start_is_a_warning_in_the_log_when_it_stays_missing(
    process_bench: Bench,
):
    bench = process_bench
    bench.start('gait_node', use_sim_time=False)
    bench.wait_for_status('gait_node', 'no odometry', level=WARN)
    process = bench.processes['gait_node']

    def logged(level: str) -> int:
        lines = process.log_tail(1000).splitlines()
        return sum(f'[{level}]' in line and 'no odometry' in line for line in lines)

    bench.wait_until('it is said', lambda: logged('INFO') == 1)
    assert logged('WARN') == 0
    bench.wait_until('the warning', lambda: logged('WARN') == 1)
