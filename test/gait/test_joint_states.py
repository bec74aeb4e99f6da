"""Joint states of any driver: in any order, with other joints, without what is not measured."""

import math

import numpy as np
import pytest

pytest.importorskip('sensor_msgs')

from sensor_msgs.msg import JointState

from quad_common.errors import InvalidMessage
from quad_common.robot_files.robot_file import load_robot
from quad_gait.ros_conversions import joints_from_message

ROBOT = load_robot('titan_viii')
NAMES = list(ROBOT.joint_names)
POSITIONS = np.linspace(-0.5, 0.6, 12)
NANS = [math.nan] * 12


def state(names=NAMES, positions=POSITIONS, velocities=(), efforts=()):
    return JointState(
        name=list(names),
        position=list(map(float, positions)),
        velocity=list(map(float, velocities)),
        effort=list(map(float, efforts)),
    )


def test_joints_come_in_any_order_and_others_beside_them_may_be_unknown_or_named_twice():
    order = np.random.default_rng(0).permutation(12)
    names = ['arm', *(NAMES[k] for k in order), 'arm']
    numbers = [math.nan, *POSITIONS[order], math.inf]
    readings = joints_from_message(state(names, numbers, numbers, numbers), ROBOT)
    for values in readings[:3]:
        assert np.array_equal(values, POSITIONS)


def test_what_no_drive_measures_counts_as_left_out():
    readings = joints_from_message(state(velocities=NANS, efforts=NANS), ROBOT)
    assert np.array_equal(readings.positions, POSITIONS)
    assert readings.velocities is None
    assert readings.efforts is None
    with pytest.raises(InvalidMessage, match='positions are not finite'):
        joints_from_message(state(positions=NANS), ROBOT)
    with pytest.raises(InvalidMessage, match='efforts are not finite'):
        joints_from_message(state(efforts=[*NANS[:11], 1.0]), ROBOT)


def test_a_joint_that_is_named_twice_has_no_position():
    with pytest.raises(InvalidMessage, match=f"names '{NAMES[3]}' more than once"):
        joints_from_message(state([*NAMES, NAMES[3]], [*POSITIONS, 1.0]), ROBOT)


def test_a_driver_of_one_leg_is_told_that_joints_are_missing():
    with pytest.raises(InvalidMessage, match=f"'{NAMES[0]}' is missing, 9 of the 12 joints"):
        joints_from_message(state(NAMES[3:6], POSITIONS[3:6]), ROBOT)
