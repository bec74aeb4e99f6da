"""The camera's model: from the world to the picture and back."""

import math

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.vision.camera import CameraModel

BARREL = (-0.15, 0.03, 0.001, -0.0005, 0.0)


def camera(**changes):
    options = {'position': (1.0, 2.0, 5.0), 'yaw': 0.0, 'field_of_view': math.radians(80.0)}
    return CameraModel.looking_down(**{**options, **changes})


def test_the_point_below_the_camera_is_in_the_middle():
    assert camera().project([(1.0, 2.0, 0.0)]) == pytest.approx(np.array([[320.0, 320.0]]))


def test_the_picture_has_x_to_the_right_and_y_up():
    middle, east, north = camera().project([(1.0, 2.0, 0.0), (1.5, 2.0, 0.0), (1.0, 2.5, 0.0)])
    assert east[0] > middle[0]
    assert east[1] == pytest.approx(middle[1])
    assert north[1] < middle[1]
    turned = camera(yaw=math.pi / 2.0).project([(1.0, 2.5, 0.0)])[0]
    assert turned[0] > 320.0
    assert turned[1] == pytest.approx(320.0)


def test_the_field_of_view_spans_the_width():
    half = 5.0 * math.tan(math.radians(40.0))
    left, right = camera().project([(1.0 - half, 2.0, 0.0), (1.0 + half, 2.0, 0.0)])
    assert (left[0], right[0]) == pytest.approx((0.0, 640.0))


@pytest.mark.parametrize('distortion', [(0.0,) * 5, BARREL])
@pytest.mark.parametrize('height', [0.0, 0.4])
def test_a_pixel_looks_at_the_point_that_is_seen_in_it(distortion, height):
    model = camera(yaw=0.3, distortion=distortion)
    places = np.random.default_rng(0).uniform(-2.0, 2.0, (200, 2)) + (1.0, 2.0)
    pixels = model.project(np.column_stack((places, np.full(200, height))))
    assert model.on_plane(pixels, height) == pytest.approx(places, abs=1e-4)


@pytest.mark.parametrize(
    'distortion',
    [(-0.25, 0.06, 0.001, -0.0005, 0.0), (1.0, 0.0, 0.0, 0.0, 0.0), (0.5, 0.5, 0, 0, 0)],
)
def test_the_corners_of_a_wide_lens_are_traced_back_as_exactly_as_its_middle(distortion):
    # A lens that spreads its rim to more than double was not: steps towards it overshot for ever.
    model = camera(field_of_view=1.4, distortion=distortion)
    pixels = np.array([(0.0, 0.0), (640.0, 0.0), (0.0, 640.0), (640.0, 640.0), (320.0, 320.0)])
    seen = model.project(model.position + model.directions(pixels))
    assert seen == pytest.approx(pixels, abs=1e-5)


@pytest.mark.parametrize('distortion', [(0.0,) * 5, BARREL, (1.0, -0.3, 0.1, -0.2, 0.05)])
def test_the_lens_is_opencvs(distortion):
    cv2 = pytest.importorskip('cv2')
    model = camera(yaw=0.3, distortion=distortion)
    points = np.random.default_rng(0).uniform((-4.0, -4.0, 0.0), (4.0, 4.0, 3.0), (200, 3))
    none = np.zeros(3)
    ahead = (points - model.position) @ model.rotation
    expected, _ = cv2.projectPoints(ahead, none, none, model.matrix, model.distortion)
    assert model.project(points) == pytest.approx(expected.reshape(-1, 2), rel=1e-12, abs=1e-9)


def test_a_tall_point_is_displaced_away_from_below_the_camera():
    model = camera()
    low, high = model.project([(2.0, 2.0, 0.0), (2.0, 2.0, 1.0)])
    # As S = H / (H - h) says.
    assert model.on_plane([high])[0, 0] - 1.0 == pytest.approx(5.0 / 4.0)
    assert high[0] > low[0]


def test_what_is_not_in_front_of_the_camera_is_not_seen():
    model = camera()
    assert np.isnan(model.project([(1.0, 2.0, 6.0)])).all()
    assert np.isnan(model.on_plane([(320.0, 320.0)], height=6.0)).all()


def test_a_lens_without_distortion_is_straight():
    model = camera(distortion=BARREL)
    points = [(2.5, 3.5, 0.0)]
    assert model.without_distortion().project(points) == pytest.approx(camera().project(points))
    assert np.hypot(*(model.project(points) - camera().project(points))[0]) > 3.0


@pytest.mark.parametrize(
    ('name', 'value'),
    [
        ('field_of_view', 0.0),
        ('field_of_view', math.pi),
        ('position', (math.nan, 0.0, 5.0)),
        ('distortion', (0.0, 0.0)),
        ('size', (0, 640)),
    ],
)
def test_numbers_that_are_not_valid_are_refused(name, value):
    with pytest.raises(ParameterError):
        camera(**{name: value})


def test_a_matrix_with_skew_is_refused():
    straight = camera()
    matrix = straight.matrix.copy()
    matrix[0, 1] = 3.0
    with pytest.raises(ParameterError, match='no skew'):
        CameraModel(640, 640, matrix, straight.rotation, straight.position, straight.distortion)
