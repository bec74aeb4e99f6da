"""
Pictures are written and read under any name that a file can have.
"""

import shutil

import cv2
import numpy as np
import pytest

from quad_common.errors import CameraError
from quad_perception.picture.picture_files import read_pictures, write_picture

SHADES = np.linspace(0, 255, 24 * 32 * 3).reshape(24, 32, 3).astype(np.uint8)


@pytest.mark.parametrize('name', ['room.png', 'a room.png', 'Küche.png', 'not \udcff text.png'])
def test_what_is_written_is_read(tmp_path, name):
    write_picture(tmp_path / name, SHADES)
    (read,) = read_pictures(tmp_path / name)
    assert np.array_equal(read, SHADES)


@pytest.mark.parametrize('name', ['room', 'room.docx', 'a\udcffb'])
def test_a_name_of_no_format_is_said(tmp_path, name):
    with pytest.raises(CameraError, match='cannot be written as a picture'):
        write_picture(tmp_path / name, SHADES)
    assert not list(tmp_path.iterdir())


def test_a_video_whose_name_is_no_text_is_refused(tmp_path):
    good = tmp_path / 'walk.avi'
    video = cv2.VideoWriter(str(good), cv2.VideoWriter.fourcc(*'MJPG'), 10.0, (64, 48))
    video.write(np.zeros((48, 64, 3), np.uint8))
    video.release()
    assert len(list(read_pictures(good))) == 1
    shutil.copy(good, tmp_path / 'walk\udcff.avi')
    with pytest.raises(CameraError, match='not UTF-8'):
        list(read_pictures(tmp_path / 'walk\udcff.avi'))
