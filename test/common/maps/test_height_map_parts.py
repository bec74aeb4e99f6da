"""Parts of height maps show what the whole shows."""

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.maps.height_map_parts import are_alike, part_within, thinned

RNG = np.random.default_rng(3)
LEVEL = HeightMap(np.zeros((90, 70)), 0.01, (-0.3, 0.2))
# A plane: between the cells' centers it is known, too.
WHOLE = LEVEL.with_heights(LEVEL.centers @ (0.3, -0.2))


def test_a_part_shows_what_the_whole_shows():
    part = part_within(WHOLE, (-0.1, 0.4, 0.15, 0.7))
    points = RNG.uniform((-0.09, 0.41), (0.14, 0.69), (200, 2))
    assert part.heights.size < WHOLE.heights.size / 6
    assert part.height_at(points) == pytest.approx(points @ (0.3, -0.2))
    assert part_within(WHOLE, (5.0, 5.0, 6.0, 6.0)) is WHOLE


@pytest.mark.parametrize('every', [2, 3, 4, 7])
def test_a_thinned_map_shows_the_same_ground(every):
    thin = thinned(WHOLE, every * 0.01 + 1e-9)
    assert thin.resolution == pytest.approx(every * 0.01)
    assert thin.heights == pytest.approx(thin.centers @ (0.3, -0.2))
    assert thin.heights.size >= WHOLE.heights.size / every**2 / 1.1


def test_a_map_is_not_thinned_beyond_what_is_asked_or_there():
    assert thinned(WHOLE, 0.019) is WHOLE
    small = HeightMap(np.zeros((2, 2)), 0.01, (0.0, 0.0))
    assert thinned(small, 0.1) is small


def test_maps_are_alike_by_what_they_say():
    again = HeightMap(WHOLE.heights.copy(), WHOLE.resolution, WHOLE.origin)
    assert are_alike(WHOLE, again)
    assert are_alike(None, None)
    assert not are_alike(WHOLE, None)
    assert not are_alike(WHOLE, HeightMap(WHOLE.heights, WHOLE.resolution, (0.0, 0.0)))
    assert not are_alike(WHOLE, WHOLE.with_heights(WHOLE.heights + 1e-3))
