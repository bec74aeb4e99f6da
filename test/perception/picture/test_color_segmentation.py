"""Colors are told apart in any light; ranges are data."""

import math

import numpy as np
import pytest
from pictures import disturbed

from quad_common.errors import CameraError, ParameterError
from quad_common.vision.markers import GoalMarker, RobotMarker
from quad_perception.picture.color_segmentation import ColorRange, load_ranges, segment
from quad_perception.picture.mask_picture import draw_masks
from quad_perception.picture.scene_model import default_ranges

COLORS = {
    'obstacle': (205, 50, 35),
    'floor': (205, 205, 200),
    'robot_front': RobotMarker().front_color,
    'robot_rear': RobotMarker().rear_color,
    'goal': GoalMarker().color,
    'goal_heading': GoalMarker().heading_color,
}


def stripes():
    """A picture with a stripe of 20 columns of each color."""
    return np.repeat(np.array([list(COLORS.values())], np.uint8), 20, axis=1).repeat(60, axis=0)


@pytest.mark.parametrize('brightness', [0.7, 0.85, 1.0, 1.15, 1.3])
@pytest.mark.parametrize('noise', [0.0, 8.0])
def test_each_color_is_told_apart_in_any_light(brightness, noise):
    picture = disturbed(stripes(), np.random.default_rng(1), brightness, noise)
    seen = segment(picture, default_ranges())
    for k, name in enumerate(COLORS):
        inside = np.zeros(picture.shape[:2], bool)
        inside[:, 20 * k + 2 : 20 * k + 18] = True
        outside = np.ones(picture.shape[:2], bool)
        outside[:, max(0, 20 * k - 2) : 20 * k + 22] = False
        mask = seen.masks[name] > 0
        assert mask[inside].mean() > 0.98, name
        assert mask[outside].mean() < 0.005, name


def test_a_range_of_hues_goes_through_zero():
    red = ColorRange('red', (350.0, 0.5, 0.2), (10.0, 1.0, 1.0))
    picture = np.array([[(200, 0, 10), (200, 10, 0), (200, 100, 0), (0, 200, 0)]], np.uint8)
    picture = picture.repeat(8, axis=1).repeat(8, axis=0)
    columns = segment(picture, [red]).masks['red'][4, 4::8] > 0
    assert columns.tolist() == [True, True, False, False]


def test_the_range_around_a_color_holds_its_hue_and_not_gray():
    blue = ColorRange.around('blue', (0, 0, 255), hue=20.0)
    assert (blue.lower[0], blue.upper[0]) == pytest.approx((220.0, 260.0))
    red = ColorRange.around('red', (255, 0, 0), hue=20.0)
    assert (red.lower[0], red.upper[0]) == pytest.approx((340.0, 20.0))
    with pytest.raises(ParameterError, match='gray has no hue'):
        ColorRange.around('floor', (200, 200, 200))


@pytest.mark.parametrize(
    ('lower', 'upper'),
    [
        ((0.0, 0.0, 0.0), (361.0, 1.0, 1.0)),
        ((0.0, 0.6, 0.0), (90.0, 0.5, 1.0)),
        ((0.0, 0.0, math.nan), (90.0, 0.5, 1.0)),
        ((0.0, 0.0), (90.0, 0.5, 1.0)),
    ],
)
def test_ranges_that_are_none_are_refused(lower, upper):
    with pytest.raises(ParameterError, match='thing'):
        ColorRange('thing', lower, upper)


def test_pictures_that_are_none_are_refused():
    for bad in (None, np.zeros((4, 4), np.uint8), np.zeros((4, 4, 3)), np.zeros((0, 4, 3), 'u1')):
        with pytest.raises(ParameterError, match='rgb'):
            segment(bad, default_ranges())


def test_two_ranges_of_one_name_are_refused():
    one = ColorRange('red', (0.0, 0.0, 0.0), (1.0, 1.0, 1.0))
    with pytest.raises(ParameterError, match='different names'):
        segment(stripes(), [one, one])


def test_ranges_are_read_from_a_file(tmp_path):
    path = tmp_path / 'colors.yaml'
    path.write_text('obstacle: {lower: [340, 0.4, 0.1], upper: [20, 1, 1]}\n')
    assert load_ranges(path) == (ColorRange('obstacle', (340.0, 0.4, 0.1), (20.0, 1.0, 1.0)),)


@pytest.mark.parametrize(
    ('text', 'said'),
    [
        ('', 'must hold names'),
        ('a: 3', "'a' is 3; it must be given by lower and upper"),
        ('a: {lower: [1, 2], upper: [3, 4]}', "'a.lower'"),
        ('a: {lower: x, upper: [3, 0, 0]}', "'a.lower'"),
        ('a: [', 'not YAML'),
    ],
)
def test_a_file_without_ranges_is_refused_with_its_name(tmp_path, text, said):
    path = tmp_path / 'colors.yaml'
    path.write_text(text)
    with pytest.raises(CameraError, match=said) as caught:
        load_ranges(path)
    assert str(path) in str(caught.value)


def test_a_picture_of_masks_shows_what_is_caught_and_names_it():
    picture = stripes()
    ranges = default_ranges()
    drawn = draw_masks(picture, segment(picture, ranges), ranges)
    assert drawn.shape == (60 + 22 * len(ranges), 120, 3)
    red, green, blue = (int(part) for part in drawn[30, 10])
    assert red > 150
    assert max(green, blue) < 60
