"""
A recording of a walk alone has the figures that the walk had.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
import struct
import subprocess
import sys

import pytest
import yaml

pytest.importorskip('rosbags')
pytest.importorskip('nav_msgs')

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader
from std_msgs.msg import String

from quad_cli.main import main
from quad_common.errors import QuadError
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.ros.pose_conversions import pose_message, time_from_seconds
from quad_lab.recordings.recorded_topics import GOAL, ODOMETRY, RECORDED
from quad_lab.recordings.recording import Recording
from quad_lab.recordings.recording_reader import RecordingUnusable, open_recording
from quad_lab.recordings.robot_recording import RobotRecording
from quad_lab.topic_walk.recorded_walk import read_walks
from quad_lab.topic_walk.walk import WalkOptions, walk

DIAGNOSTICS = next(topic for topic in RECORDED if topic.name == 'diagnostics')


@pytest.fixture(scope='module')
def recorded(tmp_path_factory):
    """Walk a short way over topics, and record it."""
    folder = tmp_path_factory.mktemp('walk') / 'recording'
    start, goal = Pose2D(1.2, 1.2, 0.0), Pose2D(1.4, 1.4, 0.5)
    record = walk(WalkOptions(sample_map('room'), start, goal, composed=True, recording=folder))
    return record.result(), folder


def test_figures_are_those_of_the_walk_itself(recorded):
    result, folder = recorded
    assert result.arrived
    (walked,) = read_walks(folder).walks
    assert walked.result() == result


def test_nothing_was_lost(recorded):
    _, folder = recorded
    with Reader(folder) as reader:
        counts = {connection.topic: connection.msgcount for connection in reader.connections}
        times = [time for connection, time, _ in reader.messages() if connection.topic == '/odom']
    assert counts['/odom'] == counts['/joint_states'] == counts['/imu'] == len(times)
    # Received one by one at 50 Hz of simulated time.
    assert max(b - a for a, b in itertools.pairwise(times)) < 0.03e9
    for topic in ('/map', '/robot_description', '/goal_pose', '/plan', '/tf', '/tf_static'):
        assert counts[topic] >= 1


def test_the_command_prints_them(recorded, capsys):
    result, folder = recorded
    assert main(['evaluate', str(folder), '--json']) == 0
    (summary,) = json.loads(capsys.readouterr().out)['walks']
    assert summary == {'map': 'room', **result.as_dict()}
    assert main(['evaluate', str(folder)]) == 0
    assert 'final position error' in capsys.readouterr().out


def take_odometry(recording, time, x):
    message = Odometry(child_frame_id='base_link')
    message.header.frame_id, message.header.stamp = 'odom', time_from_seconds(time)
    message.pose.pose = pose_message(Pose2D(x, 0.0, 0.0))
    recording.take(ODOMETRY, serialize_message(message))


def test_each_goal_is_a_walk_of_its_own(tmp_path):
    with RobotRecording(tmp_path / 'bag', 'robot1', is_simulated=False) as recording:
        for k, goal in enumerate((1.0, 2.0)):
            message = PoseStamped(pose=pose_message(Pose2D(goal, 0.0, 0.0)))
            recording.take(GOAL, serialize_message(message))
            for j in range(3):
                take_odometry(recording, 10.0 * k + j, goal - 0.2 + 0.1 * j)
    first, second = (record.result() for record in read_walks(tmp_path / 'bag', 'robot1').walks)
    assert first.position_error == pytest.approx(0.0)
    assert second.walking_time == pytest.approx(2.0)
    assert second.walked_distance == pytest.approx(0.2)
    with pytest.raises(QuadError, match='holds nothing of a robot without a namespace'):
        read_walks(tmp_path / 'bag')


def test_messages_that_are_none_are_said(tmp_path):
    with RobotRecording(tmp_path / 'bag', is_simulated=False) as recording:
        recording.take(GOAL, b'\x00\x01\x00')
        recording.take(ODOMETRY, b'')
    with pytest.raises(QuadError, match='its bytes are no PoseStamped'):
        read_walks(tmp_path / 'bag')


def test_topics_of_another_type_are_left_out(tmp_path):
    other = dataclasses.replace(ODOMETRY, kind='std_msgs/msg/String')
    with RobotRecording(tmp_path / 'bag', is_simulated=False) as recording:
        recording.take(GOAL, serialize_message(PoseStamped(pose=pose_message(Pose2D(0, 0, 0)))))
        recording.take(other, serialize_message(String(data='no odometry')))
    (walked,) = read_walks(tmp_path / 'bag').walks
    assert walked.poses == []


def test_without_the_package_that_writes_them_walks_are_walked(tmp_path):
    code = (
        "import sys; sys.modules['rosbags'] = None\n"
        'from quad_lab.topic_walk.walk import walk\n'
        'from quad_lab.topic_walk.walk_observer import WalkObserver\n'
        'from quad_cli.output import progress\n'
        'from quad_lab.recordings.recording import can_record\n'
        'assert not can_record()'
    )
    done = subprocess.run([sys.executable, '-c', code], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def without_metadata(folder):
    (folder / 'metadata.yaml').unlink()


def without_messages(folder):
    next(folder.glob('*.mcap')).unlink()


def cut_off(folder):
    path = next(folder.glob('*.mcap'))
    path.write_bytes(path.read_bytes()[:-200])


def overwritten(folder):
    path = next(folder.glob('*.mcap'))
    path.write_bytes(b'words' * 100)


def other_metadata(folder):
    (folder / 'metadata.yaml').write_text('[1, 2]')


def metadata_of_another_kind(folder):
    (folder / 'metadata.yaml').write_text('rosbag2_bagfile_information: 3')


def deep_metadata(folder):
    (folder / 'metadata.yaml').write_text('[' * 1000)


def endless_record(folder):
    """Let the first record of the summary be longer than an index can be."""
    path = next(folder.glob('*.mcap'))
    data = bytearray(path.read_bytes())
    # The footer: its kind, its length, where the summary begins.
    (summary,) = struct.unpack_from('<Q', data, len(data) - 8 - 20)
    data[summary + 1 : summary + 9] = b'\xff' * 8
    path.write_bytes(bytes(data))


@pytest.mark.parametrize(
    'damage',
    [
        without_metadata,
        without_messages,
        cut_off,
        overwritten,
        other_metadata,
        metadata_of_another_kind,
        deep_metadata,
        endless_record,
        lambda folder: None,
    ],
)
def test_what_is_no_recording_of_a_walk_is_said(tmp_path, damage):
    folder = tmp_path / 'bag'
    with RobotRecording(folder, is_simulated=False) as recording:
        take_odometry(recording, 1.0, 0.0)
    damage(folder)
    with pytest.raises(QuadError) as caught:
        read_walks(folder)
    assert '\n' not in str(caught.value)


def test_what_is_done_with_messages_is_not_said_of_the_recording(tmp_path):
    with RobotRecording(tmp_path / 'bag', is_simulated=False) as recording:
        take_odometry(recording, 1.0, 0.0)

    def read():
        with open_recording(tmp_path / 'bag') as messages:
            raise LookupError(f'{len(list(messages))} messages')

    with pytest.raises(LookupError, match='messages'):
        read()


def test_too_little_memory_is_said_of_the_recording(tmp_path, monkeypatch):
    with RobotRecording(tmp_path / 'bag', is_simulated=False) as recording:
        take_odometry(recording, 1.0, 0.0)

    def messages(reader, connections):
        raise MemoryError

    monkeypatch.setattr(Reader, 'messages', messages)
    with pytest.raises(RecordingUnusable, match='damaged, or more than the memory holds'):
        read_walks(tmp_path / 'bag')


def test_a_bag_of_hundreds_of_topics_is_read(tmp_path):
    with RobotRecording(tmp_path / 'bag', is_simulated=False) as recording:
        recording.take(GOAL, serialize_message(PoseStamped(pose=pose_message(Pose2D(0, 0, 0)))))
    path = tmp_path / 'bag' / 'metadata.yaml'
    document = yaml.safe_load(path.read_text())
    topics = document['rosbag2_bagfile_information']['topics_with_message_count']
    topics += [json.loads(json.dumps(topics[0])) for _ in range(500)]
    for number, topic in enumerate(topics[-500:]):
        topic['message_count'] = 0
        topic['topic_metadata']['name'] = f'/other/{number}'
    path.write_text(yaml.safe_dump(document))
    (walked,) = read_walks(tmp_path / 'bag').walks
    assert walked.poses == []


@pytest.fixture
def with_bad_messages(tmp_path):
    """A walk of which some odometry, a goal and diagnostics cannot be used."""
    with Recording(tmp_path / 'bag') as recording:
        goal = PoseStamped(pose=pose_message(Pose2D(1.0, 0.0, 0.0)))
        recording.write(GOAL, serialize_message(goal), 10.0)
        for k in range(11):
            message = Odometry(child_frame_id='base_link')
            message.header.stamp = time_from_seconds(11.0 + k)
            message.pose.pose = pose_message(Pose2D(0.1 * k, 0.0, 0.0))
            if k in (2, 5):
                message.pose.pose.position.x = math.nan
            recording.write(ODOMETRY, serialize_message(message), 11.0 + k)
        goal.pose.position.x = math.inf
        recording.write(GOAL, serialize_message(goal), 22.0)
        status = DiagnosticStatus(name='sim_node')
        status.values = [KeyValue(key='late_trajectories', value='many')]
        recording.write(DIAGNOSTICS, serialize_message(DiagnosticArray(status=[status])), 23.0)
    return tmp_path / 'bag'


def test_messages_that_cannot_be_used_are_left_out_and_told(with_bad_messages):
    read = read_walks(with_bad_messages)
    (walked,) = read.walks
    assert walked.result().position_error == pytest.approx(0.0)
    assert len(walked.poses) == 9
    told = {left.topic: (left.count, left.first) for left in read.left_out}
    assert told == {
        'odom': (2, pytest.approx(3.0)),
        'goal_pose': (1, pytest.approx(12.0)),
        'diagnostics': (1, pytest.approx(13.0)),
    }
    sentences = {left.topic: str(left) for left in read.left_out}
    assert sentences['odom'].startswith('2 messages of odom left out, the first at 3.000 s: ')
    assert 'position is (nan' in sentences['odom']


def test_the_command_tells_what_is_left_out(with_bad_messages, capsys):
    assert main(['evaluate', str(with_bad_messages), '--json']) == 1
    counts = json.loads(capsys.readouterr().out)['messages_left_out']
    assert counts == {'odom': 2, 'goal_pose': 1, 'diagnostics': 1}
    assert main(['evaluate', str(with_bad_messages)]) == 1
    assert '2 messages of odom left out' in capsys.readouterr().out
