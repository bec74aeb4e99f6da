"""What makes no sense is refused with a sentence, and does not end a node."""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from geometry_msgs.msg import PoseStamped, Twist, Vector3
from harness import ERROR, EVERY_SAMPLE, LATCHED, SENSOR, SLOWLY, START, Bench
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetPlan
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from quad_common.maps.occupancy_grid import OccupancyGrid as Grid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import grid_message, pose_message

pytestmark = pytest.mark.ros

QOS = {
    'map': LATCHED,
    'plan': LATCHED,
    'odom': SENSOR,
    'joint_states': SENSOR,
    'goal_pose': 10,
    'cmd_vel': 10,
    '/clock': SENSOR,
}
GIANT = '\n' * 10_000_000
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


def odometry(x: float, w: float = 1.0) -> Odometry:
    message = Odometry()
    message.header.frame_id = 'odom'
    message.pose.pose = pose_message(Pose2D(x, 1.2, 0.0))
    message.pose.pose.orientation.w = w
    return message


def goal_turned_by(w: float) -> PoseStamped:
    message = PoseStamped(pose=pose_message(GOAL))
    message.header.frame_id = 'map'
    message.pose.orientation.w = w
    return message


def in_frame(message: object, frame: str) -> object:
    message.header.frame_id = frame
    return message


def before_time() -> Clock:
    return Clock(clock=Time(sec=-1))


def plan(frame: str, *points: tuple[float, float]) -> Path:
    message = Path()
    message.header.frame_id = frame
    message.poses = [PoseStamped(pose=pose_message(Pose2D(x, y, 0.0))) for x, y in points]
    return message


def joints(names=NAMES, positions=12, velocities=12) -> JointState:
    return JointState(name=names, position=[0.0] * positions, velocity=[0.0] * velocities)


REFUSED = {
    'a map with too few cells': ('planner_node', 'map', a_map(width=81), 'has 6400 cells'),
    'a map without a scale': ('planner_node', 'map', a_map(math.nan), "'resolution' is nan"),
    'a map without a size': ('planner_node', 'map', a_map(width=0, height=0), '0 x 0 needs 0'),
    'a map without heading': ('planner_node', 'map', a_map(yaw_w=0.0), "the map's origin is not"),
    'odometry that is no pose': ('planner_node', 'odom', odometry(math.nan), 'odometry is not'),
    'odometry for the gait': ('gait_node', 'odom', odometry(math.inf), 'odometry is not a pose'),
    'a huge quaternion of a goal': (
        'planner_node',
        'goal_pose',
        goal_turned_by(1.4e154),
        'the goal is not a pose',
    ),
    'a huge quaternion for the planner': (
        'planner_node',
        'odom',
        odometry(1.2, 1e308),
        'the odometry is not a pose',
    ),
    'a huge quaternion for the gait': (
        'gait_node',
        'odom',
        odometry(1.2, 1e308),
        'the odometry is not a pose',
    ),
    'a long name of the odometry': (
        'gait_node',
        'odom',
        in_frame(odometry(1.2), 'x' * 100_000),
        '100000 characters',
    ),
    'a robot out of all maps': ('gait_node', 'odom', odometry(1e200), '-1e+06 to 1e+06 m'),
    'a clock before all time': ('gait_node', '/clock', before_time(), 'the clock cannot be used'),
    'the same for the planner': (
        'planner_node',
        '/clock',
        before_time(),
        'the clock cannot be used',
    ),
    'a giant name for the planner': (
        'planner_node',
        'goal_pose',
        in_frame(goal_turned_by(1.0), GIANT),
        '10000000 characters',
    ),
    'a giant name for the gait': (
        'gait_node',
        'plan',
        in_frame(plan('map', (0, 0)), GIANT),
        '310000 are the most',
    ),
    'a giant name of a map': ('planner_node', 'map', in_frame(a_map(), GIANT), 'printable'),
    'a long name for the gait': (
        'gait_node',
        'plan',
        in_frame(plan('map', (0, 0)), 'x' * 100_000),
        '100000 characters',
    ),
    'a plan without limits': (
        'gait_node',
        'plan',
        plan('map', *[(1.2, 1.2)] * 1001),
        '1001 poses; 1000 turning points',
    ),
    'a plan of more bytes than are taken apart': (
        'gait_node',
        'plan',
        plan('map', *[(1.2, 1.2)] * 6_000),
        '310000 are the most',
    ),
    'a map without limits': (
        'planner_node',
        'map',
        a_map(width=2**31, height=2**31),
        '67108864 are the most',
    ),
    'steering beyond all speed': (
        'gait_node',
        'cmd_vel',
        Twist(linear=Vector3(x=1e300)),
        'must be from -100 to 100',
    ),
    'a plan from the moon': ('gait_node', 'plan', plan('moon', (0, 0), (1, 0)), "frame 'moon'"),
    'a plan without end': ('gait_node', 'plan', plan('map', (1, 1), (math.nan, 1)), 'pose 1 of'),
    'joints without positions': ('gait_node', 'joint_states', joints(positions=0), '0 positions'),
    'joints of another robot': ('gait_node', 'joint_states', joints(['a'], 1, 1), 'is missing'),
    'too few velocities': ('gait_node', 'joint_states', joints(velocities=3), '3 velocities'),
}


def test_malformed_messages_are_refused_and_the_walk_goes_on(bench: Bench):
    # It stands for most of the time: the less is simulated meanwhile, the better.
    bench.start_robot(real_time_factor=SLOWLY)
    legs = bench.hear(Odometry, 'odom/legs', EVERY_SAMPLE)
    for node, topic, message, words in REFUSED.values():
        # Again and again, for what is best effort may be lost.
        with bench.publishing(topic, message, QOS[topic]), bench.expects(node, words, level=ERROR):
            pass
    assert {told.header.frame_id for told in legs} == {'odom'}
    for process in bench.processes.values():
        # Neither the names nor a stack: each was refused on purpose.
        assert len(process.log_tail(10_000)) < 50_000
    start = PoseStamped(pose=pose_message(START))
    request = GetPlan.Request(start=start, goal=goal_turned_by(1e308))
    assert not bench.call('get_plan', GetPlan, request).plan.poses
    # What the goal was refused for stands until a good one comes.
    bench.wait_for_status('planner_node', 'the goal is not a pose', level=ERROR)
    bench.give_goal(GOAL)
    bench.wait_for_arrival(GOAL)
    assert bench.pose.y == pytest.approx(START.y, abs=0.05)
