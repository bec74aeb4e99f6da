"""What makes no sense is refused with a sentence, and does not end a node."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped
from harness import ERROR, LATCHED, OK, SENSOR, START, Bench
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from sensor_msgs.msg import JointState

from quad_common.occupancy_grid import OccupancyGrid as Grid
from quad_common.planar_pose import Pose2D
from quad_common.robot import load_robot
from quad_common.ros_conversions import grid_message, pose_message

pytestmark = pytest.mark.ros

QOS = {'map': LATCHED, 'plan': LATCHED, 'odom': SENSOR, 'joint_states': SENSOR}
NAMES = list(load_robot('titan_viii').joint_names)
GOAL = Pose2D(1.6, 1.2, 0.0)


def a_map(resolution=0.05, yaw_w=1.0, **info) -> OccupancyGrid:
    grid = Grid(np.zeros((80, 80), np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
    message = grid_message(grid, 'map', Time())
    message.info.resolution = resolution
    message.info.origin.orientation.w = yaw_w
    for name, value in info.items():
        setattr(message.info, name, value)
    return message


def odometry(x: float) -> Odometry:
    message = Odometry()
    message.header.frame_id = 'odom'
    message.pose.pose = pose_message(Pose2D(x, 1.2, 0.0))
    return message


def plan(frame: str, *points: tuple[float, float]) -> Path:
    message = Path()
    message.header.frame_id = frame
    message.poses = [PoseStamped(pose=pose_message(Pose2D(x, y, 0.0))) for x, y in points]
    return message


def joints(names=NAMES, positions=12, velocities=12) -> JointState:
    return JointState(name=names, position=[0.0] * positions, velocity=[0.0] * velocities)


REFUSED = {
    'a map with too few cells': ('planner_node', 'map', a_map(width=81), 'has 6400 cells'),
    'a map without a scale': ('planner_node', 'map', a_map(math.nan), 'resolution of the map'),
    'a map without a size': ('planner_node', 'map', a_map(width=0, height=0), '0 x 0 needs 0'),
    'a map without heading': ('planner_node', 'map', a_map(yaw_w=0.0), "the map's origin is not"),
    'odometry that is no pose': ('planner_node', 'odom', odometry(math.nan), 'odometry is not'),
    'odometry for the gait': ('gait_node', 'odom', odometry(math.inf), 'odometry is not a pose'),
    'a plan from the moon': ('gait_node', 'plan', plan('moon', (0, 0), (1, 0)), "frame 'moon'"),
    'a plan without end': ('gait_node', 'plan', plan('map', (1, 1), (math.nan, 1)), 'pose 1 of'),
    'joints without positions': ('gait_node', 'joint_states', joints(positions=0), '0 positions'),
    'joints of another robot': ('gait_node', 'joint_states', joints(['a'], 1, 1), 'no joint'),
    'too few velocities': ('gait_node', 'joint_states', joints(velocities=3), '3 velocities'),
}


def test_malformed_messages_are_refused_and_the_walk_goes_on(bench: Bench):
    bench.start_robot()
    for node, topic, message, words in REFUSED.values():
        # Again and again, for what is best effort may be lost.
        with bench.publishing(topic, message, QOS[topic]), bench.expects(node, words, level=ERROR):
            pass
    bench.wait_for_status('planner_node', 'ready', level=OK)
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)
    assert bench.pose.y == pytest.approx(START.y, abs=0.05)
