"""An imu that falls silent is said, and nothing is believed that it said before."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import pytest

pytest.importorskip('rclpy')

import rclpy
from geometry_msgs.msg import Twist
from harness import OK, WARN
from rclpy.parameter import Parameter

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot_file import load_robot
from quad_common.ros.pose_conversions import time_from_seconds
from quad_gait.gait_node import GaitNode
from quad_sim.engines.registry import make_simulator
from quad_sim.parameters import SimParameters
from quad_sim.ros_conversions import (
    imu_message,
    joint_state_message,
    odometry_message,
    trajectory_from_message,
)
from quad_sim.simulation import Simulation

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
PERIOD = 0.02
TURN = Twist()
TURN.angular.z = 0.1
AHEAD = Twist()
AHEAD.linear.x = 0.03


class Robot:
    """A gait node and a simulation in this process: messages are handed on, not sent."""

    def __init__(self, node: GaitNode, backend: str = 'kinematic') -> None:
        self.node = node
        self.simulation = Simulation(
            make_simulator(backend, ROBOT, None), ROBOT, Pose2D(0.0, 0.0, 0.0)
        )
        self.has_imu = True
        self.said: list[tuple[bytes, str]] = []
        self._callbacks = {s.topic_name.lstrip('/'): s.callback for s in node.subscriptions}
        self._rng = np.random.default_rng(0)
        node._topics._trajectories.publish = lambda message: self.simulation.accept(
            trajectory_from_message(message)
        )
        node.report = lambda level, message, **_: self.said.append((level, message))

    def hear(self, topic: str, message: object) -> None:
        self._callbacks[topic](message)

    def run(self, seconds: float, twist: Twist | None = None) -> None:
        """Go on for a time, steered or not; in the end the node says what it does."""
        parameters = SimParameters()
        end = self.simulation.time + seconds
        while self.simulation.time < end:
            seen = self.simulation.observe()
            stamp = time_from_seconds(seen.time)
            if twist is not None:
                self.hear('cmd_vel', twist)
            if self.has_imu:
                noise = self._rng.standard_normal((2, 3))
                self.hear('imu', imu_message(seen, parameters, noise, stamp))
            self.hear('joint_states', joint_state_message(seen, ROBOT.joint_names, stamp))
            odometry = odometry_message(seen, parameters, np.zeros(4), stamp)
            self.hear('odom', odometry)
            for _ in range(round(PERIOD / self.simulation.time_step)):
                self.simulation.step()
        self.node.update_status()

    @property
    def yaw(self) -> float:
        return self.simulation.observe().pose.yaw


@pytest.fixture
def make(domain) -> Iterator[Callable[..., Robot]]:
    context = rclpy.Context()
    rclpy.init(context=context)
    robots: list[Robot] = []

    def make_robot(backend: str = 'kinematic', **parameters: object) -> Robot:
        # Time is odometry's here; there is no clock to hear.
        given = {'use_sim_time': False, **parameters}
        overrides = [Parameter(key, value=value) for key, value in given.items()]
        robots.append(Robot(GaitNode(context=context, parameter_overrides=overrides), backend))
        return robots[-1]

    yield make_robot
    for robot in robots:
        robot.simulation.close()
        robot.node.destroy_node()
    context.try_shutdown()


@pytest.mark.parametrize('twist', [None, AHEAD], ids=['standing', 'walking'])
@pytest.mark.parametrize('ground', ['flat', 'uneven'])
def test_a_silent_imu_is_said_while_odometry_takes_its_place(make, ground, twist):
    robot = make('bullet' if ground == 'uneven' else 'kinematic', ground=ground)
    robot.run(6.0, twist)
    assert robot.said[-1][0] == OK, robot.said[-1]
    doing = robot.said[-1][1].split(':')[0]
    assert doing == ('standing' if twist is None else 'walking')
    before = robot.simulation.observe().pose
    robot.has_imu = False
    robot.said.clear()
    robot.run(6.0, twist)
    assert all(level in (OK, WARN) for level, _ in robot.said)
    level, words = robot.said[-1]
    assert level == WARN
    assert words.startswith(doing)
    assert "no imu for 6.0 s: odometry's attitude takes its place" in words
    # At once, not with the next second of the wall clock.
    assert 'no imu for 0.2 s' in next(words for level, words in robot.said if level == WARN)
    if twist is not None:
        assert robot.simulation.observe().pose.x > before.x + 0.1
    robot.has_imu = True
    # After so long it is believed when its readings have fit one another for a moment.
    robot.run(0.5, twist)
    assert robot.said[-1][0] == OK


def test_odometry_by_legs_turns_with_the_feet_when_the_imu_falls_silent(make):
    robot = make()
    odometry = robot.node._estimator.leg_odometry
    robot.run(0.5)
    start = odometry.pose.yaw - robot.yaw
    robot.run(6.0, TURN)
    robot.has_imu = False
    silent_since = robot.yaw
    robot.run(12.0, TURN)
    assert robot.yaw > silent_since + 0.3
    assert odometry.pose.yaw - robot.yaw == pytest.approx(start, abs=0.05)


def test_on_uneven_ground_a_robot_waits_whose_imu_alone_told_its_attitude(make):
    robot = make('bullet', ground='uneven', odom_topic='odom/legs')
    odometry_callback = robot._callbacks['odom/legs']
    robot._callbacks['odom'] = odometry_callback
    robot.run(4.0, AHEAD)
    assert robot.said[-1][1].startswith('walking')
    robot.has_imu = False
    robot.run(3.0, AHEAD)
    there = robot.simulation.observe().pose
    robot.run(3.0, AHEAD)
    level, words = robot.said[-1]
    assert (level, words.split(' for ')[0]) == (WARN, 'waiting: no imu')
    assert words.count('no imu') == 1
    assert 'odometry by legs does not tell roll and pitch' in words
    assert robot.simulation.observe().pose.distance_to(there) < 2e-3
    robot.has_imu = True
    robot.run(6.0, AHEAD)
    assert robot.said[-1][1].startswith('walking')
    assert robot.simulation.observe().pose.distance_to(there) > 0.05
