"""Sight lines: what is seen is what an exact test of pieces allows."""

import numpy as np
import pytest
from exact_segments import segments_allowed

from quad_planner.any_angle.rectangles import corners_of, rectangles_of
from quad_planner.grid import line_of_sight
from quad_planner.grid.bit_grid import BitMask


def sees(allowed, *ends):
    forbidden = BitMask.of(~allowed)
    return line_of_sight.sees(forbidden.words, forbidden.width, *ends)


def boxes(seed, size=30):
    """Draw a few boxes on a floor."""
    rng = np.random.default_rng(seed)
    allowed = np.ones(rng.integers(12, size, 2), dtype=bool)
    for _ in range(rng.integers(1, 9)):
        x, y = rng.integers(0, allowed.shape[1]), rng.integers(0, allowed.shape[0])
        allowed[y : y + rng.integers(1, 8), x : x + rng.integers(1, 8)] = False
    return rng, allowed


def random_point(rng, allowed):
    cells = np.argwhere(allowed)[:, ::-1]
    return cells[rng.integers(len(cells))] + rng.random(2)


@pytest.mark.parametrize('seed', range(25))
def test_what_is_seen_is_what_an_exact_test_of_pieces_allows(seed):
    rng, allowed = boxes(seed)
    corners = corners_of(rectangles_of(BitMask.of(~allowed)))
    for _ in range(200):
        a, b = (
            corners[rng.integers(len(corners))]
            if len(corners) and rng.random() < 0.6
            else random_point(rng, allowed)
            for _ in range(2)
        )
        exact = segments_allowed(allowed, a[None], b - a)[0]
        assert sees(allowed, *a, *b) == sees(allowed, *b, *a) == exact, (a, b)


def test_one_sees_along_an_edge_but_not_between_two_walls():
    allowed = np.ones((4, 6), dtype=bool)
    allowed[1, 1:5] = False
    assert sees(allowed, 0.0, 1.0, 6.0, 1.0)
    assert sees(allowed, 1.0, 0.0, 1.0, 4.0)
    allowed[0, 1:5] = False
    assert not sees(allowed, 0.0, 1.0, 6.0, 1.0)


def test_one_does_not_see_along_the_maps_edge_past_a_wall():
    allowed = np.ones((3, 5), dtype=bool)
    allowed[2, 2] = allowed[0, 2] = False
    assert not sees(allowed, 0.5, 3.0, 4.5, 3.0)
    assert not sees(allowed, 0.5, 0.0, 4.5, 0.0)
    assert sees(allowed, 0.5, 2.0, 4.5, 2.0)
