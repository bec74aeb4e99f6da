"""What must never be published is noticed."""

from __future__ import annotations

import math
from array import array
from dataclasses import replace

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_gate import VELOCITY_TOLERANCE
from quad_lab.attacks.stage.limits import JointChecker, TrajectoryChecker, extremes, position_at
from quad_lab.attacks.stage.state import growth, traceback_ends

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)


def trajectory(stamp=1.0, hip=(0.0, 0.1, 0.2), period=0.1, velocities=None) -> JointTrajectory:
    """Move one hip from the posture, by the given angles [rad]."""
    positions = np.tile(POSTURE, (len(hip), 1))
    positions[:, 0] += hip
    speeds = np.zeros_like(positions)
    if velocities is not None:
        speeds[:, 0] = velocities
    return JointTrajectory(
        ROBOT.joint_names, stamp, np.arange(len(hip)) * period, positions, speeds
    )


def problems(*trajectories: JointTrajectory, now: float = 0.8) -> list[str]:
    checker = TrajectoryChecker(ROBOT)
    return [problem for each in trajectories for problem in checker.check(each, now)]


def test_a_trajectory_within_the_limits_is_left_alone():
    assert problems(trajectory(), trajectory(stamp=1.2, hip=(0.2, 0.1, 0.0))) == []


def test_joints_may_come_in_any_order():
    usual = trajectory()
    turned = replace(
        usual,
        joint_names=usual.joint_names[::-1],
        positions=usual.positions[:, ::-1],
        velocities=usual.velocities[:, ::-1],
    )
    assert problems(usual, turned) == []


@pytest.mark.parametrize('angle', [7.85, -7.85, 1e308])
def test_a_position_outside_the_range_is_noticed(angle):
    found = problems(trajectory(hip=(0.0, angle - POSTURE[0], 0.0), period=100.0))
    assert found
    assert ROBOT.joint_names[0] in found[0]


def test_a_speed_between_the_points_is_noticed():
    # At rest at both ends: half as fast again in the middle as on the average.
    most = 6.0 * (1.0 + VELOCITY_TOLERANCE) / 1.5 * 0.1
    just, beyond = 0.99 * most, 1.01 * most
    assert problems(trajectory(hip=(0.0, just))) == []
    assert 'faster' in problems(trajectory(hip=(0.0, beyond)))[0]


def test_a_speed_at_a_point_is_noticed():
    assert 'faster' in problems(trajectory(velocities=(0.0, 6.1, 0.0)))[0]


def test_a_position_between_the_points_is_noticed():
    room = ROBOT.upper[0, 0] - POSTURE[0]
    swung = trajectory(hip=(room - 0.01,) * 2, period=1.0, velocities=(1.0, -1.0))
    _, high, _ = extremes(swung)
    # 0.01 rad below the limit at the points, a quarter above it between them.
    assert high[0] == pytest.approx(ROBOT.upper[0, 0] - 0.01 + 0.25)
    assert any('above' in problem for problem in problems(swung))


def test_extremes_are_those_of_many_samples():
    rng = np.random.default_rng(3)
    for _ in range(6):
        drawn = trajectory(hip=rng.uniform(-0.3, 0.3, 5), velocities=rng.uniform(-3, 3, 5))
        low, high, fast = extremes(drawn)
        times = np.linspace(1.0, 1.4, 40_001)
        hip = np.array([position_at(drawn, t)[0] for t in times[::10]])
        assert low[0] == pytest.approx(hip.min(), abs=1e-4)
        assert high[0] == pytest.approx(hip.max(), abs=1e-4)
        assert fast[0] == pytest.approx(np.abs(np.diff(hip)).max() / 1e-4, rel=0.02)


def test_a_leap_from_the_last_command_is_noticed():
    far = trajectory(stamp=1.3, hip=(0.9, 0.9))
    assert 'from its last command' in problems(trajectory(), far, now=1.25)[-1]
    # With time enough it is no leap.
    assert problems(trajectory(), replace(far, stamp=2.3), now=1.25) == []


