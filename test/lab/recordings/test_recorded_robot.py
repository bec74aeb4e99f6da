"""
A recording tells which robot it is of: by a name that was noted, or by its description.
"""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip('rosbags')
pytest.importorskip('std_msgs')

from nav_msgs.msg import Odometry
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from std_msgs.msg import String

from quad_common.errors import DescriptionError, ParameterError
from quad_common.robot.urdf import published_urdf
from quad_common.robot_files.robot_file import load_robot
from quad_lab.recordings.recorded_messages import RecordedMessages
from quad_lab.recordings.recorded_robot import recorded_robot
from quad_lab.recordings.recorded_topics import CLOCK, DESCRIPTION, ODOMETRY
from quad_lab.recordings.robot_recording import RobotRecording

CUHK = load_robot('cuhk')


@pytest.fixture(autouse=True)
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'cache'))


def robot_of(tmp_path, description, **facts):
    folder = tmp_path / 'bag'
    with RobotRecording(folder) as recording:
        recording.take(CLOCK, serialize_message(Clock()))
        recording.take(ODOMETRY, serialize_message(Odometry()))
        if description is not None:
            recording.take(DESCRIPTION, serialize_message(String(data=description)))
        if facts:
            recording.note(facts)
    return recorded_robot(folder, RecordedMessages(folder))


def test_a_name_that_was_noted_comes_first(tmp_path):
    assert robot_of(tmp_path, published_urdf(CUHK), robot='genibo').name == 'genibo'


def test_a_robot_that_ships_is_known_by_its_description(tmp_path):
    robot = robot_of(tmp_path, published_urdf(CUHK))
    assert robot.name == 'cuhk'
    assert not robot.own_urdf


def test_another_description_is_imported(tmp_path):
    text = published_urdf(CUHK).replace('name="cuhk"', 'name="my_robot"')
    robot = robot_of(tmp_path, text)
    assert robot.own_urdf
    assert robot.hip_height == pytest.approx(CUHK.hip_height, rel=0.1)
    # It is kept, as for whoever asks for the same description again.
    assert np.array_equal(robot_of(tmp_path, text).initial_joint_angles, robot.initial_joint_angles)


@pytest.mark.parametrize('text', ['', 'no XML', '<robot name="cuhk"/>'])
def test_a_description_of_no_robot_is_refused(tmp_path, text):
    with pytest.raises(DescriptionError):
        robot_of(tmp_path, text)


def test_without_either_the_robot_is_asked_for(tmp_path):
    with pytest.raises(ParameterError, match='neither names nor describes its robot'):
        robot_of(tmp_path, None)
