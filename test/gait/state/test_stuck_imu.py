"""An imu that tells the same attitude over and over in a walk is left out, and named."""

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.state.sensor_inputs import InputOptions, JointReadings, SensorInputs

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
ORIGIN = Pose2D(0.0, 0.0, 0.0)
STEP = 0.02


def rolled(angle):
    return np.array([np.sin(angle / 2.0), 0.0, 0.0, np.cos(angle / 2.0)])


def walked(inputs, attitude_at, begin, end, swing=0.2, odometry=0.01):
    """Swing a joint to and fro; return the last measurement."""
    now = None
    for time in np.arange(begin, end, STEP):
        joints = POSTURE.copy()
        joints[1] += swing * np.sin(3.0 * time)
        inputs.take_joints(JointReadings(joints, None, None, time))
        inputs.take_imu(time, attitude_at(time), 0.0)
        now = inputs.take_odometry(time, ORIGIN, rolled(odometry))
    return now


def alive(time):
    return rolled(0.05 + 0.01 * np.sin(7.0 * time))


@pytest.mark.parametrize('stuck_at', [0.02, 0.15])
def test_a_stuck_imu_gives_way_to_odometry_and_comes_back(stuck_at):
    inputs = SensorInputs(ROBOT)
    walked(inputs, alive, 0.0, 3.0)
    assert not inputs.imu_problem
    now = walked(inputs, lambda time: rolled(stuck_at), 3.0, 7.0)
    assert 'the imu has told the same attitude for' in inputs.imu_problem
    assert inputs.imu_problem.endswith("odometry's attitude takes its place")
    assert np.array_equal(now.orientation, rolled(0.01))
    assert inputs.imu_at(7.0) == (None, None)
    assert not now.problem
    now = walked(inputs, alive, 7.0, 7.1)
    assert not inputs.imu_problem
    assert np.array_equal(now.orientation, alive(now.time))


def test_a_robot_that_needs_its_attitude_stops_for_a_stuck_imu():
    options = InputOptions(odometry_has_attitude=False, needs_attitude=True)
    inputs = SensorInputs(ROBOT, options)
    assert not walked(inputs, alive, 0.0, 3.0).problem
    assert 'the same attitude' in walked(inputs, lambda time: rolled(0.1), 3.0, 7.0).problem


def test_a_robot_that_stands_still_proves_nothing():
    inputs = SensorInputs(ROBOT)
    walked(inputs, lambda time: rolled(0.1), 0.0, 10.0, swing=0.0)
    assert not inputs.imu_problem


def test_an_attitude_that_is_rounded_changes_often_enough():
    inputs = SensorInputs(ROBOT)
    walked(inputs, lambda time: rolled(round(0.05 + 0.005 * np.sin(2.0 * time), 3)), 0.0, 10.0)
    assert not inputs.imu_problem


@pytest.mark.parametrize(('odometry', 'is_stuck'), [(0.0, False), (0.02, False), (0.1, True)])
def test_an_ideal_imu_is_level_to_the_last_digit_as_long_as_odometry_agrees(odometry, is_stuck):
    # As simulators without physics tell it.
    inputs = SensorInputs(ROBOT)
    walked(inputs, lambda time: np.array([0.0, 0.0, 0.0, 1.0]), 0.0, 10.0, odometry=odometry)
    assert bool(inputs.imu_problem) == is_stuck


def test_an_attitude_that_is_level_but_for_rounding_is_ideal():
    inputs = SensorInputs(ROBOT)
    walked(inputs, lambda time: np.array([1e-17, 0.0, 0.0, 1.0]), 0.0, 10.0)
    assert not inputs.imu_problem


def test_an_imu_that_comes_no_more_is_silent_and_not_stuck():
    inputs = SensorInputs(ROBOT)
    walked(inputs, lambda time: rolled(0.1), 0.0, 0.5, swing=0.0)
    for time in np.arange(0.5, 5.0, STEP):
        joints = POSTURE.copy()
        joints[1] += 0.2 * np.sin(3.0 * time)
        inputs.take_joints(JointReadings(joints, None, None, time))
        inputs.take_odometry(time, ORIGIN, rolled(0.01))
    assert inputs.imu_problem.startswith('no imu for')
