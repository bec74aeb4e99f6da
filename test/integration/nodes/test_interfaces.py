"""Topics and services are as the contract says: who listens late hears, time is in order."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

pytest.importorskip('rclpy')

from harness import ERROR, LATCHED, START, Bench
from nav_msgs.msg import OccupancyGrid, Odometry, Path
from nav_msgs.srv import GetPlan
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import Imu
from std_msgs.msg import String

from quad_common.maps.map_file import load_map
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import plan_from_message, pose_message
from quad_sim.parameters import SimParameters

pytestmark = pytest.mark.ros

GOAL = Pose2D(2.0, 1.2, 0.0)

RELIABLE, BEST_EFFORT = ReliabilityPolicy.RELIABLE, ReliabilityPolicy.BEST_EFFORT
VOLATILE, TRANSIENT_LOCAL = DurabilityPolicy.VOLATILE, DurabilityPolicy.TRANSIENT_LOCAL

QOS = {
    'map': (RELIABLE, TRANSIENT_LOCAL),
    'plan': (RELIABLE, TRANSIENT_LOCAL),
    'robot_description': (RELIABLE, TRANSIENT_LOCAL),
    'joint_trajectory': (RELIABLE, VOLATILE),
    'diagnostics': (RELIABLE, VOLATILE),
    'odom': (BEST_EFFORT, VOLATILE),
    'joint_states': (BEST_EFFORT, VOLATILE),
    'imu': (BEST_EFFORT, VOLATILE),
    '/clock': (BEST_EFFORT, VOLATILE),
}


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give nodes in this process: what is asserted is what they publish and answer."""
    return composed_bench


def nanoseconds(stamp) -> int:
    return stamp.sec * 10**9 + stamp.nanosec


def test_simulated_time_comes_at_100_hz_and_stamps_what_is_measured(bench: Bench):
    deep = QoSProfile(depth=1000, reliability=ReliabilityPolicy.BEST_EFFORT)
    clock = bench.hear(Clock, '/clock', deep)
    odometry = bench.hear(Odometry, 'odom', deep)
    imu = bench.hear(Imu, 'imu', deep)
    # Sensors at the rate of real nodes; without physics, tests look half as often.
    bench.start('sim_node', sensor_rate=SimParameters().sensor_rate)
    # Each topic is discovered at its own time, so that the first message may come late.
    bench.wait_until(
        'three seconds of each topic',
        lambda: len(clock) > 300 and min(len(odometry), len(imu)) > 150,
    )

    ticks = np.array([nanoseconds(message.clock) for message in clock])
    periods = np.diff(ticks)
    assert np.all(periods > 0)
    # Best effort may lose one now and then.
    assert np.mean(periods <= 10_000_000) > 0.9
    for messages in (odometry, imu):
        stamps = np.array([nanoseconds(message.header.stamp) for message in messages])
        assert np.all(np.diff(stamps) > 0)
        assert np.mean(np.diff(stamps) <= 20_000_000) > 0.9
        within = (stamps >= ticks[0]) & (stamps <= ticks[-1])
        assert np.mean(np.isin(stamps[within], ticks)) > 0.9


def test_who_listens_late_still_hears_map_plan_and_robot_description(bench: Bench):
    bench.start_robot()
    bench.give_goal(GOAL)
    bench.wait_until('a plan', lambda: bench.plan is not None)
    maps = bench.hear(OccupancyGrid, 'map', LATCHED)
    plans = bench.hear(Path, 'plan', LATCHED)
    descriptions = bench.hear(String, 'robot_description', LATCHED)
    bench.wait_until('all are heard', lambda: bool(maps and plans and descriptions))

    grid = load_map(sample_map())
    assert (maps[0].info.height, maps[0].info.width) == grid.cells.shape
    assert np.array_equal(np.array(maps[0].data, np.int8), grid.cells.ravel())
    assert plan_from_message(plans[0]) == bench.plan
    urdf = ElementTree.fromstring(descriptions[0].data)
    assert urdf.tag == 'robot'
    joints = {joint.get('name') for joint in urdf.iter('joint')}
    assert set(load_robot('titan_viii').joint_names) <= joints

    for topic, (reliability, durability) in QOS.items():
        for endpoint in bench.node.get_publishers_info_by_topic(topic):
            qos = endpoint.qos_profile
            assert (qos.reliability, qos.durability) == (reliability, durability), topic


def test_a_plan_can_be_asked_for_without_walking_it(bench: Bench):
    bench.start('sim_node')
    bench.start('planner_node')
    bench.wait_for_status('planner_node', 'ready')

    def ask(start: Pose2D, goal: Pose2D) -> Path:
        request = GetPlan.Request()
        for field, pose in ((request.start, start), (request.goal, goal)):
            field.header.frame_id = 'map'
            field.pose = pose_message(pose)
        return bench.call('get_plan', GetPlan, request).plan

    answer = ask(START, GOAL)
    assert answer.header.frame_id == 'map'
    plan = plan_from_message(answer)
    assert plan.poses[0].distance_to(START) < 1e-6
    assert plan.poses[-1].distance_to(GOAL) < 1e-6

    with bench.expects('planner_node', 'the goal (-1.00, 0.00) m', level=ERROR, code=204):
        assert ask(START, Pose2D(-1.0, 0.0, 0.0)).poses == []
    with bench.expects('planner_node', 'the start', level=ERROR, code=203):
        assert ask(Pose2D(-1.0, 0.0, 0.0), GOAL).poses == []
    assert bench.plans == []
    bench.wait_for_status('planner_node', 'ready')
