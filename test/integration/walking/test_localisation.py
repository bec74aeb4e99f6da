"""Robots walk to goals on the map, by whatever tells where odometry's frame is in it."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import TransformStamped, Twist
from harness import ERROR, EVERY_SAMPLE, LATCHED, OK, START, WARN, Bench
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import Header

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import (
    grid_message,
    plan_from_message,
    pose_from_message,
    pose_transform,
)

pytestmark = pytest.mark.ros

GOAL = Pose2D(2.0, 1.2, 0.0)


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is where robots arrive."""
    return composed_bench


def correction(pose: Pose2D) -> TransformStamped:
    return pose_transform(pose, 'map', 'odom', Time())


def start_in_empty_room(bench: Bench, **sim_parameters: object) -> None:
    """Start all nodes in a room of 6 m by 6 m, and wait until a goal would be walked to."""
    bench.start('sim_node', map_file='none', **sim_parameters)
    bench.start('planner_node')
    bench.start('gait_node')
    empty = OccupancyGrid(np.zeros((120, 120), np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
    bench.publish_map(grid_message(empty, 'map', Time()))
    bench.wait_for_status('planner_node', 'ready', level=OK)
    bench.wait_for_status('gait_node', 'standing', level=OK)
    bench.wait_for_robot()


def test_by_drifting_odometry_and_a_localiser_a_robot_arrives_in_the_map(bench: Bench):
    truths = bench.hear(Odometry, 'odom/truth', EVERY_SAMPLE)
    bench.start_robot(odom_drift=0.1, localiser_rate=1.0, seed=4)
    bench.wait_until('the truth', lambda: bool(truths))
    bench.give_goal(GOAL)
    bench.wait_until('arrival', lambda: bench.activity == 'arrived')
    true = pose_from_message(truths[-1].pose.pose)
    assert truths[-1].header.frame_id == 'map'
    assert true.distance_to(GOAL) < 0.05
    assert bench.pose.distance_to(GOAL) > 0.03, 'odometry was to be wrong'


def test_corrections_count_for_planner_and_gait_and_old_ones_are_told_of(bench: Bench):
    moved = Pose2D(0.4, 0.6, 0.0)
    followed = bench.hear(Path, 'plan/followed', LATCHED)
    start_in_empty_room(bench)
    # The simulator's world and odometry coincide: this localiser says that the map does not.
    with bench.publishing('map_to_odom', correction(moved)):
        since = bench.elapsed
        bench.wait_until('corrections', lambda: bench.elapsed > since + 5.0)
        bench.give_goal(moved @ GOAL)
        bench.wait_until('a plan', lambda: bench.plan is not None)
        assert bench.plan.poses[0].distance_to(moved @ START) < 1e-3
        bench.wait_until('arrival', lambda: bench.activity == 'arrived')
        assert bench.is_near(GOAL)
        bench.wait_until('the plan has ended', lambda: followed and not followed[-1].poses)
        assert plan_from_message(followed[0]) == bench.plans[0]
        # A goal in odometry's frame is brought onto the map.
        bench.give_goal(Pose2D(2.2, 1.2, 0.0), frame='odom')
        bench.wait_until('a plan', lambda: len(bench.plans) > 1)
        assert bench.plans[-1].poses[-1].distance_to(moved @ Pose2D(2.2, 1.2, 0.0)) < 1e-6
        bad = correction(moved)
        bad.transform.translation.x = float('nan')
        with bench.expects('planner_node', "from 'map' to 'odom' is not used", level=ERROR):
            bench.publisher(TransformStamped, 'map_to_odom').publish(bad)
    bench.wait_for_status('planner_node', "old localisation: the last correction 'map'", level=WARN)
    bench.wait_for_status('gait_node', "the last correction 'map' -> 'odom' is", level=WARN)


def test_when_a_plan_has_ended_nothing_but_a_new_goal_makes_the_robot_walk(bench: Bench):
    near = Pose2D(1.4, 1.2, 0.0)
    beats = bench.hear(Header, 'plan/heartbeat')
    bench.start_robot()
    bench.give_goal(near)
    bench.wait_for_arrival(near)
    bench.wait_for_status('planner_node', 'it has ended', level=OK)
    # Steered away, farther than replan_distance.
    steer = Twist()
    steer.linear.y = 0.05
    with bench.publishing('cmd_vel', steer):
        bench.wait_until('the robot is elsewhere', lambda: bench.pose.y > 1.6)
    bench.wait_until('it stands', lambda: bench.activity == 'standing')
    since = bench.elapsed
    bench.wait_until('ten seconds go by', lambda: bench.elapsed > since + 10.0)
    assert bench.call('reset').success
    bench.wait_until('ten seconds go by', lambda: bench.elapsed > since + 20.0)
    assert bench.pose.distance_to(START) < 0.05
    assert [plan is None for plan in bench.plans] == [False, True]
    # A gait node that starts late does not walk what has ended, either.
    bench.kill('gait_node')
    bench.start('gait_node')
    bench.wait_for_status('gait_node', 'standing: no plan to follow', level=OK)
    bench.give_goal(near)
    bench.wait_for_arrival(near)
    assert beats
    assert beats[0].frame_id == 'map'


def test_a_planner_that_begins_anew_takes_over_the_goal_of_the_robot_that_walks(bench: Bench):
    far = Pose2D(3.5, 1.2, 0.0)
    # In the time that a planner takes to begin the robot must not arrive.
    start_in_empty_room(bench, real_time_factor=4.0)
    bench.give_goal(far)
    bench.wait_for_walking()
    bench.kill('planner_node')
    bench.start('planner_node')
    bench.wait_until('a plan of the new planner', lambda: len(bench.plans) == 2)
    assert bench.plans[1].poses[-1] == bench.plans[0].poses[-1]
    assert bench.plans[1].poses[0].x > START.x + 0.1
    assert not bench.is_near(far)
