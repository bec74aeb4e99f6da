"""
A recording has the robot's own time, keeps the order of messages, and tells where its links are.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

pytest.importorskip('rosbags')
pytest.importorskip('nav_msgs')

from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader
from rosbags.typesys import Stores, get_typestore
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from quad_common.robot.urdf import published_urdf
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import time_from_seconds
from quad_common.rotations import matrix_from_quaternion
from quad_lab.recordings.recorded_topics import (
    CLOCK,
    DESCRIPTION,
    GOAL,
    JOINT_STATES,
    ODOMETRY,
    SHARED_FIXED_TRANSFORMS,
    SHARED_TRANSFORMS,
)
from quad_lab.recordings.robot_recording import RobotRecording
from quad_lab.recordings.robot_transforms import Others
from quad_lab.recordings.transform_pattern import TransformPattern

TYPES = get_typestore(Stores.ROS2_JAZZY)

ROBOT = load_robot('titan_viii')

NO_ODOMETRY = Others(has_body=False, has_odometry=False)

ANGLES = ROBOT.initial_joint_angles + np.linspace(-0.1, 0.1, 12).reshape(4, 3)

DESCRIBED = serialize_message(String(data=published_urdf(ROBOT)))


def clock(time):
    return serialize_message(Clock(clock=time_from_seconds(time)))


def joints(time, angles=ANGLES):
    message = JointState(name=list(ROBOT.joint_names), position=angles.reshape(-1).tolist())
    message.velocity, message.effort = [0.0] * 12, [0.0] * 12
    message.header.stamp = time_from_seconds(time)
    return serialize_message(message)


def odometry(time, x=0.0, prefix=''):
    message = Odometry(child_frame_id=f'{prefix}base_link')
    message.header.frame_id = f'{prefix}odom'
    message.header.stamp = time_from_seconds(time)
    message.pose.pose.position.x = x
    return serialize_message(message)


def messages(folder):
    with Reader(folder) as reader:
        return [
            (connection.topic, time * 1e-9, TYPES.deserialize_cdr(data, connection.msgtype))
            for connection, time, data in reader.messages()
        ]


def transforms(folder):
    return [
        transform
        for topic, _, message in messages(folder)
        if topic.endswith(('/tf', '/tf_static'))
        for transform in message.transforms
    ]


def matrix(transform):
    place, turn = transform.translation, transform.rotation
    made = np.eye(4)
    made[:3, :3] = matrix_from_quaternion(np.array([turn.x, turn.y, turn.z, turn.w]))
    made[:3, 3] = place.x, place.y, place.z
    return made


@pytest.mark.parametrize('leg', range(4))
def test_links_are_where_kinematics_has_them(tmp_path, leg):
    with RobotRecording(tmp_path / 'bag', others=NO_ODOMETRY) as recording:
        recording.take(DESCRIPTION, DESCRIBED)
        recording.take(CLOCK, clock(3.0))
        recording.take(JOINT_STATES, joints(3.0))
    frames = {
        transform.child_frame_id: (transform.header.frame_id, matrix(transform.transform))
        for transform in transforms(tmp_path / 'bag')
    }
    name, pose = f'{ROBOT.legs[leg].name}_foot', np.eye(4)
    while name != 'base_link':
        name, step = frames[name]
        pose = step @ pose
    assert pose[:3, 3] == pytest.approx(ROBOT.foot_positions(ANGLES)[leg], abs=1e-6)


def test_links_of_others_are_left_to_them(tmp_path):
    with RobotRecording(tmp_path / 'bag', others=Others(has_links=True)) as recording:
        recording.take(DESCRIPTION, DESCRIBED)
        recording.take(JOINT_STATES, joints(0.0))
    names = {topic for topic, _, _ in messages(tmp_path / 'bag')}
    assert names == {'/robot_description', '/joint_states'}


def test_transforms_are_as_frequent_as_pictures_of_a_film(tmp_path):
    with RobotRecording(tmp_path / 'bag', others=NO_ODOMETRY) as recording:
        recording.take(DESCRIPTION, DESCRIBED)
        for k in range(50):
            recording.take(JOINT_STATES, joints(0.02 * k))
    assert sum(topic == '/tf' for topic, _, _ in messages(tmp_path / 'bag')) == 25


@pytest.mark.parametrize('has_links', [False, True])
def test_the_body_is_placed_on_the_map_where_nobody_publishes_transforms(tmp_path, has_links):
    with RobotRecording(tmp_path / 'bag', others=Others(False, has_links)) as recording:
        recording.take(CLOCK, clock(1.0))
        recording.take(ODOMETRY, odometry(1.0, x=2.5))
    found = {
        (transform.header.frame_id, transform.child_frame_id): transform.transform.translation.x
        for transform in transforms(tmp_path / 'bag')
    }
    assert found == {('odom', 'base_link'): 2.5, ('map', 'odom'): 0.0}


def test_messages_have_simulated_times_and_keep_their_order(tmp_path):
    with RobotRecording(tmp_path / 'bag') as recording:
        recording.take(CLOCK, clock(7.25))
        recording.take(JOINT_STATES, joints(7.25))
        recording.take(GOAL, serialize_message(String()))
        recording.take(DESCRIPTION, DESCRIBED)
    with Reader(tmp_path / 'bag') as reader:
        order = [(c.topic, time) for c, time, _ in reader.messages() if 'tf' not in c.topic]
    topics = ['/clock', '/joint_states', '/goal_pose', '/robot_description']
    assert [topic for topic, _ in order] == topics
    assert all(math.isclose(time * 1e-9, 7.25, abs_tol=1e-4) for _, time in order)


def test_what_is_latched_has_the_time_at_which_recording_begins(tmp_path):
    with RobotRecording(tmp_path / 'bag') as recording:
        recording.take(DESCRIPTION, DESCRIBED)
        recording.take(ODOMETRY, odometry(12.0))
        recording.take(CLOCK, clock(12.0))
        recording.take(JOINT_STATES, joints(12.02))
    with Reader(tmp_path / 'bag') as reader:
        assert reader.start_time == pytest.approx(12e9, abs=1e6)
        assert reader.duration < 1e6
        assert next(reader.messages())[0].topic == '/robot_description'


def test_without_a_clock_nothing_is_lost(tmp_path):
    with RobotRecording(tmp_path / 'bag', others=Others(has_links=True)) as recording:
        recording.take(DESCRIPTION, DESCRIBED)
    assert [topic for topic, _, _ in messages(tmp_path / 'bag')] == ['/robot_description']


def test_without_a_simulator_it_is_the_time_of_the_machine(tmp_path):
    with RobotRecording(tmp_path / 'bag', is_simulated=False) as recording:
        recording.take(JOINT_STATES, joints(1.0))
    ((_, time, _),) = messages(tmp_path / 'bag')
    assert time > 1.6e9


def test_a_description_that_is_none_is_recorded_all_the_same(tmp_path):
    with RobotRecording(tmp_path / 'bag') as recording:
        recording.take(DESCRIPTION, serialize_message(String(data='no URDF')))
        recording.take(JOINT_STATES, joints(0.0))
    names = [topic for topic, _, _ in messages(tmp_path / 'bag')]
    assert names == ['/robot_description', '/joint_states']


@pytest.mark.parametrize('most_kept', [1, 5000, 2**26])
def test_what_is_kept_for_the_end_makes_the_same_recording(tmp_path, most_kept):
    # Each is serialized once: what CDR leaves out between its numbers may be any bytes.
    taken = [(DESCRIPTION, DESCRIBED)]
    for k in range(40):
        taken.append((CLOCK, clock(3.0 + 0.02 * k)))
        taken.append((JOINT_STATES, joints(3.0 + 0.02 * k)))
        taken.append((ODOMETRY, odometry(3.0 + 0.02 * k, x=0.1 * k)))

    def record(name, most):
        with RobotRecording(tmp_path / name, most_kept=most) as recording:
            for topic, data in taken:
                recording.take(topic, data)
        with Reader(tmp_path / name) as reader:
            return [(c.topic, time, bytes(data)) for c, time, data in reader.messages()]

    assert record('later', most_kept) == record('at_once', 0)


def test_no_more_is_kept_in_memory_than_was_said(tmp_path):
    with RobotRecording(tmp_path / 'bag', is_simulated=False, most_kept=3 * 10**4) as recording:
        for k in range(100):
            recording.take(JOINT_STATES, joints(0.02 * k))
        written = recording.counts['/joint_states']
        assert 0 <= 3 * 10**4 - (100 - written) * len(joints(0.0)) < len(joints(0.0))
    assert recording.counts['/joint_states'] == 100


@pytest.mark.parametrize('topic', [CLOCK, ODOMETRY, JOINT_STATES, DESCRIPTION])
@pytest.mark.parametrize('data', [b'', b'\x00\x01\x00\x00', bytes(11), b'\xff' * 40])
def test_bytes_that_are_no_message_end_nothing(tmp_path, topic, data):
    with RobotRecording(tmp_path / 'bag', is_simulated=False, others=NO_ODOMETRY) as recording:
        recording.take(DESCRIPTION, DESCRIBED)
        recording.take(topic, data)
        recording.take(JOINT_STATES, joints(5.0))
    with Reader(tmp_path / 'bag') as reader:
        assert sum(connection.msgcount for connection in reader.connections) >= 4


@pytest.mark.parametrize('number', [math.nan, math.inf])
def test_no_transform_is_made_of_numbers_that_are_none(tmp_path, number):
    with RobotRecording(tmp_path / 'bag') as recording:
        recording.take(CLOCK, clock(1.0))
        recording.take(DESCRIPTION, DESCRIBED)
        recording.take(JOINT_STATES, joints(1.0, np.full((4, 3), number)))
        recording.take(ODOMETRY, odometry(1.0, x=number))
    assert not any(topic == '/tf' for topic, _, _ in messages(tmp_path / 'bag'))


def moved(parent, child, time=3.0):
    stamp = time_from_seconds(time)
    pattern = TransformPattern([(parent, child)])
    return pattern.fill((stamp.sec, stamp.nanosec), [(0.0, 0.0, 0.0)], [(0.0, 0.0, 0.0, 1.0)])


def edges(folder):
    return {(part.header.frame_id, part.child_frame_id) for part in transforms(folder)}


def ways(folder):
    """Return, for each frame, where its parents lead to."""
    parents = {child: parent for parent, child in edges(folder)}
    ends = {}
    for frame in parents:
        end = frame
        while end in parents:
            end = parents[end]
        ends[frame] = end
    return ends


def take_fleet(recording, times, shared=()):
    recording.take(DESCRIPTION, DESCRIBED)
    recording.take(SHARED_FIXED_TRANSFORMS, moved('map', 'robot2/odom'))
    for time in times:
        recording.take(CLOCK, clock(time))
        recording.take(JOINT_STATES, joints(time))
        recording.take(ODOMETRY, odometry(time, prefix='robot1/'))
        for data in shared:
            recording.take(SHARED_TRANSFORMS, data)


def test_links_are_called_as_odometry_calls_the_body(tmp_path):
    with RobotRecording(tmp_path / 'bag', 'robot1', others=Others(has_body=False)) as recording:
        take_fleet(recording, (3.0, 3.04))
    ends = ways(tmp_path / 'bag')
    assert set(ends.values()) == {'map'}
    assert all(frame.startswith('robot1/') for frame in ends)
    assert len(ends) == 2 + 16
    # Other robots are beside it there, and RViz looks there.
    assert {name for name, _, _ in messages(tmp_path / 'bag') if 'tf' in name} == {
        '/tf', '/tf_static'
    }  # fmt: skip


def test_of_the_transforms_of_a_fleet_those_of_one_robot_are_recorded(tmp_path):
    shared = moved('robot1/odom', 'robot1/base_link'), moved('robot2/odom', 'robot2/base_link')
    with RobotRecording(tmp_path / 'bag', 'robot1', others=Others(has_body=True)) as recording:
        recording.take(SHARED_FIXED_TRANSFORMS, moved('map', 'robot1/odom'))
        take_fleet(recording, np.arange(3.0, 6.0, 0.04), shared)
    ends = ways(tmp_path / 'bag')
    assert set(ends.values()) == {'map'}
    assert not any('robot2' in frame for frame in ends)
    counts = recording.counts
    # Nothing of the body is added to what was published of it.
    assert counts['/tf'] == 2 * counts['/robot1/odom'] - 1


def test_a_message_with_transforms_of_many_robots_is_taken_apart(tmp_path):
    pattern = TransformPattern([('map', 'robot2/odom'), ('map', 'robot1/odom')])
    both = pattern.fill((3, 0), [(1.0, 0.0, 0.0), (2.0, 0.0, 0.0)], [(0.0, 0.0, 0.0, 1.0)] * 2)
    with RobotRecording(tmp_path / 'bag', 'robot1', others=Others(has_body=True)) as recording:
        recording.take(SHARED_FIXED_TRANSFORMS, both)
        take_fleet(recording, (3.0,), [moved('robot1/odom', 'robot1/base_link')])
    found = {
        part.child_frame_id: part.transform.translation.x for part in transforms(tmp_path / 'bag')
    }
    assert found['robot1/odom'] == 2.0
    assert 'robot2/odom' not in found


def test_a_body_that_others_do_not_publish_is_placed_though_they_publish_other_robots(tmp_path):
    others = [moved('robot2/odom', 'robot2/base_link')]
    with RobotRecording(tmp_path / 'bag', 'robot1', others=Others(has_body=True)) as recording:
        take_fleet(recording, np.arange(3.0, 6.0, 0.04), others)
    assert set(ways(tmp_path / 'bag').values()) == {'map'}
    assert ('robot1/odom', 'robot1/base_link') in edges(tmp_path / 'bag')


def test_a_robot_without_a_prefix_takes_nothing_of_what_many_share(tmp_path):
    with RobotRecording(tmp_path / 'bag', 'robot1', others=Others(has_body=False)) as recording:
        recording.take(DESCRIPTION, DESCRIBED)
        recording.take(CLOCK, clock(3.0))
        recording.take(ODOMETRY, odometry(3.0))
        recording.take(JOINT_STATES, joints(3.0))
        recording.take(SHARED_TRANSFORMS, moved('odom', 'base_link'))
    names = {name for name, _, _ in messages(tmp_path / 'bag') if 'tf' in name}
    assert names == {'/robot1/tf', '/robot1/tf_static'}
    assert set(ways(tmp_path / 'bag').values()) == {'map'}


@pytest.mark.parametrize('topic', [SHARED_TRANSFORMS, SHARED_FIXED_TRANSFORMS])
def test_shared_transforms_that_are_none_end_nothing(tmp_path, topic):
    with RobotRecording(tmp_path / 'bag', 'robot1') as recording:
        recording.take(topic, b'robot1/')
        take_fleet(recording, (3.0,))
        recording.take(topic, b'robot1/')
        recording.take(topic, b'')
    assert recording.counts['/robot1/odom'] == 1
