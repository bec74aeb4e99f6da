"""Map files are read as Nav2's map server of Jazzy reads them; all values by hand."""

import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from quad_common.errors import MapError
from quad_common.maps.map_file import load_map, save_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D

MAPS = Path(__file__).parents[3].parent / 'shared' / 'maps' / 'ros'

BASE = {
    'image': 'map.png',
    'resolution': 0.05,
    'origin': '[1.0, -2.0, 0.5]',
    'negate': 0,
    'occupied_thresh': 0.65,
    'free_thresh': 0.196,
}


def write_yaml(folder, **changes):
    values = {k: v for k, v in {**BASE, **changes}.items() if v is not None}
    path = folder / 'map.yaml'
    path.write_text(''.join(f'{key}: {value}\n' for key, value in values.items()))
    return path


def cells_of(folder, pixels, **changes):
    """Return the cells of an image of the given pixels."""
    Image.fromarray(pixels).save(folder / 'map.png')
    return load_map(write_yaml(folder, **changes)).cells.tolist()


def gray(*values):
    return np.array([values], dtype=np.uint8)


def test_resolution_and_origin_are_the_files(tmp_path):
    Image.fromarray(gray(0, 1, 2)).save(tmp_path / 'map.png')
    grid = load_map(write_yaml(tmp_path))
    assert (grid.resolution, grid.origin) == (0.05, Pose2D(1.0, -2.0, 0.5))
    assert (grid.width, grid.height) == (3, 1)


def test_the_last_row_of_the_image_is_row_zero(tmp_path):
    assert cells_of(tmp_path, np.array([[0, 0], [254, 205]], np.uint8)) == [[0, -1], [100, 100]]


def test_trinary_knows_free_occupied_and_unknown(tmp_path):
    # p = 1 - 89/255 = 0.651, 1 - 90/255 = 0.647; 1 - 205/255 = 0.19608, 1 - 206/255 = 0.192.
    pixels = gray(0, 89, 90, 205, 206, 254, 255)
    assert cells_of(tmp_path, pixels) == [[100, 100, -1, -1, 0, 0, 0]]


def test_a_shade_on_a_threshold_is_on_the_far_side_of_it(tmp_path):
    cells = cells_of(tmp_path, gray(51, 52, 203, 204), occupied_thresh=0.8, free_thresh=0.2)
    assert cells == [[100, -1, -1, 0]]


def test_negate_turns_black_into_free(tmp_path):
    assert cells_of(tmp_path, gray(0, 128, 255), negate=1) == [[0, -1, 100]]
    assert cells_of(tmp_path, gray(0, 128, 255), negate='true') == [[0, -1, 100]]


def test_scale_grades_what_lies_between_the_thresholds(tmp_path):
    # Pixel 128: p = 0.49804, 100 (p - 0.2) / 0.6 = 49.67. Pixel 200: p = 0.21569, 2.61.
    pixels, thresholds = gray(0, 51, 128, 200, 255), {'occupied_thresh': 0.8, 'free_thresh': 0.2}
    assert cells_of(tmp_path, pixels, mode='scale', **thresholds) == [[100, 100, 50, 3, 0]]
    assert cells_of(tmp_path, pixels, mode='trinary', **thresholds) == [[100, 100, -1, -1, 0]]


def test_raw_takes_the_values_as_they_are(tmp_path):
    Image.fromarray(gray(0, 1, 50, 100, 101, 127, 128, 255)).save(tmp_path / 'map.png')
    expected = [[0, 1, 50, 100, -1, -1, -1, -1]]
    assert load_map(write_yaml(tmp_path, mode='raw')).cells.tolist() == expected
    assert load_map(write_yaml(tmp_path, mode='Raw', negate=1)).cells.tolist() == expected


def test_colors_count_by_their_luma(tmp_path):
    # 0.299 * 100 + 0.587 * 50 + 0.114 * 25 = 62.1
    Image.fromarray(np.array([[[100, 50, 25]]], np.uint8)).save(tmp_path / 'map.png')
    assert load_map(write_yaml(tmp_path, mode='raw')).cells.tolist() == [[62]]


