"""
A film shows a recorded robot where it was.
"""

from __future__ import annotations

import math
import sys

import cv2
import numpy as np
import pytest

pytest.importorskip('rosbags')
pytest.importorskip('nav_msgs')

from nav_msgs.msg import Odometry
from PIL import Image
from rclpy.serialization import serialize_message
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import JointState

from quad_cli.main import main
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import pose_message, time_from_seconds
from quad_lab.recordings.recorded_topics import CLOCK, JOINT_STATES, ODOMETRY
from quad_lab.recordings.recording import Recording
from quad_lab.recordings.robot_recording import RobotRecording
from quad_sim.engines.registry import ENGINES, engines_with, make_simulator

DRAWING = [name for name in engines_with('has_pictures') if ENGINES[name].is_installed]

pytestmark = pytest.mark.skipif(not DRAWING, reason='no engine that draws is installed')

ROBOT = load_robot('genibo')


@pytest.fixture
def folder(tmp_path):
    """Record two seconds: the robot stands, and faces the other way after the first."""
    with RobotRecording(tmp_path / 'bag') as recording:
        for k in range(21):
            stamp = time_from_seconds(50.0 + 0.1 * k)
            recording.take(CLOCK, serialize_message(Clock(clock=stamp)))
            message = Odometry(child_frame_id='base_link')
            message.header.frame_id, message.header.stamp = 'odom', stamp
            message.pose.pose = pose_message(Pose2D(1.0, 2.0, math.pi / 2 if k > 10 else 0.3))
            message.pose.pose.position.z = ROBOT.standing_height
            recording.take(ODOMETRY, serialize_message(message))
            joints = JointState(name=list(ROBOT.joint_names))
            joints.position = ROBOT.initial_joint_angles.reshape(-1).tolist()
            recording.take(JOINT_STATES, serialize_message(joints))
        recording.note({'robot': 'genibo'})
    return tmp_path / 'bag'


def pictures_of(path):
    if path.suffix == '.gif':
        with Image.open(path) as film:
            frames = []
            for k in range(film.n_frames):
                film.seek(k)
                frames.append(np.asarray(film.convert('RGB'), dtype=float))
            return frames
    video, frames = cv2.VideoCapture(str(path)), []
    while (read := video.read())[0]:
        frames.append(read[1].astype(float))
    video.release()
    return frames


@pytest.mark.parametrize('name', ['walk.gif', 'walk.mp4'])
def test_a_film_shows_what_happened(folder, name):
    if name == 'walk.mp4':
        pytest.importorskip('imageio_ffmpeg')
    path = folder.parent / name
    assert main(['replay', str(folder), '--film', str(path), '--width', '160']) == 0
    frames = pictures_of(path)
    # Two seconds at 25 pictures in a second; GIF leaves out pictures that are like the last.
    assert len(frames) in ((50, 51) if name == 'walk.mp4' else range(2, 52))
    assert frames[0].shape == (90, 160, 3)
    still = np.abs(frames[0] - frames[1]).mean()
    turned = np.abs(frames[0] - frames[-1]).mean()
    assert turned > 1.0
    if name == 'walk.mp4':
        assert turned > 5.0 * still


@pytest.mark.parametrize('backend', DRAWING)
def test_the_robot_is_put_where_it_was(backend):
    simulator = make_simulator(backend, ROBOT, None)
    angles = ROBOT.initial_joint_angles.reshape(-1) + 0.05
    turn = np.array([0.0, 0.0, math.sin(0.4), math.cos(0.4)])
    simulator.place(np.array([1.0, -2.0, 0.3]), turn, angles)
    seen = simulator.observe()
    assert seen.position == pytest.approx([1.0, -2.0, 0.3], abs=1e-9)
    assert seen.orientation == pytest.approx(turn, abs=1e-9)
    assert seen.joint_positions == pytest.approx(angles, abs=1e-9)
    simulator.close()


def test_part_of_it_faster(folder):
    path = folder.parent / 'walk.gif'
    part = ['--first', '0.9', '--last', '1.3', '--speed', '0.1', '--width', '64']
    assert main(['replay', str(folder), '--film', str(path), *part]) == 0
    frames = pictures_of(path)
    assert np.abs(frames[0] - frames[-1]).mean() > 1.0


@pytest.mark.parametrize(
    ('arguments', 'problem'),
    [
        (['--film', 'walk.avi'], 'must end in .mp4 or .gif'),
        (['--film', 'walk.gif', '--width', '1'], 'from 64 to 4096'),
        (['--film', 'walk.gif', '--robot', 'nobody'], 'no robot'),
        (['--film', 'walk.gif', '--speed', '0'], 'speed'),
        (['--film', 'walk.gif', '--first', '3', '--last', '1'], 'at most --last'),
    ],
)
def test_what_cannot_be_filmed_is_said(folder, arguments, problem, capfd, monkeypatch):
    monkeypatch.chdir(folder.parent)
    try:
        code = main(['replay', 'bag', *arguments])
    except SystemExit as end:
        code = end.code
    assert code == 2
    assert problem in capfd.readouterr().err


@pytest.mark.parametrize(('name', 'most'), [('walk.gif', 9320), ('walk.mp4', 100000)])
def test_a_film_of_years_is_refused(tmp_path, name, most, capfd):
    with Recording(tmp_path / 'bag') as recording:
        for time in (0.5, 1.7e9):
            recording.write(ODOMETRY, serialize_message(Odometry()), time)
    film = ['--film', str(tmp_path / name), '--robot', 'genibo']
    assert main(['replay', str(tmp_path / 'bag'), *film]) == 2
    said = capfd.readouterr().err
    assert said.startswith('error: the film would show 1e+06 s of the recording in ')
    assert f'pictures; {most} are the most: choose a part by --first and --last' in said
    assert not (tmp_path / name).exists()


def test_without_an_encoder_it_is_said(folder, capfd, monkeypatch):
    monkeypatch.setitem(sys.modules, 'imageio_ffmpeg', None)
    path = folder.parent / 'walk.mp4'
    assert main(['replay', str(folder), '--film', str(path), '--width', '64']) == 2
    assert "pip install 'quadwalk[film]'" in capfd.readouterr().err
