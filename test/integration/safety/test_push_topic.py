"""A message on 'push' pushes the robot in simulation, along its own axes or the map's."""

from __future__ import annotations

import math

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('pybullet')

import numpy as np
from geometry_msgs.msg import WrenchStamped
from harness import ERROR, Bench
from rcl_interfaces.srv import SetParameters
from rclpy.parameter import Parameter

from quad_common.robot_files.robot_file import load_robot
from quad_sim.ros_conversions import push_message

pytestmark = pytest.mark.ros

ROBOT = load_robot('cuhk')
WEIGHT = ROBOT.mass * 9.80665


@pytest.fixture
def bench(composed_bench: Bench) -> Bench:
    """Give a robot that stands with its left side to the map's -x."""
    start = [1.2, 1.2, math.pi / 2.0]
    composed_bench.start('sim_node', robot='cuhk', backend='bullet', start_pose=start)
    composed_bench.wait_for_robot()
    return composed_bench


def moved_by(bench: Bench, force: list[float], frame: str) -> np.ndarray:
    """Push; return how far the body has gone when it goes farthest [m]."""
    begin = bench.pose
    farthest = [np.zeros(2)]

    def is_over() -> bool:
        way = np.array([bench.pose.x - begin.x, bench.pose.y - begin.y])
        if np.linalg.norm(way) > np.linalg.norm(farthest[0]):
            farthest[0] = way
        return bench.time > since + 0.5

    since = bench.time
    bench.publisher(WrenchStamped, 'push').publish(push_message(np.array(force), frame))
    bench.wait_until('half a second goes by', is_over)
    assert bench.call('reset').success
    return farthest[0]


def test_a_push_goes_along_the_axes_of_its_frame(bench: Bench):
    to_its_left = moved_by(bench, [0.0, WEIGHT, 0.0], 'base_link')
    assert to_its_left[0] < -0.003
    assert abs(to_its_left[1]) < 0.3 * abs(to_its_left[0])
    assert moved_by(bench, [-WEIGHT, 0.0, 0.0], 'map') == pytest.approx(to_its_left, abs=0.003)


def test_how_long_a_push_lasts_is_set_while_the_node_runs(bench: Bench):
    short = moved_by(bench, [0.0, 0.5 * WEIGHT, 0.0], 'base_link')
    longer = Parameter('push_duration', value=0.3).to_parameter_msg()
    request = SetParameters.Request(parameters=[longer])
    assert bench.call('sim_node/set_parameters', SetParameters, request).results[0].successful
    longest = moved_by(bench, [0.0, 0.5 * WEIGHT, 0.0], 'base_link')
    assert np.linalg.norm(longest) > 1.5 * np.linalg.norm(short)


def test_what_is_no_push_is_refused_and_moves_nothing(bench: Bench):
    turning = push_message(np.zeros(3), 'map')
    turning.wrench.torque.z = 1.0
    refused = {
        "in frame 'moon'; give it in 'base_link'": push_message(np.zeros(3), 'moon'),
        'it must be at most 275 N, 20 times the weight': push_message(
            np.array([0.0, 280.0, 0.0]), 'map'
        ),
        'its torque is not zero': turning,
    }
    for words, message in refused.items():
        with bench.expects('sim_node', words, level=ERROR):
            bench.publisher(WrenchStamped, 'push').publish(message)
    assert np.linalg.norm(moved_by(bench, [0.0, 0.0, 0.0], 'map')) < 0.001
