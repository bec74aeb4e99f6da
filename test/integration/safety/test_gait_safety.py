"""The robot stops when it is told to, and when its planner is gone; over topics."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from harness import ERROR, LATCHED, OK, PHYSICS, WARN, Bench
from nav_msgs.msg import Path
from std_msgs.msg import Bool, Header
from std_srvs.srv import SetBool

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_planner.ros_conversions import path_message

pytestmark = pytest.mark.ros

GOAL = Pose2D(1.8, 1.2, 0.0)


def fastest_joint(bench: Bench) -> float:
    return float(np.abs(bench.joint_states.velocity).max())


def test_an_emergency_stop_freezes_the_robot_until_it_is_released(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot(backend=PHYSICS, real_time_factor=2.0)
    bench.client('emergency_stop', SetBool)
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.wait_until('a leg swings', lambda: fastest_joint(bench) > 0.5)
    assert bench.call('emergency_stop', SetBool, SetBool.Request(data=True)).success
    stopped_at = bench.elapsed
    bench.wait_until('the joints are still', lambda: fastest_joint(bench) < 0.05)
    assert bench.elapsed - stopped_at < 0.2
    bench.wait_for_status('gait_node', 'emergency stop', level=ERROR)
    bench.wait_for_status('sim_node', 'the emergency stop is on', level=WARN)

    there = bench.pose
    bench.give_goal(Pose2D(2.0, 1.2, 0.0))
    bench.wait_until('five seconds pass', lambda: bench.elapsed - stopped_at > 5.0)
    assert bench.pose.distance_to(there) < 2e-3
    assert bench.call('emergency_stop', SetBool, SetBool.Request(data=False)).success
    bench.wait_for_status('gait_node', 'it waits for stand', level=ERROR)
    bench.wait_until('three more pass', lambda: bench.elapsed - stopped_at > 8.0)
    assert bench.pose.distance_to(there) < 2e-3

    assert bench.call('stand').success
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)
    assert bench.statuses['sim_node'].values['has_fallen'] == 'False'


def test_an_emergency_stop_outlives_the_gait_node_that_was_asked_for_it(composed_bench: Bench):
    bench = composed_bench
    bench.start('sim_node')
    bench.start('gait_node')
    bench.wait_for_status('gait_node', 'standing', level=OK)
    assert bench.call('emergency_stop', SetBool, SetBool.Request(data=True)).success
    bench.wait_for_status('sim_node', 'the emergency stop is on', level=WARN)
    bench.kill('gait_node')

    bench.start('gait_node')
    bench.wait_for_status('gait_node', 'all joints hold until it is released', level=ERROR)
    assert not bench.call('stand').success
    # Its own stops are its own to release, whatever was said of them before.
    assert bench.call('emergency_stop', SetBool, SetBool.Request(data=False)).success
    bench.wait_for_status('gait_node', 'it waits for stand', level=ERROR)
    assert bench.call('stand').success
    bench.wait_for_status('gait_node', 'standing', level=OK)
    bench.wait_until(
        'trajectories are executed', lambda: 'stop is on' not in bench.statuses['sim_node'].message
    )


def test_a_stop_that_somebody_else_publishes_is_taken_over_in_mid_step(composed_bench: Bench):
    bench = composed_bench
    bench.start_robot(backend=PHYSICS, real_time_factor=2.0)
    # It has decided on a stop of its own before.
    for is_on in (True, False):
        assert bench.call('emergency_stop', SetBool, SetBool.Request(data=is_on)).success
    assert bench.call('stand').success
    bench.give_goal(GOAL)
    bench.wait_for_walking()
    bench.wait_until('a leg swings', lambda: fastest_joint(bench) > 0.5)
    bench.publisher(Bool, 'emergency_stop/active', LATCHED).publish(Bool(data=True))
    bench.wait_for_status('gait_node', 'all joints hold until it is released', level=ERROR)
    assert not bench.call('stand').success

    assert bench.call('emergency_stop', SetBool, SetBool.Request(data=False)).success
    bench.wait_for_status('gait_node', 'it waits for stand', level=ERROR)
    assert bench.call('stand').success
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)


def test_a_driver_that_holds_the_joints_by_itself_stops_the_robot(composed_bench: Bench):
    bench = composed_bench
    bench.start('sim_node')
    bench.start('gait_node')
    bench.wait_for_status('gait_node', 'standing', level=OK)
    for is_on in (True, False):
        assert bench.call('emergency_stop', SetBool, SetBool.Request(data=is_on)).success
    assert bench.call('stand').success
    driver = bench.publisher(Bool, 'emergency_stop/held', LATCHED)

    def is_stopped() -> bool:
        # What comes soon after its own stop is taken for an echo of it.
        driver.publish(Bool(data=True))
        return 'all joints hold' in bench.statuses['gait_node'].message

    bench.wait_until('the gait takes the stop over', is_stopped)


def test_the_planner_remembers_an_emergency_stop_where_no_simulator_does(composed_bench: Bench):
    bench = composed_bench
    bench.start('planner_node', use_sim_time=False)
    bench.start('gait_node', use_sim_time=False)
    bench.wait_for_status('gait_node', 'odometry')
    assert bench.call('emergency_stop', SetBool, SetBool.Request(data=True)).success
    held = bench.hear(Bool, 'emergency_stop/held', LATCHED)
    bench.wait_until('it is remembered', lambda: bool(held) and held[-1].data)
    bench.kill('gait_node')
    bench.start('gait_node', use_sim_time=False)
    bench.wait_for_status('gait_node', 'the emergency stop is on', level=WARN)


def test_a_plan_waits_for_a_planner_whose_heartbeat_stops(composed_bench: Bench):
    bench = composed_bench
    bench.start('sim_node', map_file='none')
    # Of the wall clock, on which the simulation goes as fast as it can.
    bench.start('gait_node', planner_timeout=0.3)
    bench.wait_for_status('gait_node', 'standing', level=OK)
    bench.wait_for_robot()
    start = bench.pose
    heartbeat = bench.publisher(Header, 'plan/heartbeat', 10)
    plan = Plan.through([[start.x, start.y], [start.x + 8.0, start.y]], 0.0)
    bench.publisher(Path, 'plan', LATCHED).publish(path_message(plan, 'map', Time()))

    def lives() -> bool:
        heartbeat.publish(Header())
        return bench.pose.distance_to(start) > 0.15

    bench.wait_until('the robot walks', lives)
    # From here on nobody says that the planner lives.
    bench.wait_for_status('gait_node', 'no heartbeat of the planner for 0.3 s', level=WARN)
    waiting = bench.pose
    since = bench.elapsed
    bench.wait_until('eight seconds pass', lambda: bench.elapsed - since > 8.0)
    assert bench.pose.distance_to(waiting) < 2e-3

    def goes_on() -> bool:
        heartbeat.publish(Header())
        return bench.pose.distance_to(waiting) > 0.1

    bench.wait_until('the robot goes on', goes_on)
    # Silent again; but the next plan is of somebody who never said that he lives.
    bench.wait_for_status('gait_node', 'no heartbeat of the planner for 0.3 s', level=WARN)
    waiting = bench.pose
    longer = Plan.through([[waiting.x, waiting.y], [start.x + 9.0, start.y]], 0.0)
    bench.publisher(Path, 'plan', LATCHED).publish(path_message(longer, 'map', Time()))
    bench.wait_until('it follows that', lambda: bench.pose.distance_to(waiting) > 0.3)
