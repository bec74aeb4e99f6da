"""
A recording in the place of a robot: what is shown at a time is what was known then.
"""

from __future__ import annotations

from bisect import bisect_right

import pytest

pytest.importorskip('rosbags')
pytest.importorskip('nav_msgs')
pytest.importorskip('viser')

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from geometry_msgs.msg import PoseStamped
from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Float64

from quad_cli.main import main
from quad_common.planar_pose import Pose2D
from quad_common.ros.pose_conversions import pose_message, time_from_seconds
from quad_lab.recordings import recorded_messages
from quad_lab.recordings.recorded_messages import RecordedMessages
from quad_lab.recordings.recorded_topics import CLOCK, GOAL, ODOMETRY, RECORDED
from quad_lab.recordings.recording import Recording
from quad_lab.recordings.replay import Replay
from quad_lab.recordings.robot_recording import RobotRecording
from quad_view.scene.page_options import PageOptions

DIAGNOSTICS = next(topic for topic in RECORDED if topic.name == 'diagnostics')
MARGIN = next(topic for topic in RECORDED if topic.name == 'stability_margin')


def odometry(time, x):
    message = Odometry(child_frame_id='base_link')
    message.header.frame_id, message.header.stamp = 'odom', time_from_seconds(time)
    message.pose.pose = pose_message(Pose2D(x, 0.0, 0.0))
    return serialize_message(message)


def words(sentence):
    status = DiagnosticStatus(level=DiagnosticStatus.OK, name='robot1/gait_node', message=sentence)
    return serialize_message(DiagnosticArray(status=[status]))


@pytest.fixture
def folder(tmp_path):
    """Ten seconds from 100 s on: the robot goes forward, and gets its goal after three."""
    with RobotRecording(tmp_path / 'bag', 'robot1') as recording:
        for k in range(501):
            time = 100.0 + 0.02 * k
            recording.take(CLOCK, serialize_message(Clock(clock=time_from_seconds(time))))
            recording.take(ODOMETRY, odometry(time, 0.1 * (time - 100.0)))
            recording.take(MARGIN, serialize_message(Float64(data=float(k))))
            if k == 150:
                goal = PoseStamped(pose=pose_message(Pose2D(2.0, 0.0, 0.0)))
                goal.header.frame_id = 'map'
                recording.take(GOAL, serialize_message(goal))
            if k % 50 == 0:
                recording.take(DIAGNOSTICS, words(f'second {k // 50}'))
    return tmp_path / 'bag'


@pytest.fixture
def replay(folder):
    made = Replay(folder, PageOptions(port=0), 'robot1')
    made.timeline.is_playing = False
    yield made
    made.page.close()


def show(replay, elapsed):
    replay.timeline.seek(elapsed)
    assert replay.show(0.0) == []


@pytest.mark.parametrize('elapsed', [0.5, 4.1, 9.9])
def test_the_robot_is_where_it_was(replay, elapsed):
    show(replay, elapsed)
    assert replay.view.pose.x == pytest.approx(0.1 * elapsed, abs=0.003)
    assert replay.view.margin == pytest.approx(50.0 * elapsed, abs=1.0)
    assert replay.view.said['gait_node'].message == f'second {int(elapsed)}'
    assert (replay.view.goal is not None) == (elapsed > 3.0)


def test_going_back_forgets_what_came_later(replay):
    show(replay, 9.0)
    assert len(replay.view.track) > 20
    show(replay, 2.1)
    assert replay.view.goal is None
    assert replay.view.pose.x == pytest.approx(0.21, abs=0.003)
    assert replay.view.track[:, 0].max() < 0.22
    assert replay.view.said['gait_node'].message == 'second 2'


def test_a_leap_leaves_no_hole_in_the_track(replay):
    show(replay, 10.0)
    gaps = replay.view.track[1:, 0] - replay.view.track[:-1, 0]
    assert gaps.max() < 0.05


def test_it_plays_at_its_speed(replay):
    replay.timeline.is_playing, replay.timeline.speed = True, 4.0
    replay.show(1.0)
    assert replay.view.pose.x == pytest.approx(0.4, abs=0.003)
    for _ in range(10):
        replay.show(1.0)
    assert not replay.timeline.is_playing
    assert replay.view.pose.x == pytest.approx(1.0, abs=0.003)


def test_all_of_a_topic_or_the_newest(folder):
    messages = RecordedMessages(folder, 'robot1')
    every, newest = [], []
    messages.all_of('stability_margin', lambda message: every.append(message.data), Float64)
    messages.newest_of('stability_margin', lambda message: newest.append(message.data), Float64)
    messages.go_on_to(messages.start + 1.0)
    assert every == [float(k) for k in range(len(every))]
    assert len(every) == pytest.approx(50, abs=1)
    assert newest[-1] == every[-1]
    assert len(newest) == 5


def test_years_between_two_messages_take_no_time(tmp_path, monkeypatch):
    with Recording(tmp_path / 'bag') as recording:
        for time in (0.5, 1.7e9, 1.7e9 + 0.1, 1.7e9 + 0.5):
            recording.write(MARGIN, serialize_message(Float64(data=time)), time)
    looks = iter(range(10))

    def look(times, time):
        next(looks)
        return bisect_right(times, time)

    monkeypatch.setattr(recorded_messages, 'bisect_right', look)
    messages = RecordedMessages(tmp_path / 'bag')
    every, newest = [], []
    messages.all_of('stability_margin', lambda message: every.append(message.data), Float64)
    messages.newest_of('stability_margin', lambda message: newest.append(message.data), Float64)
    messages.go_on_to(messages.start + 3600.0)
    assert messages.time == messages.start + 3600.0
    assert every == newest == [0.5]
    assert messages.go_on_to(messages.end) == []
    assert every == newest == [0.5, 1.7e9, 1.7e9 + 0.1, 1.7e9 + 0.5]


@pytest.mark.parametrize(
    'arguments', [['nowhere'], ['bag', '--namespace', 'robot2'], ['bag', '--port', '99999999']]
)
def test_the_command_says_what_it_cannot_show(folder, arguments, capsys, monkeypatch):
    monkeypatch.chdir(folder.parent)
    assert main(['replay', *arguments]) == 2
    assert capsys.readouterr().err.startswith('error: ')
