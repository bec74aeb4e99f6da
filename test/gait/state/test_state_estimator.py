"""Readings become one state, and leg odometry goes on by them."""

from dataclasses import replace

import numpy as np
import pytest
from told_supervisor import measurement

from quad_common.errors import InvalidMessage
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.state.robot_state import RobotState
from quad_gait.state.sensor_inputs import JointReadings
from quad_gait.state.state_estimator import EstimatorOptions, StateEstimator
from quad_gait.state.support import Support

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
ORIGIN = Pose2D(0.0, 0.0, 0.0)
HERE = Pose2D(1.0, 2.0, 0.5)


def readings(time, positions=POSTURE):
    return JointReadings(positions, np.zeros(12), None, time)


def test_what_is_measured_is_in_the_state_word_for_word():
    told = measurement(ROBOT, 1.0, problem='none', odometry=HERE)
    state = StateEstimator(ROBOT).judge(told)
    for name, value in told.__dict__.items():
        assert getattr(state, name) is value
    assert state == replace(state)


def test_a_state_can_be_placed_elsewhere_with_nothing_left_of_the_pose_before():
    state = StateEstimator(ROBOT).judge(measurement(ROBOT, 1.0))
    polygon = state.support_polygon(np.ones(4, dtype=bool))
    placed = state.placed(HERE, ORIGIN)
    assert (placed.pose, placed.odometry, placed.motion_pose) == (HERE, ORIGIN, ORIGIN)
    assert placed.time == state.time
    moved = placed.support_polygon(np.ones(4, dtype=bool))
    assert moved == pytest.approx(HERE.transform(polygon))


@pytest.mark.parametrize('change', [{'was_moved': True}, {'time': 0.5}])
def test_after_a_reset_nothing_holds_that_was_known_of_the_joints(change):
    estimator = StateEstimator(ROBOT)
    still = {'joint_velocities': np.full(12, 0.5)}
    for time in np.arange(1.0, 2.0, 0.02):
        state = estimator.judge(measurement(ROBOT, time, **still))
    assert state.is_at_rest
    assert not state.was_moved
    state = estimator.judge(replace(measurement(ROBOT, 2.0, **still), **change))
    assert state.was_moved
    assert not state.is_at_rest


def test_without_joints_there_is_no_margin_and_no_polygon():
    state = StateEstimator(ROBOT).judge(measurement(ROBOT, 1.0, joint_positions=None))
    standing = np.ones(4, dtype=bool)
    assert not state.has_joints
    assert np.isnan(state.stability_margin(standing))
    assert state.support_polygon(standing).shape == (0, 2)


def test_leg_odometry_begins_where_odometry_first_has_the_robot():
    estimator = StateEstimator(ROBOT, EstimatorOptions(has_leg_odometry=True))
    assert not estimator.take_joints(readings(0.98))
    assert isinstance(estimator.take_odometry(1.0, HERE, LEVEL), RobotState)
    assert estimator.leg_odometry.pose == HERE
    assert estimator.take_joints(readings(1.02))
    # Said again it says nothing new.
    assert not estimator.take_joints(readings(1.02))
    assert estimator.take_odometry(1.0, HERE, LEVEL) is None


def test_leg_odometry_of_its_own_frame_needs_no_other_odometry():
    options = EstimatorOptions(has_leg_odometry=True, starts_at_origin=True)
    estimator = StateEstimator(ROBOT, options)
    assert estimator.take_joints(readings(1.0))
    estimator.take_odometry(1.02, HERE, LEVEL)
    assert estimator.leg_odometry.pose == ORIGIN


def test_support_is_asked_for_at_the_time_of_the_joints():
    asked = []

    def support(time):
        asked.append(time)
        return Support(np.ones(4, dtype=bool), (0.5, -0.1))

    options = EstimatorOptions(has_leg_odometry=True, starts_at_origin=True)
    estimator = StateEstimator(ROBOT, options, support)
    for time in (1.0, 1.02, 1.04):
        estimator.take_joints(readings(time))
    assert asked == [1.0, 1.02, 1.04]
    # The body moves as it is known to, though no joint does.
    pose = estimator.leg_odometry.pose
    assert (pose.x, pose.y) == pytest.approx((0.02, -0.004))


def test_joints_that_cannot_be_there_change_nothing():
    options = EstimatorOptions(has_leg_odometry=True, starts_at_origin=True)
    estimator = StateEstimator(ROBOT, options)
    estimator.take_joints(readings(1.0))
    with pytest.raises(InvalidMessage):
        estimator.take_joints(readings(1.02, POSTURE + 9.0))
    state = estimator.take_odometry(1.02, ORIGIN, LEVEL)
    assert np.array_equal(state.joint_positions, POSTURE)
