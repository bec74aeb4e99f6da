"""``quadwalk camera``: masks, maps and poses from pictures, and where a camera is."""

import json
import math

import cv2
import numpy as np
import pytest

from quad_cli.main import main
from quad_common.maps.map_file import load_map
from quad_common.vision.camera import CameraModel
from quad_common.vision.camera_file import load_camera, save_camera
from quad_common.vision.markers import GoalMarker

CAMERA = CameraModel.looking_down((4.0, 4.0, 6.0), 0.0, 2.0 * math.atan(4.8 / 6.0))
MARKER = GoalMarker()


def picture():
    """A room with a flat red thing from (2, 2) to (3, 3) m, and a goal at (6, 5) m."""
    image = np.full((640, 640, 3), 200, np.uint8)
    (left, low), (right, high) = CAMERA.project([(2.0, 2.0, 0.0), (3.0, 3.0, 0.0)]).round()
    image[int(high) : int(low), int(left) : int(right)] = (205, 50, 35)
    for x, radius, color in (
        (6.0, MARKER.radius, MARKER.color),
        (6.0 + MARKER.heading_distance, MARKER.heading_radius, MARKER.heading_color),
    ):
        ((column, row),) = CAMERA.project([(x, 5.0, 0.0)]).round().astype(int)
        cv2.circle(image, (int(column), int(row)), round(radius / 0.015), color, cv2.FILLED)
    return image[..., ::-1]


@pytest.fixture
def files(tmp_path):
    cv2.imwrite(str(tmp_path / 'room.png'), picture())
    save_camera(CAMERA, tmp_path / 'camera.yaml')
    return tmp_path


def test_masks_are_drawn_and_counted(files, capsys):
    output = files / 'masks.png'
    assert (
        main(['camera', 'masks', str(files / 'room.png'), '--output', str(output), '--json']) == 0
    )
    fractions = json.loads(capsys.readouterr().out)['fractions']
    assert fractions['obstacle'] == pytest.approx((1.0 / 0.015 / 640.0) ** 2, rel=0.05)
    assert fractions['floor'] > 0.9
    assert fractions['robot_front'] == 0.0
    assert cv2.imread(str(output)).shape == (640 + 22 * 6, 640, 3)


def test_a_file_of_colors_takes_the_place_of_the_usual_ones(files, capsys):
    (files / 'colors.yaml').write_text('obstacle: {lower: [90, 0.3, 0.1], upper: [150, 1, 1]}\n')
    arguments = ['--colors', str(files / 'colors.yaml'), '--output', str(files / 'm.png')]
    assert main(['camera', 'masks', str(files / 'room.png'), *arguments, '--json']) == 0
    fractions = json.loads(capsys.readouterr().out)['fractions']
    assert 0.0 < fractions['obstacle'] == fractions['goal']


def test_a_picture_becomes_a_map_and_poses(files, capsys):
    command = ['camera', 'map', str(files / 'room.png'), '--camera', str(files / 'camera.yaml')]
    output = files / 'map.yaml'
    assert main([*command, '--bounds', '0,0,8,8', '--output', str(output), '--json']) == 0
    said = json.loads(capsys.readouterr().out)
    assert said['obstacles'] == 1
    assert said['goal']['pose'] == pytest.approx([6.0, 5.0, 0.0], abs=0.03)
    assert said['robot'] is None
    assert 'the robot is not seen' in said['robot_problem']
    grid = load_map(output)
    assert grid.cells.shape == (160, 160)
    rows, columns = np.nonzero(grid.occupied())
    assert (columns.mean() + 0.5) * 0.05 == pytest.approx(2.5, abs=0.06)
    assert (rows.mean() + 0.5) * 0.05 == pytest.approx(2.5, abs=0.06)
    assert main(command) == 0
    assert 'goal at (6.0' in capsys.readouterr().out


def test_a_video_is_seen_picture_by_picture(files, capsys):
    path = files / 'walk.avi'
    video = cv2.VideoWriter(str(path), cv2.VideoWriter_fourcc(*'MJPG'), 10.0, (640, 640))
    if not video.isOpened():
        pytest.skip('this OpenCV writes no videos')
    for k in range(5):
        video.write(np.zeros((640, 640, 3), np.uint8) if k == 2 else picture())
    video.release()
    command = ['camera', 'map', str(path), '--camera', str(files / 'camera.yaml'), '--every', '2']
    assert main([*command, '--json']) == 0
    said = json.loads(capsys.readouterr().out)['pictures']
    assert [entry['picture'] for entry in said] == [0, 2, 4]
    assert 'black' in said[1]['problem']
    assert said[2]['goal']['pose'][:2] == pytest.approx([6.0, 5.0], abs=0.03)


