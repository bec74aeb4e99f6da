"""Walks over topics by the ceiling camera alone, while things change or fail."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import PoseStamped
from harness import OK, PHYSICS, SLOWLY, WARN, Bench
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import pose_message

pytestmark = [pytest.mark.ros, pytest.mark.slow]

START = Pose2D(3.0, 3.0, 0.0)
ROBOT = load_robot('titan_viii')


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what camera, planner and gait do."""
    return composed_bench


def start(bench: Bench) -> None:
    """Start all nodes on an empty floor, and wait until a goal would be walked to."""
    bench.start('ceiling_camera_node')
    bench.start(
        'sim_node',
        backend=PHYSICS,
        real_time_factor=SLOWLY,
        map_file='none',
        camera=True,
        # To draw pictures is most of the work.
        camera_rate=1.0,
        publish_map=False,
        publish_tf=False,
        start_pose=[START.x, START.y, START.yaw],
    )
    bench.start('planner_node', odom_topic='odom/camera', method='shortest', any_angle=True)
    # By the wall clock: one test takes the pose away, and waits for what is said then.
    bench.start(
        'gait_node', odom_topic='odom/camera', leg_odometry_start='origin', odom_timeout=3.0
    )
    bench.wait_for_status('planner_node', 'ready', level=OK)
    bench.wait_for_status('gait_node', 'standing', level=OK)


def put_goal(bench: Bench, goal: Pose2D) -> None:
    """Lay the goal's marker on the floor; who sees it is the camera."""
    message = PoseStamped(pose=pose_message(goal))
    message.header.frame_id = 'map'
    bench.publisher(PoseStamped, 'goal_marker').publish(message)


def goes_to(bench: Bench, goal: Pose2D) -> bool:
    """Return whether the plan in force ends at a goal."""
    return bench.plan is not None and Pose2D(*bench.plan.corners[-1], 0.0).distance_to(goal) < 0.05


def test_an_obstacle_on_the_path_and_a_goal_that_moves_lead_to_new_plans(bench: Bench):
    start(bench)
    obstacles = bench.publisher(MarkerArray, 'obstacles')
    goal = Pose2D(5.5, 3.0, 0.0)
    put_goal(bench, goal)
    bench.wait_for_walking()
    assert goes_to(bench, goal)
    pillar = (4.4, 3.0)
    assert distance_to_polyline(pillar, bench.plan.corners) < 0.1
    box = Marker(ns='test', type=Marker.CYLINDER, pose=pose_message(Pose2D(*pillar, 0.0)))
    box.header.frame_id = 'map'
    box.scale.x = box.scale.y = 0.3
    box.scale.z = 0.5
    obstacles.publish(MarkerArray(markers=[box]))
    clearance = ROBOT.footprint_radius + 0.15
    bench.wait_until(
        'a plan around the pillar',
        lambda: (
            goes_to(bench, goal) and distance_to_polyline(pillar, bench.plan.corners) > clearance
        ),
    )
    moved = Pose2D(3.3, 3.5, 1.2)
    put_goal(bench, moved)
    bench.wait_until('a plan to the moved goal', lambda: goes_to(bench, moved))
    bench.wait_for_arrival(moved)
    assert bench.statuses['sim_node'].values['contacts'] == ''


def test_without_a_pose_the_robot_stops_on_four_feet_and_goes_on_when_it_is_seen(bench: Bench):
    start(bench)
    goal = Pose2D(4.0, 3.0, 0.0)
    put_goal(bench, goal)
    bench.wait_for_walking()
    bench.kill('ceiling_camera_node')
    bench.wait_for_status('gait_node', "no odometry: waiting for it on 'odom/camera'", level=WARN)
    since = bench.elapsed
    bench.wait_until('some time', lambda: bench.elapsed > since + 5.0)
    stood_at = bench.pose
    bench.wait_until('more time', lambda: bench.elapsed > since + 10.0)
    assert bench.pose.distance_to(stood_at) < 0.005
    assert max(np.abs(bench.joint_states.velocity)) < 0.01
    by_name = dict(zip(bench.joint_states.name, bench.joint_states.position))
    angles = np.array([by_name[name] for name in ROBOT.joint_names]).reshape(4, 3)
    heights = ROBOT.foot_positions(angles)[:, 2]
    assert np.ptp(heights) < 0.01
    assert stood_at.distance_to(goal) > 0.1
    bench.start('ceiling_camera_node')
    bench.wait_for_arrival(goal)
