"""The highest and lowest around cells: whole images, parts of them, and large ones by tiles."""

import math

import numpy as np
import pytest
from scipy import ndimage

from quad_common.maps import disc_filter
from quad_common.maps.disc_filter import DiscExtremes, disc_extremes
from quad_common.maps.height_map import HeightMap

NAN = math.nan


def image(shape, unknown=0.2, seed=0):
    rng = np.random.default_rng(seed)
    drawn = rng.normal(size=shape)
    drawn[rng.random(shape) < unknown] = NAN
    return drawn


def by_footprint(drawn, reach):
    """Return the same by looking at each cell of the disc around each cell."""
    side = np.arange(-math.ceil(reach), math.ceil(reach) + 1)
    apart = np.maximum(np.abs(side) - 0.5, 0.0)
    disc = np.hypot(apart[:, None], apart) <= reach
    found = []
    for filtered, nothing in (
        (ndimage.maximum_filter, -math.inf),
        (ndimage.minimum_filter, math.inf),
    ):
        known = np.where(np.isnan(drawn), nothing, drawn)
        around = filtered(known, footprint=disc, mode='constant', cval=nothing)
        found.append(np.where(np.isinf(around), NAN, around))
    return found


@pytest.mark.parametrize('shape', [(1, 1), (3, 40), (40, 3), (37, 52)])
@pytest.mark.parametrize('reach', [0.0, 0.3, 0.5, 0.75, 1.0, 1.5, 2.3, 6.5, 25.3])
def test_extremes_in_a_disc_are_those_of_its_cells(shape, reach):
    drawn = image(shape)
    for found, expected in zip(disc_extremes(drawn, reach), by_footprint(drawn, reach)):
        assert np.array_equal(found, expected, equal_nan=True)


def test_where_nothing_is_known_nothing_is_found():
    for found in disc_extremes(np.full((4, 5), NAN), 2.0):
        assert np.isnan(found).all()


@pytest.mark.parametrize('reach', [0.0, 1.5, 4.2])
@pytest.mark.parametrize('tile', [7, 16, 64])
def test_a_large_image_says_the_same_tile_by_tile(monkeypatch, reach, tile):
    monkeypatch.setattr(disc_filter, '_SMALL', 0)
    monkeypatch.setattr(disc_filter, '_TILE', tile)
    drawn = image((48, 65))
    rng = np.random.default_rng(1)
    rows, columns = rng.integers(48, size=(30, 4)), rng.integers(65, size=(30, 4))
    extremes = DiscExtremes(drawn)
    for _ in range(2):
        for found, whole in zip(extremes.at(rows, columns, reach), disc_extremes(drawn, reach)):
            assert np.array_equal(found, whole[rows, columns], equal_nan=True)


def test_a_single_place_on_a_large_map_is_answered(monkeypatch):
    heights = HeightMap(image((90, 80), unknown=0.0), 0.1, (0.0, 0.0))
    expected = heights.highest_within([3.3, 8.9], 0.25), heights.lowest_within([3.3, 8.9], 0.25)
    monkeypatch.setattr(disc_filter, '_SMALL', 0)
    again = HeightMap(heights.heights, 0.1, (0.0, 0.0))
    assert (
        again.highest_within([3.3, 8.9], 0.25),
        again.lowest_within([3.3, 8.9], 0.25),
    ) == expected
    assert np.isnan(again.highest_within([9.0, 1.0], 0.25))


def test_of_a_large_map_only_what_is_near_the_points_is_looked_at(monkeypatch):
    looked_at = []
    honest = disc_filter.disc_extremes

    def counted(part, reach):
        looked_at.append(part.size)
        return honest(part, reach)

    monkeypatch.setattr(disc_filter, 'disc_extremes', counted)
    heights = HeightMap(image((2000, 2000), unknown=0.0), 0.001, (0.0, 0.0))
    heights.step_at([[0.5, 0.5], [0.51, 0.52]], 0.03)
    assert 0 < sum(looked_at) < 0.05 * heights.heights.size
