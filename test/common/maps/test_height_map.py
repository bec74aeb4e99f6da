"""Laws of the height map: planes come back exactly, unknown stays unknown, files keep it."""

import math

import numpy as np
import pytest
from PIL import Image

from quad_common.errors import MapError, ParameterError
from quad_common.maps.height_map import MAX_CELLS, HeightMap
from quad_common.maps.height_map_file import load_height_map, save_height_map

NAN = math.nan


def plane(a=0.2, b=-0.3, c=0.05, bounds=(-1.0, 0.5, 1.0, 2.0), resolution=0.05):
    level = HeightMap.level(bounds, resolution)
    x, y = np.moveaxis(level.centers, -1, 0)
    return level.with_heights(a * x + b * y + c)


def noise(seed=0, rows=30, columns=40, unknown=0.0):
    rng = np.random.default_rng(seed)
    heights = rng.normal(size=(rows, columns))
    heights[rng.random((rows, columns)) < unknown] = NAN
    return HeightMap(heights, 0.1, (2.0, -1.0))


def points_in(heights, count=200, margin=0.0, seed=1):
    x_min, y_min, x_max, y_max = heights.bounds
    low, high = (x_min + margin, y_min + margin), (x_max - margin, y_max - margin)
    return np.random.default_rng(seed).uniform(low, high, (count, 2))


def test_row_zero_is_at_the_bottom_and_the_origin_is_its_lower_left_corner():
    heights = HeightMap(np.array([[1.0, 2.0], [3.0, 4.0]]), 0.5, (10.0, 20.0))
    assert heights.centers[0, 1].tolist() == [10.75, 20.25]
    assert heights.bounds == (10.0, 20.0, 11.0, 21.0)
    assert heights.height_at([[10.25, 20.25], [10.75, 20.25], [10.25, 20.75]]).tolist() == [1, 2, 3]


def test_the_height_at_a_centre_is_the_cells():
    heights = noise(unknown=0.2)
    assert heights.height_at(heights.centers) == pytest.approx(heights.heights, nan_ok=True)


def test_between_centres_a_plane_comes_back_exactly_with_its_slope():
    heights = plane()
    points = points_in(heights, margin=0.025)
    expected = 0.2 * points[:, 0] - 0.3 * points[:, 1] + 0.05
    assert heights.height_at(points) == pytest.approx(expected)
    slopes = heights.slope_at(points_in(heights))
    assert slopes == pytest.approx(np.tile([0.2, -0.3], (200, 1)))


def test_in_the_outer_half_of_a_border_cell_the_height_is_that_of_the_center():
    heights = HeightMap(np.array([[1.0, 2.0]]), 1.0, (0.0, 0.0))
    assert heights.height_at([[0.0, 0.0], [0.4, 1.0], [2.0, 0.5]]).tolist() == [1.0, 1.0, 2.0]


def test_off_the_map_there_is_nothing_or_what_is_assumed_there():
    heights = plane()
    outside = [[-1.01, 1.0], [1.01, 1.0], [0.0, 0.49], [0.0, 2.01]]
    assert np.isnan(heights.height_at(outside)).all()
    assert (heights.height_at(outside, beyond=-2.0) == -2.0).all()
    assert np.isnan(heights.slope_at(outside)).all()
    assert np.isnan(heights.highest_within(outside, 0.2)).all()
    assert not heights.contains(outside).any()
    corners = [[-1.0, 0.5], [1.0, 2.0]]
    assert heights.contains(corners).all()
    assert not np.isnan(heights.height_at(corners)).any()
    assert np.isnan(heights.height_at([NAN, 1.0]))


def test_an_unknown_cell_is_unknown_and_its_neighbours_do_without_it():
    cells = np.array([[1.0, NAN], [1.0, 1.0]])
    heights = HeightMap(cells, 1.0, (0.0, 0.0))
    assert np.isnan(heights.height_at([1.2, 0.8]))
    assert heights.height_at([1.2, 0.8], beyond=7.0) == 7.0
    assert heights.height_at([[0.9, 0.9], [1.2, 1.1]]).tolist() == [1.0, 1.0]
    assert heights.slope_at([0.5, 1.5]).tolist() == [0.0, 0.0]
    assert np.isnan(heights.slope_at([0.5, 0.5])[0])