@pytest.mark.parametrize(('hip', 'is_leap'), [(0.1, False), (0.2, True)])
def test_a_trajectory_that_runs_already_may_be_off_by_20_ms_of_motion(hip, is_leap):
    hold = trajectory(hip=(0.0, 0.0))
    # 6 rad/s turn 0.12 rad in 20 ms, and 0.02 rad are one place.
    found = problems(hold, trajectory(stamp=2.0, hip=(hip, hip)), now=2.14)
    assert bool(found) == is_leap


@pytest.mark.parametrize(('answered', 'is_leap'), [(None, True), (1.7, True), (1.1, False)])
def test_a_trajectory_is_judged_by_when_it_was_decided_on(answered, is_leap):
    # It leaves the last one at 1.3 s, and comes when that one has gone on for 0.3 s.
    checker = TrajectoryChecker(ROBOT)
    checker.check(trajectory(hip=(0.0, 0.0, 0.0, 0.0, 0.3, 0.6, 0.9)), 0.8)
    back = trajectory(stamp=1.35, hip=(0.05, 0.05))
    assert bool(checker.check(back, 1.7, answered)) == is_leap


def test_a_robot_that_was_put_elsewhere_does_not_leap():
    checker = TrajectoryChecker(ROBOT)
    checker.check(trajectory(), 0.8)
    checker.forget(until=2.0)
    assert checker.check(trajectory(stamp=1.3, hip=(0.9, 0.9)), 1.25) == []


def test_a_missing_joint_is_noticed():
    whole = trajectory()
    part = replace(
        whole,
        joint_names=whole.joint_names[1:],
        positions=whole.positions[:, 1:],
        velocities=whole.velocities[:, 1:],
    )
    assert ROBOT.joint_names[0] in problems(part)[0]


def test_measured_joints_that_jump_or_leave_their_range_are_noticed():
    checker = JointChecker(ROBOT)
    assert checker.check(1.0, POSTURE) == []
    assert checker.check(1.02, POSTURE + 0.05) == []
    assert 'moved by' in checker.check(1.04, POSTURE + 0.5)[0]
    assert 'outside' in JointChecker(ROBOT).check(1.0, POSTURE + 3.0)[0]


def test_the_end_of_a_traceback_says_what_it_was():
    log = 'all is well\nTraceback (most recent call last):\n  File "x", line 1\nValueError: no\nend'
    assert traceback_ends(log + '\n' + log) == ['ValueError: no'] * 2
    assert traceback_ends('all is well') == []


def test_growth_is_of_what_was_measured_twice():
    assert growth({'a': 100.0, 'b': 50.0}, {'a': 104.0, 'c': 7.0}) == {'a': pytest.approx(0.04)}


def test_numbers_that_are_not_finite_are_found_wherever_they_are():
    pytest.importorskip('rclpy')
    from geometry_msgs.msg import PoseStamped
    from nav_msgs.msg import Odometry, Path
    from sensor_msgs.msg import JointState

    from quad_lab.attacks.stage.checks import numbers_not_finite

    odometry = Odometry()
    assert numbers_not_finite(odometry) == []
    odometry.twist.covariance[35] = math.inf
    odometry.pose.pose.position.z = math.nan
    assert numbers_not_finite(odometry) == [
        'pose.pose.position.z is nan',
        'twist.covariance[35] is inf',
    ]
    states = JointState(name=['a'], position=array('d', [0.0, -math.inf]))
    assert numbers_not_finite(states) == ['position[1] is -inf']
    path = Path(poses=[PoseStamped(), PoseStamped()])
    path.poses[1].pose.orientation.w = math.nan
    assert numbers_not_finite(path) == ['poses[1].pose.orientation.w is nan']


def test_texts_that_are_too_long_are_found():
    pytest.importorskip('rclpy')
    from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue

    from quad_lab.attacks.stage.checks import LONGEST_TEXT, texts_too_long

    status = DiagnosticStatus(message='x' * LONGEST_TEXT, values=[KeyValue(value='y')])
    message = DiagnosticArray(status=[status])
    assert texts_too_long(message) == []
    status.values[0].value = 'y' * (LONGEST_TEXT + 1)
    assert texts_too_long(message) == [f'status[0].values[0].value has {LONGEST_TEXT + 1} letters']
