"""A recording is whole or not there; nothing else is removed for it."""

from __future__ import annotations

import pytest

pytest.importorskip('rosbags')
pytest.importorskip('std_msgs')

from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader
from std_msgs.msg import String

from quad_lab.recordings.recorded_topics import RECORDED, Delivery, RecordedTopic
from quad_lab.recordings.recording import NoPlaceForRecording, Recording

CHATTER = RecordedTopic('chatter', 'std_msgs/msg/String', Delivery.RELIABLE)
WORDS = serialize_message(String(data='words'))


def record(folder, count: int = 1) -> None:
    with Recording(folder) as recording:
        for _ in range(count):
            recording.write(CHATTER, WORDS, 1.5)


def test_a_recording_is_complete_whatever_ends_its_block(tmp_path):
    def interrupted() -> None:
        with Recording(tmp_path / 'bag') as recording:
            recording.write(CHATTER, WORDS, 1.5)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    with Reader(tmp_path / 'bag') as reader:
        assert reader.message_count == 1
        assert reader.duration >= 0


def test_nothing_is_left_of_a_recording_without_messages(tmp_path):
    record(tmp_path / 'bag', count=0)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize('gone', ['metadata.yaml', 'bag.mcap', None])
def test_a_recording_replaces_one_that_is_there_whole_or_not(tmp_path, gone):
    folder = tmp_path / 'bag'
    record(folder, count=3)
    if gone is not None:
        (folder / gone).unlink()
    record(folder)
    with Reader(folder) as reader:
        assert reader.message_count == 1


def test_an_empty_folder_will_do(tmp_path):
    (tmp_path / 'bag').mkdir()
    record(tmp_path / 'bag')
    assert (tmp_path / 'bag' / 'metadata.yaml').is_file()


@pytest.mark.parametrize('other', ['notes.txt', 'more/notes.txt'])
def test_what_is_no_part_of_a_recording_is_not_removed(tmp_path, other):
    folder = tmp_path / 'bag'
    record(folder)
    (folder / other).parent.mkdir(exist_ok=True)
    (folder / other).write_text('words')
    with pytest.raises(NoPlaceForRecording, match='is no part of a recording'):
        record(folder)
    assert (folder / other).read_text() == 'words'
    with Reader(folder) as reader:
        assert reader.message_count == 1
    with pytest.raises(NoPlaceForRecording):
        record(folder / other)


@pytest.mark.parametrize('topic', RECORDED, ids=lambda topic: topic.name)
def test_a_topic_is_kept_as_it_is_published(tmp_path, topic):
    with Recording(tmp_path / 'bag', 'robot1') as recording:
        recording.write(topic, WORDS, 2.25)
    with Reader(tmp_path / 'bag') as reader:
        (connection,) = reader.connections
        assert connection.topic == ('/clock' if topic.name == '/clock' else f'/robot1/{topic.name}')
        assert connection.msgtype == topic.kind
        (quality,) = connection.ext.offered_qos_profiles
        assert quality.depth == topic.depth
        assert (quality.durability.name == 'TRANSIENT_LOCAL') == (
            topic.delivery is Delivery.LATCHED
        )
        assert (quality.reliability.name == 'BEST_EFFORT') == (topic.delivery is Delivery.SENSOR)
        assert reader.start_time == 2_250_000_000
