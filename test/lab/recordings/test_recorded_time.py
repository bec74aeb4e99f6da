"""
The time of a recording goes on with the clock, whatever that does.
"""

from __future__ import annotations

import itertools

import numpy as np
import pytest

pytest.importorskip('rosbags')
pytest.importorskip('nav_msgs')

from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock

from quad_common.errors import ClockDisbelieved, ClockLeapt
from quad_common.ros.pose_conversions import time_from_seconds
from quad_lab.recordings.recorded_messages import RecordedMessages
from quad_lab.recordings.recorded_time import RecordedTime
from quad_lab.recordings.recorded_topics import CLOCK, ODOMETRY
from quad_lab.recordings.robot_recording import RobotRecording

WALK = [0.1 * k for k in range(600)]


def recorded(clocks, is_confirmed=True):
    """Return the time of a message after each clock, and what is said."""
    time = RecordedTime(is_confirmed)
    times = []
    for told in clocks:
        time.follow(told)
        times.append(time.next())
    return np.array(times), time.remarks


@pytest.mark.parametrize('is_confirmed', [True, False])
def test_a_clock_that_goes_back_goes_on_in_the_recording(is_confirmed):
    times, remarks = recorded(WALK + WALK + WALK, is_confirmed)
    assert times[-1] == pytest.approx(3 * 59.9, abs=1e-3)
    # But for the clock that has to be confirmed.
    assert np.sum(np.diff(times) < 0.09) <= 4
    assert [(type(remark), remark.after) for remark in remarks] == [(ClockLeapt, 0.0)] * 2
    assert str(remarks[0]) == ('the clock went back by 59.9 s, from 59.9 s; the recording goes on')


@pytest.mark.parametrize('stray', [0.0, 1.7e9])
def test_a_single_clock_that_fits_no_other_is_left_out(stray):
    times, remarks = recorded([*WALK[300:400], stray, *WALK[400:]])
    assert times[-1] == pytest.approx(59.9, abs=1e-3)
    assert np.diff(times).max() == pytest.approx(0.1, abs=1e-3)
    (remark,) = remarks
    assert isinstance(remark, ClockDisbelieved)
    assert (remark.before, remark.told) == (WALK[399], stray)
    assert 'is not believed' in str(remark)


def test_a_leap_forward_is_believed_with_the_next_clock():
    times, (remark,) = recorded([*WALK, 1000.0, 1000.1])
    assert times[-2] == pytest.approx(59.9, abs=1e-3)
    assert times[-1] == pytest.approx(1000.1)
    assert str(remark).startswith('the clock leapt forward by 940.1 s')


def test_after_a_gap_the_time_is_the_clock_s():
    times, remarks = recorded([1.0, 1.1, 21.1])
    assert times[-1] == 21.1
    assert not remarks


@pytest.mark.parametrize('apart', [7.0, 100.0])
@pytest.mark.parametrize('turn', [1, 2, 5])
def test_two_clocks_that_take_turns_do_not_make_time_of_their_own(apart, turn):
    first, second = iter([apart + t for t in WALK]), iter(WALK)
    clocks = []
    while chunk := list(itertools.islice(first, turn)):
        clocks += chunk + list(itertools.islice(second, turn))
    times, remarks = recorded(clocks)
    assert times[0] == apart
    assert times[-1] - times[0] < 2 * 59.9
    assert len(remarks) <= 10


def test_the_clock_of_a_machine_needs_no_confirmation():
    times, remarks = recorded([1.7e9, 1.7e9 + 3600.0], is_confirmed=False)
    assert times[-1] == 1.7e9 + 3600.0
    assert not remarks


def take(recording, time):
    stamp = time_from_seconds(time)
    recording.take(CLOCK, serialize_message(Clock(clock=stamp)))
    message = Odometry(child_frame_id='base_link')
    message.header.frame_id, message.header.stamp = 'odom', stamp
    recording.take(ODOMETRY, serialize_message(message))


@pytest.mark.parametrize('most_kept', [0, 2**26])
def test_a_recording_has_both_walks_of_a_simulator_that_was_restarted(tmp_path, most_kept):
    with RobotRecording(tmp_path / 'bag', most_kept=most_kept) as recording:
        for time in WALK + WALK:
            take(recording, time)
    messages = RecordedMessages(tmp_path / 'bag')
    assert messages.end - messages.start == pytest.approx(2 * 59.9, abs=0.01)
    assert [str(remark)[:32] for remark in recording.remarks] == [
        'the clock went back by 59.9 s, f'
    ]


def test_a_clock_that_no_stamp_can_be_is_not_followed(tmp_path):
    with RobotRecording(tmp_path / 'bag') as recording:
        take(recording, 5.0)
        recording.take(CLOCK, b'\x00\x01\x00\x00' + b'\xff' * 8)
        recording.take(CLOCK, b'\x00\x01\x00\x00' + b'\xff' * 8)
        take(recording, 5.1)
    messages = RecordedMessages(tmp_path / 'bag')
    assert (messages.start, messages.end) == pytest.approx((5.0, 5.1), abs=1e-3)