@pytest.mark.parametrize('mode', ['trinary', 'scale'])
@pytest.mark.parametrize('kind', ['LA', 'RGBA'])
def test_a_pixel_that_is_not_opaque_is_unknown(tmp_path, mode, kind):
    rgba = np.array([[[0, 0, 0, 255], [0, 0, 0, 254], [255] * 4, [255, 255, 255, 0]]], np.uint8)
    Image.fromarray(rgba).convert(kind).save(tmp_path / 'map.png')
    assert load_map(write_yaml(tmp_path, mode=mode)).cells.tolist() == [[100, -1, 0, -1]]


def test_raw_does_not_look_at_alpha(tmp_path):
    rgba = np.array([[[7, 7, 7, 0], [9, 9, 9, 255]]], np.uint8)
    Image.fromarray(rgba).save(tmp_path / 'map.png')
    assert load_map(write_yaml(tmp_path, mode='raw')).cells.tolist() == [[7, 9]]


def test_a_palette_may_have_a_transparent_color(tmp_path):
    image = Image.new('P', (3, 1))
    image.putdata([0, 1, 2])
    image.putpalette([0, 0, 0, 255, 255, 255, 255, 255, 255])
    image.save(tmp_path / 'map.png', transparency=2)
    assert load_map(write_yaml(tmp_path)).cells.tolist() == [[100, 0, -1]]


def test_sixteen_bits_are_rounded_to_eight(tmp_path):
    # 89 * 257 = 22873 is the last shade that is occupied; 128 above it rounds to 89 still.
    pixels = np.array([[0, 22873, 22873 + 128, 22873 + 129, 65535]], np.uint16)
    Image.fromarray(pixels).save(tmp_path / 'map.png')
    assert load_map(write_yaml(tmp_path)).cells.tolist() == [[100, 100, 100, -1, 0]]


@pytest.mark.parametrize(
    'content',
    [
        b'P5\n# made by hand\n3 1\n255\n' + bytes([0, 128, 255]),
        b'P2\n3 1 # width, height\n255\n0 128 255\n',
        b'P5\n3 1\n100\n' + bytes([0, 50, 100]),
        b'P2\n3 1\n100\n0 50 100\n',
        b'P5\n3 1\n65535\n' + bytes([0, 0, 128, 0, 255, 255]),
        b'P2\n3 1\n1000\n0 500 1000\n',
    ],
)
def test_every_kind_of_pgm_is_read_with_its_own_white(tmp_path, content):
    (tmp_path / 'map.pgm').write_bytes(content)
    assert load_map(write_yaml(tmp_path, image='map.pgm')).cells.tolist() == [[100, -1, 0]]


def test_an_absolute_image_path_is_taken_as_it_is(tmp_path):
    (tmp_path / 'elsewhere').mkdir()
    image = tmp_path / 'elsewhere' / 'x.png'
    Image.fromarray(gray(0)).save(image)
    assert load_map(write_yaml(tmp_path, image=image)).cells.tolist() == [[100]]


def test_numbers_that_yaml_1_1_takes_for_text_are_numbers(tmp_path):
    Image.fromarray(gray(0)).save(tmp_path / 'map.png')
    assert load_map(write_yaml(tmp_path, resolution='5e-2')).resolution == 0.05


def test_a_saved_map_comes_back(tmp_path):
    rng = np.random.default_rng(2)
    cells = rng.choice(np.array([-1, 0, 100], np.int8), (13, 17))
    grid = OccupancyGrid(cells, 0.1 / 3.0, Pose2D(-1.0 / 3.0, 2.5, 0.7))
    save_map(grid, tmp_path / 'saved.yaml')
    back = load_map(tmp_path / 'saved.yaml')
    assert (back.cells == cells).all()
    assert (back.resolution, back.origin) == (grid.resolution, grid.origin)


