"""Camera files hold a lens as ROS writes it, and a pose."""

import math

import pytest
import yaml

from quad_common.errors import CameraError
from quad_common.vision.camera import CameraModel
from quad_common.vision.camera_file import load_camera, save_camera

CAMERA = CameraModel.looking_down(
    (1.0, 2.0, 6.0), 0.7, 1.3, (640, 480), (-0.1, 0.02, 0.001, -0.002, 0.0)
)


def test_what_is_written_is_read(tmp_path):
    save_camera(CAMERA, tmp_path / 'camera.yaml')
    read = load_camera(tmp_path / 'camera.yaml')
    assert (read.width, read.height) == (640, 480)
    for name in ('matrix', 'rotation', 'position', 'distortion'):
        assert getattr(read, name) == pytest.approx(getattr(CAMERA, name), abs=1e-12)


def test_files_count_pixels_from_the_middle_of_the_first_as_ros_does(tmp_path):
    save_camera(CAMERA, tmp_path / 'camera.yaml')
    document = yaml.safe_load((tmp_path / 'camera.yaml').read_text())
    assert document['camera_matrix']['data'][2] == CAMERA.matrix[0, 2] - 0.5
    assert document['distortion_model'] == 'plumb_bob'


def test_the_lens_alone_is_enough_where_no_pose_is_needed(tmp_path):
    save_camera(CAMERA, tmp_path / 'camera.yaml')
    document = yaml.safe_load((tmp_path / 'camera.yaml').read_text())
    del document['position'], document['orientation']
    (tmp_path / 'lens.yaml').write_text(yaml.safe_dump(document))
    lens = load_camera(tmp_path / 'lens.yaml', needs_pose=False)
    assert lens.matrix == pytest.approx(CAMERA.matrix)
    with pytest.raises(CameraError, match='camera calibrate'):
        load_camera(tmp_path / 'lens.yaml')


@pytest.mark.parametrize(
    ('change', 'said'),
    [
        ({'image_width': 0}, 'image_width'),
        ({'image_height': 'tall'}, 'image_height'),
        ({'camera_matrix': {'data': [1.0]}}, 'camera_matrix'),
        ({'camera_matrix': {'data': [math.nan] * 9}}, 'camera_matrix'),
        ({'camera_matrix': {'data': [0.0] * 9}}, 'focal_length'),
        ({'distortion_coefficients': None}, 'distortion_coefficients'),
        ({'distortion_model': 'rational_polynomial'}, 'plumb_bob'),
        ({'position': [1.0, 'x', 2.0]}, 'position'),
        ({'orientation': [0.0, 0.0, 0.0, 0.0]}, 'length 1'),
    ],
)
def test_files_that_are_none_are_refused_with_their_name(tmp_path, change, said):
    path = tmp_path / 'camera.yaml'
    save_camera(CAMERA, path)
    document = yaml.safe_load(path.read_text())
    path.write_text(yaml.safe_dump({**document, **change}))
    with pytest.raises(CameraError, match=said) as caught:
        load_camera(path)
    assert str(path) in str(caught.value)


def test_missing_files_and_other_files_are_said(tmp_path):
    with pytest.raises(CameraError, match='cannot be read'):
        load_camera(tmp_path / 'none.yaml')
    (tmp_path / 'text.yaml').write_text('just text')
    with pytest.raises(CameraError, match='must hold keys'):
        load_camera(tmp_path / 'text.yaml')
    (tmp_path / 'broken.yaml').write_text('a: [')
    with pytest.raises(CameraError, match='not YAML'):
        load_camera(tmp_path / 'broken.yaml')
    with pytest.raises(CameraError, match='cannot be written'):
        save_camera(CAMERA, tmp_path / 'no' / 'folder.yaml')
