"""An imu that falls silent is said, and nothing is believed that it said before."""

from __future__ import annotations

import pytest

pytest.importorskip('rclpy')

from geometry_msgs.msg import Twist
from harness import OK, WARN

from quad_common.robot_files.robot_file import load_robot

pytestmark = pytest.mark.ros

ROBOT = load_robot('titan_viii')
PERIOD = 0.02
TURN = Twist()
TURN.angular.z = 0.1
AHEAD = Twist()
AHEAD.linear.x = 0.03


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('twist', [None, AHEAD], ids=['standing', 'walking'])
@pytest.mark.parametrize('ground', ['flat', 'uneven'])
def test_a_silent_imu_is_said_while_odometry_takes_its_place(make_node, ground, twist):
    robot = make_node('bullet' if ground == 'uneven' else 'kinematic', ground=ground)
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


def test_odometry_by_legs_turns_with_the_feet_when_the_imu_falls_silent(make_node):
    robot = make_node()
    odometry = robot.node._estimator.leg_odometry
    robot.run(0.5)
    start = odometry.pose.yaw - robot.yaw
    robot.run(6.0, TURN)
    robot.has_imu = False
    silent_since = robot.yaw
    robot.run(12.0, TURN)
    assert robot.yaw > silent_since + 0.3
    assert odometry.pose.yaw - robot.yaw == pytest.approx(start, abs=0.05)


def test_on_uneven_ground_a_robot_waits_whose_imu_alone_told_its_attitude(make_node):
    robot = make_node('bullet', ground='uneven', odom_topic='odom/legs')
    odometry_callback = robot.callbacks['odom/legs']
    robot.callbacks['odom'] = odometry_callback
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