def test_between_the_thresholds_a_saved_cell_is_unknown(tmp_path):
    cells = np.array([[0, 25, 26, 64, 65]], np.int8)
    save_map(OccupancyGrid(cells, 0.1, Pose2D(0.0, 0.0, 0.0)), tmp_path / 'm.yaml')
    assert load_map(tmp_path / 'm.yaml').cells.tolist() == [[0, 0, -1, -1, 100]]


@pytest.mark.parametrize(
    ('changes', 'sentence'),
    [
        ({'image': None}, "'image' is None; it must be the name of an image file"),
        ({'image': 'no.png'}, 'no.png cannot be read: No such file'),
        ({'image': 'map.yaml'}, 'cannot be read as PGM, PNG or BMP'),
        ({'image': 'short.pgm'}, 'cannot be read as PGM, PNG or BMP'),
        ({'resolution': None}, "the key 'resolution' is missing"),
        ({'resolution': 'fine'}, "'resolution' is 'fine'; it must be a finite number"),
        ({'resolution': 'true'}, "'resolution' is True; it must be a finite number"),
        ({'resolution': '.nan'}, "'resolution' is nan; it must be a finite number"),
        (
            {'resolution': -0.05},
            "'resolution' is -0.05; it must be a finite number from 0.0001 to 10 m",
        ),
        ({'origin': '[0, 0]'}, r"'origin' is \[0, 0\]; it must be \[x, y, yaw\]"),
        ({'origin': '[0, .inf, 0]'}, "'origin.y' is inf; it must be a finite number"),
        ({'negate': None}, "the key 'negate' is missing"),
        ({'negate': 'perhaps'}, "'negate' is 'perhaps'; it must be 0 or 1"),
        ({'mode': 'binary'}, "'mode' is 'binary'; it must be one of trinary, scale, raw"),
        ({'free_thresh': None}, "the key 'free_thresh' is missing"),
        (
            {'occupied_thresh': 65},
            "'occupied_thresh' is 65; it must be a finite number from 0 to 1",
        ),
        ({'free_thresh': 0.7}, "'free_thresh' is 0.7 and 'occupied_thresh' 0.65"),
        ({'free_thresh': -0.1}, "'free_thresh' is -0.1"),
    ],
)
def test_a_bad_map_is_refused_in_one_sentence_with_its_name(tmp_path, changes, sentence):
    Image.fromarray(gray(0, 255)).save(tmp_path / 'map.png')
    (tmp_path / 'short.pgm').write_bytes(b'P5\n9 9\n255\n123')
    with pytest.raises(MapError, match=sentence) as caught:
        load_map(write_yaml(tmp_path, **changes))
    assert str(caught.value).startswith(f'map file {tmp_path / "map.yaml"}')
    assert '\n' not in str(caught.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(MapError, match=r'no\.yaml cannot be read: No such file'):
        load_map(tmp_path / 'no.yaml')


@pytest.mark.parametrize('text', ['a: [1, 2', '- 1\n- 2\n', '', '\x00'])
def test_what_is_no_yaml_of_keys_is_refused(tmp_path, text):
    path = tmp_path / 'map.yaml'
    path.write_text(text)
    with pytest.raises(MapError, match=r'is not YAML|must hold keys'):
        load_map(path)


@pytest.mark.skipif(not MAPS.is_dir(), reason='the shared maps are not here')
@pytest.mark.parametrize(
    ('name', 'width', 'height', 'resolution'),
    [
        ('warehouse/warehouse', 1006, 1674, 0.03),
        ('depot/depot', 604, 307, 0.05),
        ('turtlebot3_world/map', 384, 384, 0.05),
    ],
)
def test_maps_that_others_made_are_read(name, width, height, resolution):
    grid = load_map(MAPS / f'{name}.yaml')
    assert (grid.width, grid.height) == (width, height)
    assert math.isclose(grid.resolution, resolution)
    assert set(np.unique(grid.cells)) <= {-1, 0, 100}
    assert grid.occupied().any()
