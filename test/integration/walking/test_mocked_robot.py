"""What gait_node publishes ros2_control's joint_trajectory_controller takes, and follows."""

import numpy as np
import pytest

pytest.importorskip('rclpy')

import yaml
from geometry_msgs.msg import Twist
from sensor_msgs.msg import JointState
from trajectory_controller import TrajectoryController

from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.ros2_control import (
    CONTROLLER,
    UPDATE_RATE,
    ExportOptions,
    export_robot,
)
from quad_common.ros.pose_conversions import pose_from_message, time_from_seconds
from quad_common.trajectory.trajectory_gate import VELOCITY_TOLERANCE

pytestmark = [pytest.mark.ros, pytest.mark.slow]

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)

EVERY = 4
"""Updates of the controllers from one joint state that is looked at to the next."""


class MockedRobot:
    """
    A gait node, and the controllers of an exported robot with mocked hardware.

    Its joints are where they are commanded; its only odometry is that of its legs.
    """

    def __init__(self, make_node, joints, positions=POSTURE, **parameters):
        self.node = make_node(odom_topic='odom/legs', **parameters).node
        self.controller = TrajectoryController(joints, positions)
        self.taken = []
        self.poses = []
        self.commands = []
        self._callbacks = {s.topic_name.lstrip('/'): s.callback for s in self.node.subscriptions}
        self._updates = 0
        self.node._topics._trajectories.publish = self._take
        self.node._topics._leg_odometry = self

    @property
    def activity(self):
        return str(self.node._supervisor.activity.value)

    def get_subscription_count(self):
        return 1

    def publish(self, odometry):
        """Hand the odometry of the legs back to the node."""
        self.poses.append(pose_from_message(odometry.pose.pose))
        self._callbacks['odom/legs'](odometry)

    def _take(self, message):
        assert self.controller.refusal(message, self.controller.time) == ''
        self.taken.append(message)
        self.controller.take(message)

    def run(self, seconds, twist=None):
        for _ in range(round(seconds * UPDATE_RATE)):
            self._updates += 1
            now = self._updates / UPDATE_RATE
            self.controller.update(now)
            self.commands.append(self.controller.position)
            if self._updates % EVERY == 0:
                if twist is not None:
                    self._callbacks['cmd_vel'](twist)
                self._callbacks['joint_states'](
                    JointState(
                        header=self._header(now),
                        name=self.controller.joints,
                        position=self.controller.position.tolist(),
                        velocity=self.controller.velocity.tolist(),
                        effort=[0.0] * len(self.controller.joints),
                    )
                )

    def _header(self, now):
        header = JointState().header
        header.stamp = time_from_seconds(now)
        return header


@pytest.fixture
def exported_joints(tmp_path):
    """List the joints of an exported robot's controller."""
    export_robot(ROBOT, tmp_path, ExportOptions(ROBOT.name))
    document = yaml.safe_load((tmp_path / 'controllers.yaml').read_text())
    return document[f'/**/{CONTROLLER}']['ros__parameters']['joints']


def steered(forward, turn):
    twist = Twist()
    twist.linear.x, twist.angular.z = forward, turn
    return twist


@pytest.mark.parametrize('gait', ['crawl', 'trot'])
def test_the_controller_takes_every_trajectory_and_the_commands_are_smooth(
    make_node, exported_joints, gait
):
    robot = MockedRobot(make_node, exported_joints, gait=gait)
    robot.run(1.0)
    robot.run(12.0, steered(0.03, 0.0))
    walked = robot.poses[0].inverse() @ robot.poses[-1]
    robot.run(8.0, steered(0.01, 0.1))
    robot.run(12.0)

    assert len(robot.taken) > 3
    assert all(message.joint_names == exported_joints for message in robot.taken)
    assert walked.x > 0.15
    # A crawling body sways.
    assert abs(walked.y) < 0.05
    turned = walked.inverse() @ (robot.poses[0].inverse() @ robot.poses[-1])
    assert turned.yaw > 0.3
    commands = np.array(robot.commands)
    assert np.all(commands >= ROBOT.lower.reshape(-1) - 1e-6)
    assert np.all(commands <= ROBOT.upper.reshape(-1) + 1e-6)
    speeds = np.abs(np.diff(commands, axis=0)) * UPDATE_RATE
    assert np.all(speeds <= (1.0 + VELOCITY_TOLERANCE) * ROBOT.velocity.reshape(-1))
    # Nobody steers any more: it stands in its posture.
    np.testing.assert_allclose(commands[-1], POSTURE, atol=1e-6)


def test_from_any_posture_it_stands_up_by_trajectories_that_are_taken(make_node, exported_joints):
    bent = POSTURE + np.tile([0.1, 0.15, -0.2], 4)
    robot = MockedRobot(make_node, exported_joints, positions=bent)
    robot.run(15.0)
    assert robot.taken
    np.testing.assert_allclose(robot.controller.position, POSTURE, atol=1e-3)


def test_trajectories_begin_in_the_future_at_rest_and_in_the_past_in_motion(
    make_node, exported_joints
):
    robot = MockedRobot(make_node, exported_joints, gait='trot')
    robot.run(1.0)
    arrivals = []
    take = robot.controller.take

    def note(message):
        stamp = message.header.stamp.sec + 1e-9 * message.header.stamp.nanosec
        first = message.points[0].time_from_start
        arrivals.append(stamp + first.sec + 1e-9 * first.nanosec - robot.controller.time)
        take(message)

    robot.controller.take = note
    robot.run(6.0, steered(0.05, 0.0))
    assert arrivals[0] > 0.0
    assert len(arrivals) > 5
    # One that replaces another in motion begins where that one is now.
    assert all(-0.1 < ahead <= 0.0 for ahead in arrivals[1:])
