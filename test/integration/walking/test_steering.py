"""A robot walks with the velocity that it is told on cmd_vel, and stops when nobody steers."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Twist, TwistStamped, Vector3
from harness import ERROR, EVERY_SAMPLE, LATCHED, OK, PHYSICS, WARN, Bench
from nav_msgs.msg import Path
from std_msgs.msg import Header

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import seconds_from_time
from quad_gait.ros_conversions import joints_from_message
from quad_planner.ros_conversions import path_message

pytestmark = pytest.mark.ros

# Steering comes ten times a second of the wall clock: simulated time may not run away from it.
BOUNDED = {'map_file': 'none', 'real_time_factor': 10.0}
TIMEOUT = 20.0


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is how they steer."""
    return composed_bench


def start_steered(bench: Bench, sim: dict[str, object], **gait_parameters: object) -> None:
    """Start simulator and gait on an empty floor; who steers needs no planner."""
    bench.start('sim_node', **BOUNDED, **sim)
    bench.start('gait_node', cmd_vel_timeout=TIMEOUT, **gait_parameters)
    bench.wait_for_status('gait_node', 'standing', level=OK)


def twist(forward: float = 0.0, left: float = 0.0, turn: float = 0.0) -> Twist:
    return Twist(linear=Vector3(x=forward, y=left), angular=Vector3(z=turn))


def give_plan(bench: Bench, goal: Pose2D) -> None:
    """Publish a plan of one straight piece, as a planner would."""
    start = bench.pose
    plan = Plan((Pose2D(start.x, start.y, start.heading_to(goal)), goal))
    bench.publisher(Path, 'plan', LATCHED).publish(path_message(plan, 'map', Time()))


def test_a_robot_that_keeps_its_balance_begins_in_step_with_the_simulator(bench: Bench):
    # It answered ten times a second until it trotted, and its first trajectories came late.
    cuhk = {'robot': 'cuhk'}
    start_steered(bench, {'backend': PHYSICS, **cuhk}, **cuhk, gait='trot', balance=True)
    beats = bench.hear(Header, 'gait/heartbeat', EVERY_SAMPLE)
    bench.wait_until('it stands for a while', lambda: len(beats) > 30)
    start = bench.pose
    give_plan(bench, start @ Pose2D(0.5, 0.0, 0.0))
    bench.wait_until('it has trotted', lambda: bench.pose.distance_to(start) > 0.2)
    answered = [seconds_from_time(beat.stamp) for beat in beats]
    assert max(after - before for before, after in pairwise(answered)) < 0.05


def mean_rate(bench: Bench, quantity: Callable[[], float], duration: float) -> float:
    """Listen for a while, whole gait cycles best; return how fast a quantity has changed."""
    value, begin = quantity(), bench.time
    bench.wait_until(f'{duration} s go by', lambda: bench.time >= begin + duration)
    return (quantity() - value) / (bench.time - begin)


def wait_for_way(bench: Bench, distance: float) -> None:
    start = bench.pose
    bench.wait_until(f'{distance} m walked', lambda: bench.pose.distance_to(start) > distance)


def wait_for_rest(bench: Bench) -> None:
    """Listen until no joint has moved for two seconds."""
    moved_at = bench.time

    def is_at_rest() -> bool:
        nonlocal moved_at
        if np.abs(bench.joint_states.velocity).max() > 0.01:
            moved_at = bench.time
        return bench.time > moved_at + 2.0

    bench.wait_until('the joints are at rest', is_at_rest)


def assert_stands_on_four_feet(bench: Bench, robot_name: str = 'titan_viii') -> None:
    """Check that the robot rests in its initial posture, and stays where it is."""
    robot = load_robot(robot_name)
    stopped, since = bench.pose, bench.elapsed
    bench.wait_until('ten seconds go by', lambda: bench.elapsed > since + 10.0)
    assert bench.pose.distance_to(stopped) < 1e-3
    assert abs(wrap_angle(bench.pose.yaw - stopped.yaw)) < 1e-3
    positions, velocities, *_ = joints_from_message(bench.joint_states, robot)
    assert np.abs(velocities).max() < 0.01
    feet = robot.foot_positions(positions.reshape(4, 3))
    np.testing.assert_allclose(feet, robot.neutral_feet, atol=0.05 * robot.hip_height)
    assert np.ptp(feet[:, 2]) < 0.03 * robot.hip_height