def test_what_a_picture_shows_is_drawn_into_it(files, capsys):
    command = ['camera', 'map', str(files / 'room.png'), '--camera', str(files / 'camera.yaml')]
    assert main([*command, '--drawn', str(files / 'seen.png')]) == 0
    assert 'seen.png' in capsys.readouterr().out
    drawn, plain = cv2.imread(str(files / 'seen.png')), cv2.imread(str(files / 'room.png'))
    changed = (drawn != plain).any(axis=2)
    assert 0.001 < changed.mean() < 0.1
    column, row = CAMERA.project([(2.0, 2.5, 0.0)])[0].astype(int)
    assert changed[row, column - 5 : column + 6].any()


def test_a_black_picture_has_no_map(files, capsys):
    cv2.imwrite(str(files / 'black.png'), np.zeros((640, 640, 3), np.uint8))
    command = ['camera', 'map', str(files / 'black.png'), '--camera', str(files / 'camera.yaml')]
    assert main([*command, '--output', str(files / 'none.yaml')]) == 1
    assert 'black' in capsys.readouterr().out
    assert not (files / 'none.yaml').exists()


def test_a_camera_is_calibrated_from_points(files, capsys):
    corners = np.array([(0.5, 0.5, 0.0), (7.5, 0.5, 0.0), (7.5, 7.5, 0.0), (0.5, 7.5, 0.0)])
    lines = ['# x y column row']
    for (x, y, _), (column, row) in zip(corners, CAMERA.project(corners) - 0.5):
        lines.append(f'{x}, {y}, {column:.3f}, {row:.3f}  # a corner')
    (files / 'points.txt').write_text('\n'.join(lines) + '\n')
    command = ['camera', 'calibrate', '--camera', str(files / 'camera.yaml')]
    command += ['--points', str(files / 'points.txt'), '--output', str(files / 'found.yaml')]
    assert main([*command, '--json']) == 0
    said = json.loads(capsys.readouterr().out)
    assert said['position'] == pytest.approx([4.0, 4.0, 6.0], abs=0.01)
    assert said['reprojection_error'] < 0.01
    assert load_camera(files / 'found.yaml').position == pytest.approx([4.0, 4.0, 6.0], abs=0.01)
    assert main(command) == 0
    assert 'camera at (4.0' in capsys.readouterr().out


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('1 2 3\n', 'line 1: it must hold x, y, column and row'),
        ('1 2 3 x\n', 'line 1'),
        ('', '0 points; 4 are needed'),
        ('0 0 1 1\n1 1 2 2\n2 2 3 3\n3 3 4 4\n', 'in a line'),
    ],
)
def test_points_that_are_none_are_said(files, capsys, text, said):
    (files / 'points.txt').write_text(text)
    command = ['camera', 'calibrate', '--camera', str(files / 'camera.yaml')]
    assert main([*command, '--points', str(files / 'points.txt')]) == 2
    assert said in capsys.readouterr().err


def test_what_is_no_picture_is_said(files, capsys):
    (files / 'text.png').write_text('text')
    for name, said in (
        ('none.png', 'cannot be read: No such file'),
        ('text.png', 'neither a picture'),
    ):
        assert main(['camera', 'masks', str(files / name)]) == 2
        assert said in capsys.readouterr().err
    command = ['camera', 'masks', str(files / 'room.png')]
    assert main([*command, '--output', str(files / 'no' / 'm.png')]) == 2
    assert 'cannot be written' in capsys.readouterr().err


def test_a_color_that_nothing_has_is_refused(files, capsys):
    (files / 'colors.yaml').write_text('obstcale: {lower: [345, 0.4, 0.1], upper: [15, 1, 1]}\n')
    command = ['camera', 'masks', str(files / 'room.png'), '--colors', str(files / 'colors.yaml')]
    assert main(command) == 2
    said = capsys.readouterr().err
    assert "colors.yaml: the key 'obstcale' means nothing; valid keys are " in said
    assert 'obstacle' in said
