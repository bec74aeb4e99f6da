"""A pose, a tilt, a transform from a message is right, or refused with a sentence."""

import itertools
import math

import numpy as np
import pytest

pytest.importorskip('rclpy')

from builtin_interfaces.msg import Time
from geometry_msgs.msg import Pose, Quaternion
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Clock

from quad_common.errors import InvalidMessage, InvalidPose, QuadError
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import (
    LARGEST_COORDINATE,
    base_transform,
    check_clock,
    footprint_transform,
    orientation_from_odometry,
    pose_from_message,
    pose_message,
    seconds_from_time,
    time_from_seconds,
)

pytestmark = pytest.mark.ros

BAD = [math.nan, math.inf, -math.inf, 1e308, -1e308, 1.4e154, -1e154, 1e7]


def odometry(pose: Pose) -> Odometry:
    message = Odometry()
    message.pose.pose = pose
    return message


def good_pose() -> Pose:
    return pose_message(Pose2D(1.0, -2.0, 0.5))


READERS = {
    'pose': lambda pose: pose_from_message(pose),
    'orientation': lambda pose: orientation_from_odometry(odometry(pose)),
    'base transform': lambda pose: base_transform(odometry(pose)),
    'footprint transform': lambda pose: footprint_transform(odometry(pose), 'base_footprint'),
}


@pytest.mark.parametrize('component', 'xyzw')
@pytest.mark.parametrize('value', BAD)
@pytest.mark.parametrize('reader', READERS.values(), ids=READERS)
def test_one_absurd_component_of_a_quaternion_is_refused(reader, value, component):
    pose = good_pose()
    setattr(pose.orientation, component, value)
    with pytest.raises(InvalidPose, match='quaternion'):
        reader(pose)


@pytest.mark.parametrize('axis', 'xyz')
@pytest.mark.parametrize('value', BAD)
@pytest.mark.parametrize('name', ['pose', 'base transform', 'footprint transform'])
def test_a_position_out_of_range_is_refused_with_the_range(name, value, axis):
    pose = good_pose()
    setattr(pose.position, axis, value)
    with pytest.raises(InvalidPose, match=r'-1e\+06 to 1e\+06 m'):
        READERS[name](pose)


def test_the_range_of_positions_includes_its_ends():
    for x, y in itertools.product([-LARGEST_COORDINATE, -0.0, LARGEST_COORDINATE], repeat=2):
        assert pose_from_message(pose_message(Pose2D(x, y, 0.0))) == Pose2D(x, y, 0.0)


def test_a_quaternion_of_nearly_unit_length_is_normalised():
    rng = np.random.default_rng(0)
    for _ in range(200):
        q = rng.standard_normal(4)
        x, y, z, w = (q / np.linalg.norm(q)).tolist()
        scale = rng.uniform(0.91, 1.09)
        exact, scaled = good_pose(), good_pose()
        exact.orientation = Quaternion(x=x, y=y, z=z, w=w)
        scaled.orientation = Quaternion(x=scale * x, y=scale * y, z=scale * z, w=scale * w)
        yaw = pose_from_message(exact).yaw
        assert math.remainder(pose_from_message(scaled).yaw - yaw, math.tau) == pytest.approx(
            0.0, abs=1e-9
        )
        told = orientation_from_odometry(odometry(scaled))
        assert np.linalg.norm(told) == pytest.approx(1.0)
        assert told == pytest.approx(orientation_from_odometry(odometry(exact)))


@pytest.mark.parametrize(
    'stamp',
    [
        Time(sec=-1),
        Time(sec=-(2**31), nanosec=0),
        Time(sec=-1, nanosec=999_999_999),
        Time(sec=1, nanosec=10**9),
        Time(sec=2**31 - 1, nanosec=2**32 - 1),
    ],
)
def test_a_stamp_before_zero_or_with_too_many_nanoseconds_is_refused(stamp):
    with pytest.raises(InvalidMessage, match='must be 0 s or more'):
        seconds_from_time(stamp)
    with pytest.raises(InvalidMessage, match='the clock cannot be used'):
        check_clock(Clock(clock=stamp))


@pytest.mark.parametrize('seconds', [math.nan, math.inf, 1e308, 2.0**31])
def test_seconds_that_no_stamp_holds_are_refused(seconds):
    with pytest.raises(QuadError, match='time stamp'):
        time_from_seconds(seconds)


@pytest.mark.parametrize('seconds', [-math.inf, -1e308, -0.0, 0.0])
def test_times_before_zero_become_zero(seconds):
    assert time_from_seconds(seconds) == Time()