def test_a_robot_walks_and_turns_as_it_is_steered_and_stops_when_nobody_steers(bench: Bench):
    start_steered(bench, {'backend': PHYSICS, 'robot': 'genibo'}, robot='genibo', gait='wave')
    start = bench.pose
    with bench.publishing('cmd_vel', twist(forward=0.02)):
        wait_for_way(bench, 0.05)
        assert mean_rate(bench, lambda: bench.pose.x, 12.0) == pytest.approx(0.02, rel=0.1)
        assert bench.activity == 'walking'
        assert bench.pose.y == pytest.approx(start.y, abs=0.02)
        assert abs(wrap_angle(bench.pose.yaw - start.yaw)) < 0.05
    steered_at: list[float] = []

    def turn() -> Twist:
        steered_at.append(bench.time)
        return twist(turn=0.2)

    with bench.publishing('cmd_vel', turn):
        yaw = bench.pose.yaw
        bench.wait_until('the robot turns left', lambda: bench.pose.yaw > yaw + 0.3)
        turned_at = bench.pose
        assert mean_rate(bench, lambda: bench.pose.yaw, 8.0) == pytest.approx(0.2, rel=0.1)
        assert bench.pose.distance_to(turned_at) < 0.02
        assert bench.statuses['gait_node'].values['limit'] == ''
    with bench.expects('gait_node', 'standing: the steering has timed out', level=OK):
        pass
    wait_for_rest(bench)
    # The cycle in which it times out, one more to come to rest, and time to hear of it.
    assert TIMEOUT - 2.0 < bench.time - steered_at[-1] < TIMEOUT + 15.0
    assert_stands_on_four_feet(bench, 'genibo')
    said = bench.statuses['sim_node'].values
    assert (said['contacts'], said['has_fallen']) == ('', 'False')


def test_a_robot_whose_steering_has_timed_out_says_that_it_stands_when_it_does(bench: Bench):
    start_steered(bench, {}, gait='wave')
    with bench.publishing('cmd_vel', twist(forward=0.06)):
        bench.wait_for_walking(0.3)
    with bench.expects('gait_node', 'standing: the steering has timed out', level=OK):
        pass
    said_at = bench.pose
    wait_for_rest(bench)
    assert bench.pose.distance_to(said_at) < 0.02


def test_steering_beyond_the_limits_is_slowed_down_and_a_plan_ends_it(bench: Bench):
    start_steered(bench, {})
    bench.publisher(Path, 'plan', LATCHED)
    start = bench.pose
    with bench.publishing('cmd_vel', twist(forward=1.0)):
        status = bench.wait_for_status('gait_node', 'walking: ', level=WARN)
        limit = status.values['limit']
        assert limit.startswith('steered at (1.000, 0.000) m/s and 0.0 deg/s, walking at (0.045, ')
        assert 'the most that the crawl gait does: the largest stride is 0.226 m' in limit
        assert status.message.endswith(limit)
        assert 'walking 0.226 m' in status.message
        wait_for_way(bench, 0.35)
        assert bench.pose.y == pytest.approx(start.y, abs=0.01)
    ahead = bench.pose @ Pose2D(0.6, 0.0, 0.0)
    with bench.expects('gait_node', 'arrived: the goal is reached', level=OK):
        give_plan(bench, ahead)
    assert bench.is_near(ahead)
    assert bench.statuses['gait_node'].values['limit'] == ''
    assert_stands_on_four_feet(bench)


BAD_TWISTS = [
    (twist(forward=math.nan), 'its numbers are not finite'),
    (Twist(linear=Vector3(x=0.02, z=0.1)), 'linear z, angular x and angular y are (0.1, 0.0, 0.0)'),
]


def test_a_velocity_that_makes_no_sense_is_refused_and_the_robot_keeps_to_its_plan(bench: Bench):
    start_steered(bench, {})
    bench.publisher(Twist, 'cmd_vel')
    goal = bench.pose @ Pose2D(0.5, 0.0, 0.0)
    give_plan(bench, goal)
    bench.wait_for_walking(0.05)
    with bench.held():
        for message, words in BAD_TWISTS:
            with bench.expects('gait_node', words, level=ERROR):
                bench.publisher(Twist, 'cmd_vel').publish(message)
        bench.wait_for_status('gait_node', 'walking: ', level=OK)
        assert BAD_TWISTS[-1][1] in bench.statuses['gait_node'].values['last_error']
    bench.wait_for_arrival(goal)
    # Nor does it disturb the steering that is in force.
    with bench.publishing('cmd_vel', twist(left=0.02)):
        bench.wait_for_walking(0.05)
        with bench.expects('gait_node', BAD_TWISTS[0][1], level=ERROR):
            bench.publisher(Twist, 'cmd_vel').publish(BAD_TWISTS[0][0])
        bench.wait_for_walking(0.2)
        # In each cycle, of five seconds.
        assert bench.says('gait_node', 'walking 0.100 m', level=OK)
    # The crawl sways the body by up to 4 cm.
    assert bench.pose.x == pytest.approx(goal.x, abs=0.06)


def test_velocities_may_have_stamps_and_end_the_walk_along_a_plan(bench: Bench):
    start_steered(bench, {}, stamped_cmd_vel=True)
    give_plan(bench, bench.pose @ Pose2D(2.0, 0.0, 0.0))
    bench.wait_for_walking()
    start = bench.pose
    with bench.publishing('cmd_vel', TwistStamped(twist=twist(forward=-0.02, turn=0.05))):
        bench.wait_until('the robot turns left', lambda: bench.pose.yaw > start.yaw + 0.2)
        assert bench.activity == 'walking'
        # What was left of the cycle that the plan had begun led ahead.
        turned_at = bench.pose
        bench.wait_until(
            'the robot walks backwards', lambda: (turned_at.inverse() @ bench.pose).x < -0.1
        )
    with bench.publishing('cmd_vel', TwistStamped()):
        bench.wait_for_status('gait_node', 'standing: steered to stand', level=OK)
    bench.wait_for_status('gait_node', 'standing: the steering has timed out', level=OK)
    assert_stands_on_four_feet(bench)