def test_any_shape_of_points_is_answered_in_that_shape():
    heights = noise()
    points = points_in(heights, 24)
    for shape in ((24,), (4, 6), (2, 3, 4)):
        shaped = points.reshape(*shape, 2)
        assert heights.height_at(shaped).shape == shape
        assert heights.highest_within(shaped, 0.2).shape == shape
        assert heights.step_at(shaped, 0.2).shape == shape
        assert heights.slope_at(shaped).shape == (*shape, 2)
    assert heights.height_at(points[3]) == heights.height_at(points)[3]


@pytest.mark.parametrize('radius', [0.0, 0.04, 0.1, 0.23])
@pytest.mark.parametrize('unknown', [0.0, 0.3, 1.0])
def test_the_highest_and_lowest_within_a_radius_are_those_of_every_cell_that_the_disc_meets(
    radius, unknown
):
    heights = noise(unknown=unknown)
    points = points_in(heights, 60)
    rows = np.floor((points[:, 1] + 1.0) / 0.1).astype(int)
    columns = np.floor((points[:, 0] - 2.0) / 0.1).astype(int)
    highest, lowest = [], []
    for row, column in zip(rows, columns):
        offset = np.abs(heights.centers - heights.centers[row, column])
        gap = np.hypot(*np.moveaxis(np.maximum(offset - 0.05, 0.0), -1, 0))
        near = heights.heights[gap <= radius + 1e-9]
        known = near[~np.isnan(near)]
        highest.append(known.max() if known.size else NAN)
        lowest.append(known.min() if known.size else NAN)
    assert heights.highest_within(points, radius) == pytest.approx(highest, nan_ok=True)
    assert heights.lowest_within(points, radius) == pytest.approx(lowest, nan_ok=True)
    step = np.array(highest) - np.array(lowest)
    assert heights.step_at(points, radius) == pytest.approx(step, nan_ok=True)


def test_nothing_within_the_radius_of_a_point_is_higher_but_for_half_a_diagonal():
    heights = noise()
    points, radius = points_in(heights, 50, margin=0.5), 0.25
    around = np.random.default_rng(2).uniform(-1.0, 1.0, (400, 2))
    around = 0.15 * around[np.hypot(*around.T) <= 1.0]
    swept = heights.height_at(points[:, None] + around)
    assert (heights.highest_within(points, radius) >= swept.max(axis=1) - 1e-12).all()


def test_a_radius_out_of_range_is_refused():
    for radius in (-0.1, 10.5, NAN):
        with pytest.raises(ParameterError, match=r"'radius' is .*; it must be from 0 to 10 m"):
            noise().highest_within([2.5, 0.0], radius)


def test_what_was_given_may_change_afterwards_and_what_is_held_may_not():
    cells = np.zeros((2, 2))
    heights = HeightMap(cells, 1.0, (0.0, 0.0))
    cells[:] = 5.0
    assert heights.heights.max() == 0.0
    with pytest.raises(ValueError, match='read-only'):
        heights.heights[0, 0] = 1.0


@pytest.mark.parametrize(
    ('cells', 'resolution', 'origin', 'told'),
    [
        ([[0.0]], 1.0, (0.0, 0.0), 'not a list'),
        (np.zeros(4), 1.0, (0.0, 0.0), 'not 1-dimensional of float64'),
        (np.zeros((2, 2), int), 1.0, (0.0, 0.0), 'not 2-dimensional of int64'),
        (np.zeros((0, 3)), 1.0, (0.0, 0.0), '3 x 0 cells; it must have between 1'),
        (np.zeros((1, MAX_CELLS + 1), np.float16), 1.0, (0.0, 0.0), f'between 1 and {MAX_CELLS}'),
        (np.zeros((2, 2)), 0.0, (0.0, 0.0), "height map cannot be used: 'resolution' is 0.0"),
        (np.zeros((2, 2)), NAN, (0.0, 0.0), "'resolution' is nan"),
        (np.zeros((2, 2)), 1.0, (NAN, 0.0), "'origin.x' is nan"),
        (
            np.full((2, 2), math.inf),
            1.0,
            (0.0, 0.0),
            "'height' is inf; it must be a finite number from -10000 to 10000 m",
        ),
    ],
)
def test_what_is_no_height_map_is_refused_in_a_sentence(cells, resolution, origin, told):
    with pytest.raises(MapError, match=told):
        HeightMap(cells, resolution, origin)


