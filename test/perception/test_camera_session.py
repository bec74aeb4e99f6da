"""What the camera's node reports: the first thing that is missing, or wrong."""

import numpy as np
import pytest

from quad_common.errors import PictureUnusable, QuadError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.status import Level
from quad_common.vision.camera import CameraModel
from quad_perception.camera_session import CameraSession
from quad_perception.parameters import CeilingCameraParameters

CAMERA = CameraModel.looking_down((4.0, 4.0, 6.0), 0.0, 1.4, (64, 64))
FLOOR = np.full((64, 64, 3), 180, np.uint8)


@pytest.fixture
def session():
    return CameraSession(CeilingCameraParameters(), load_robot('titan_viii'))


def test_it_waits_for_the_lens_then_for_a_picture_then_for_odometry(session):
    assert session.status(0.0).message.startswith('no camera_info')
    session.take_camera(CAMERA)
    assert session.status(0.0).message.startswith('no picture')
    session.take_picture(1.0, FLOOR)
    assert session.status(1.0).message.startswith('no odometry')
    assert session.status(9.0).message == 'the last picture is 8.0 s old'
    session.take_odometry(1.0, Pose2D(0.0, 0.0, 0.0))
    status = session.status(1.0)
    # An empty floor: the robot is missing.
    assert (status.level, 'robot' in status.message) == (Level.WARN, True)


def test_the_problem_of_an_input_stays_until_one_is_good(session):
    with pytest.raises(PictureUnusable), session.receiving('picture'):
        raise PictureUnusable('is black')
    assert isinstance(session.status(0.0), QuadError)
    with session.receiving('odometry'):
        session.take_odometry(1.0, Pose2D(0.0, 0.0, 0.0))
    assert isinstance(session.status(0.0), PictureUnusable)
    with session.receiving('picture'):
        pass
    assert session.status(0.0).level is Level.WARN
