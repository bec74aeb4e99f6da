"""Where a camera is follows from points of the floor."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest

from quad_common.errors import CameraError
from quad_common.vision.camera import CameraModel
from quad_perception.picture.camera_calibration import calibrate_pose

LENS = CameraModel.looking_down((0.0, 0.0, 1.0), 0.0, 1.3, distortion=(-0.1, 0.01, 0.001, 0.0, 0.0))
CORNERS = np.array([(0.5, 0.5), (7.5, 0.6), (7.4, 7.5), (0.6, 7.3)])


def camera(seed):
    """A camera somewhere under the ceiling, aslant."""
    rng = np.random.default_rng(seed)
    down = CameraModel.looking_down(
        (*rng.uniform(3.0, 5.0, 2), rng.uniform(5.5, 7.0)), rng.uniform(-3.0, 3.0), 1.3
    )
    turn, _ = cv2.Rodrigues(rng.uniform(-0.15, 0.15, 3))
    return replace(LENS, rotation=down.rotation @ turn, position=down.position)


def floor_points(count, seed=0):
    return np.vstack((CORNERS, np.random.default_rng(seed).uniform(1.0, 7.0, (count - 4, 2))))


def pixels_of(model, points):
    return model.project(np.column_stack((points, np.zeros(len(points)))))


@pytest.mark.parametrize('seed', range(5))
@pytest.mark.parametrize('count', [4, 9])
def test_the_pose_is_found_exactly_from_exact_pixels(seed, count):
    model, points = camera(seed), floor_points(count)
    found = calibrate_pose(LENS, points, pixels_of(model, points))
    assert found.camera.position == pytest.approx(model.position, abs=1e-3)
    assert found.camera.rotation == pytest.approx(model.rotation, abs=1e-3)
    assert found.reprojection_error < 0.01


def test_errors_of_the_pixels_show_in_what_is_reported():
    model, points = camera(1), floor_points(20)
    rng = np.random.default_rng(2)
    found = [
        calibrate_pose(LENS, points, pixels_of(model, points) + rng.normal(0.0, 0.5, (20, 2)))
        for _ in range(40)
    ]
    deviation = np.std([calibration.camera.position for calibration in found], axis=0)
    claimed = np.mean([calibration.position_deviation for calibration in found], axis=0)
    assert deviation == pytest.approx(claimed, rel=0.4)
    mean = np.mean([calibration.reprojection_error for calibration in found])
    assert mean == pytest.approx(0.5 * math.sqrt(2.0 * (40 - 6) / 40), rel=0.1)


def test_points_may_have_heights():
    model = camera(3)
    points = np.column_stack((floor_points(6), [0.0, 0.3, 0.0, 0.5, 0.2, 0.0]))
    found = calibrate_pose(LENS, points, model.project(points))
    assert found.camera.position == pytest.approx(model.position, abs=1e-3)


@pytest.mark.parametrize(
    ('points', 'said'),
    [
        (CORNERS[:3], '3 points; 4 are needed'),
        (np.array([(0.0, 0.0), (1.0, 1.0), (2.0, 2.0), (5.0, 5.0)]), 'in a line'),
        (np.ones((5, 2)), 'in a line'),
        (np.full((4, 2), math.nan), 'finite numbers'),
    ],
)
def test_points_that_do_not_fix_a_camera_are_refused(points, said):
    pixels = np.resize(pixels_of(camera(0), CORNERS), (len(points), 2))
    with pytest.raises(CameraError, match=said):
        calibrate_pose(LENS, points, pixels)


def test_points_that_are_mixed_up_are_noticed():
    pixels = pixels_of(camera(0), CORNERS)
    with pytest.raises(CameraError, match='fits'):
        calibrate_pose(LENS, CORNERS, pixels[[1, 0, 2, 3]])
    with pytest.raises(CameraError, match='fits'):
        calibrate_pose(LENS, CORNERS, pixels[::-1])


def test_a_wrong_point_among_many_is_named():
    points = floor_points(12)
    pixels = pixels_of(camera(0), points)
    pixels[6] += 60.0
    with pytest.raises(CameraError, match='number 7'):
        calibrate_pose(LENS, points, pixels)


def test_as_many_pixels_as_points_are_needed():
    with pytest.raises(CameraError, match='4 points and 3 pixels'):
        calibrate_pose(LENS, CORNERS, np.ones((3, 2)))
