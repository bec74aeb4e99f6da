"""A recording is whole or not there; nothing else is removed for it."""

from __future__ import annotations

import errno

import pytest

pytest.importorskip('rosbags')
pytest.importorskip('std_msgs')

from rclpy.serialization import serialize_message
from rosbags.rosbag2 import Reader
from std_msgs.msg import String

from quad_common.errors import FileUnusable
from quad_lab.recordings.recorded_topics import RECORDED, Delivery, RecordedTopic
from quad_lab.recordings.recording import NoPlaceForRecording, Recording, RecordingNotWritten
from quad_lab.recordings.recording_reader import RecordingUnusable

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


LONG = serialize_message(String(data='w' * 30_000))


def fill(folder) -> int:
    """Record until nothing more can be written; return how much was."""
    with Recording(folder) as recording:
        try:
            for count in range(500):
                recording.write(CHATTER, LONG, 1.5 + count)
        finally:
            # What comes afterwards is left out, and is no error of its own.
            recording.write(CHATTER, LONG, 1000.0)
            recording.note({'robot': 'any'})
            written = recording.counts['/chatter']
    return written


def test_a_recording_whose_disk_is_full_can_be_read_up_to_there(tmp_path, most_bytes):
    folder = tmp_path / 'bag'
    with most_bytes(2_500_000), pytest.raises(RecordingNotWritten, match='can be read up to there'):
        fill(folder)
    assert sorted(file.name for file in folder.iterdir()) == ['bag.mcap', 'metadata.yaml']
    with Reader(folder) as reader:
        assert len(list(reader.messages())) > 30


def test_messages_that_wait_are_written_into_the_room_that_was_held(tmp_path, monkeypatch):
    folder = tmp_path / 'bag'

    class FullDisk:
        """A file on a disk that is full while room is held on it."""

        def __init__(self, file) -> None:
            self.file = file

        def write(self, data) -> int:
            if len(data) > 2**19 and (folder / 'reserve').exists():
                self.file.write(bytes(data)[:1000])
                raise OSError(errno.ENOSPC, 'No space left on device')
            return self.file.write(data)

        def __getattr__(self, name):
            return getattr(self.file, name)

    def record_on_full_disk() -> None:
        with Recording(folder) as recording:
            storage = recording._writer.storage
            storage.bio = FullDisk(storage.bio)
            for count in range(100):
                recording.write(CHATTER, LONG, 1.5 + count)

    with pytest.raises(RecordingNotWritten, match='No space left on device'):
        record_on_full_disk()
    with Reader(folder) as reader:
        times = [time for _, time, _ in reader.messages()]
    # All of them, with the one at which it was noticed.
    assert len(times) == 2**20 // len(LONG) + 1
    assert times == [round(1e9 * (1.5 + k)) for k in range(len(times))]


def test_nothing_is_begun_without_room(tmp_path, most_bytes):
    with most_bytes(1_000_000), pytest.raises(FileUnusable, match='cannot be written'):
        record(tmp_path / 'bag')
    assert list(tmp_path.iterdir()) == []


def test_what_is_said_of_a_recording_has_one_line_whatever_its_name(tmp_path):
    unusable = RecordingUnusable(tmp_path / 'a\nb', 'is no recording')
    assert str(unusable).endswith('a\\nb: is no recording')