def test_a_level_map_spans_its_bounds():
    heights = HeightMap.level((-1.0, 2.0, 0.95, 3.0), 0.1, 0.4)
    assert (heights.rows, heights.columns) == (10, 20)
    assert heights.bounds == pytest.approx((-1.0, 2.0, 1.0, 3.0))
    assert (heights.heights == 0.4).all()
    for bounds in ((0.0, 0.0, 0.0, 1.0), (0.0, 0.0, NAN, 1.0), (0.0, 0.0, 1e6, 1e6)):
        with pytest.raises(MapError):
            HeightMap.level(bounds, 0.1)


@pytest.mark.parametrize('unknown', [0.0, 0.3, 1.0])
def test_a_file_keeps_a_height_map_to_the_rounding_of_its_shades(tmp_path, unknown):
    heights = noise(unknown=unknown)
    save_height_map(heights, tmp_path / 'hills.yaml')
    again = load_height_map(tmp_path / 'hills.yaml')
    assert (again.resolution, again.origin) == (heights.resolution, heights.origin)
    assert again.heights == pytest.approx(heights.heights, abs=1e-4, nan_ok=True)
    level = HeightMap.level((0.0, 0.0, 1.0, 1.0), 0.1, 0.3)
    save_height_map(level, tmp_path / 'level.yaml')
    assert load_height_map(tmp_path / 'level.yaml').heights == pytest.approx(level.heights)


def test_the_first_row_of_the_image_is_the_top(tmp_path):
    Image.fromarray(np.array([[0, 1], [11, 65535]], np.uint16)).save(tmp_path / 'a.png')
    text = 'image: a.png\nresolution: 0.5\norigin: [1, -2]\nlowest: -1.0\nheight_step: 0.01\n'
    (tmp_path / 'a.yaml').write_text(text)
    heights = load_height_map(tmp_path / 'a.yaml')
    assert (heights.resolution, heights.origin) == (0.5, (1.0, -2.0))
    expected = np.array([[-0.9, 654.34], [NAN, -1.0]])
    assert heights.heights == pytest.approx(expected, nan_ok=True)


@pytest.mark.parametrize(
    ('changes', 'told'),
    [
        ({'image': None}, "'image' is None"),
        ({'image': 'b.png'}, 'b.png cannot be read: No such file'),
        ({'image': 'gray.png'}, 'is of mode L; it must be gray with 16 bits'),
        ({'image': 'a.yaml'}, 'cannot be read as PNG'),
        ({'resolution': 0}, "'resolution' is 0; it must be a finite number from 0.0001 to 10 m"),
        ({'resolution': None}, "the key 'resolution' is missing"),
        ({'origin': '[1, 2, 3]'}, r"'origin' is \[1, 2, 3\]; it must be \[x, y\]"),
        ({'origin': '[1, .nan]'}, "'origin.y' is nan"),
        ({'height_step': 0}, "'height_step' is 0; it must be a finite number from 1e-09 to 1 m"),
        ({'lowest': 'low'}, "'lowest' is 'low'; it must be a finite number"),
    ],
)
def test_a_file_that_is_none_is_refused_in_a_sentence(tmp_path, changes, told):
    Image.fromarray(np.ones((2, 2), np.uint16)).save(tmp_path / 'a.png')
    Image.fromarray(np.ones((2, 2), np.uint8)).save(tmp_path / 'gray.png')
    values = {'image': 'a.png', 'resolution': 0.5, 'origin': '[0, 0]', 'lowest': 0.0}
    values |= {'height_step': 1e-6, **changes}
    text = ''.join(f'{key}: {value}\n' for key, value in values.items() if value is not None)
    (tmp_path / 'a.yaml').write_text(text)
    with pytest.raises(MapError, match=r'height map file .*a\.yaml: ') as caught:
        load_height_map(tmp_path / 'a.yaml')
    caught.match(told)


def test_a_file_that_is_missing_or_no_yaml_is_refused(tmp_path):
    with pytest.raises(MapError, match=r'height map file .* cannot be read'):
        load_height_map(tmp_path / 'a.yaml')
    (tmp_path / 'a.yaml').write_text('- 1\n')
    with pytest.raises(MapError, match='must hold keys'):
        load_height_map(tmp_path / 'a.yaml')
    with pytest.raises(MapError, match='cannot be written'):
        save_height_map(noise(), tmp_path / 'no' / 'a.yaml')
