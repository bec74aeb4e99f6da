"""As few corners as can be, near to the path, and clear of what is forbidden."""

import math
from itertools import combinations, count, pairwise

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.line_of_sight import sees
from quad_planner.search.simplification import all_seen, fewest_corners

OPEN = BitMask.of(np.zeros((200, 200), dtype=bool))


def deviation_of(points, corners):
    """How far the points between two corners are from the segment that joins these."""
    farthest = 0.0
    places = [int(np.flatnonzero((points == corner).all(axis=1))[0]) for corner in corners]
    for i, j in pairwise(places):
        a, ab = points[i], points[j] - points[i]
        for p in points[i : j + 1]:
            t = np.clip((p - a) @ ab / max(ab @ ab, 1e-300), 0.0, 1.0)
            farthest = max(farthest, float(np.hypot(*(a + t * ab - p))))
    return farthest


def random_walk(rng, length, size=30.0):
    points = [rng.uniform(3.0, size - 3.0, 2)]
    heading = rng.uniform(0.0, 2.0 * np.pi)
    for _ in range(length - 1):
        heading += rng.normal(0.0, 0.5)
        step = np.array([math.cos(heading), math.sin(heading)])
        points.append(np.clip(points[-1] + step, 0.0, size))
    return np.array(points)


def brute_force(points, deviation, forbidden):
    """Try every choice of corners, fewest first."""
    inner = range(1, len(points) - 1)
    for kept in range(len(points) - 1):
        good = []
        for choice in combinations(inner, kept):
            corners = points[[0, *choice, len(points) - 1]]
            if deviation_of(points, corners) <= deviation and all_seen(corners, forbidden):
                good.append(corners)
        if good:
            return min(good, key=lambda c: np.hypot(*np.diff(c, axis=0).T).sum())
    return points


@pytest.mark.parametrize('seed', range(40))
def test_no_choice_of_corners_is_smaller(seed):
    rng = np.random.default_rng(seed)
    points = random_walk(rng, rng.integers(2, 12))
    deviation = float(rng.choice([0.05, 0.3, 1.0, 3.0]))
    mask = np.zeros((30, 30), dtype=bool)
    for y, x in rng.integers(0, 30, (15, 2)):
        mask[y, x] = True
        if not all_seen(points, BitMask.of(mask)):
            mask[y, x] = False
    forbidden = BitMask.of(mask)
    corners = fewest_corners(points, deviation, forbidden)
    assert corners == pytest.approx(brute_force(points, deviation, forbidden))


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('seed', range(5))
def test_long_paths_stay_near_and_clear(seed):
    rng = np.random.default_rng(seed)
    points = random_walk(rng, 700, 100.0)
    mask = rng.random((100, 100)) < 0.3
    for a, b in pairwise(points):
        for t in np.linspace(0.0, 1.0, 200):
            x, y = np.minimum(a + t * (b - a), 99.9)
            mask[max(int(y) - 1, 0) : int(y) + 2, max(int(x) - 1, 0) : int(x) + 2] = False
    forbidden = BitMask.of(mask)
    corners = fewest_corners(points, 1.0, forbidden)
    assert len(corners) < 400
    assert deviation_of(points, corners) <= 1.0 + 1e-6
    for a, b in pairwise(corners):
        assert sees(forbidden.words, forbidden.width, *a, *b)


def test_a_straight_line_has_no_corner():
    points = np.column_stack((np.linspace(3.0, 90.0, 500), np.linspace(80.0, 20.0, 500)))
    assert fewest_corners(points, 0.0, OPEN) == pytest.approx(points[[0, -1]])


def test_with_no_deviation_allowed_every_corner_stays():
    points = np.array([[1.0, 1.0], [5.0, 1.0], [5.0, 5.0], [9.0, 6.0]])
    assert fewest_corners(points, 0.0, OPEN).tolist() == points.tolist()


def test_a_quarter_of_a_circle_takes_as_few_chords_as_geometry_says():
    radius, deviation = 50.0, 0.5
    angles = np.linspace(0.0, np.pi / 2.0, 2001)
    points = 60.0 + radius * np.column_stack((np.cos(angles), np.sin(angles)))
    # The middle of a chord of angle phi is radius (1 - cos(phi / 2)) off the arc.
    phi = 2.0 * math.acos(1.0 - deviation / radius)
    assert len(fewest_corners(points, deviation, OPEN)) - 1 == math.ceil(np.pi / 2.0 / phi)


def test_one_that_comes_back_is_not_cut_short():
    points = np.array([[10.0, 10.0], [20.0, 10.0], [30.0, 10.0], [20.0, 10.0], [12.0, 10.0]])
    assert fewest_corners(points, 0.5, OPEN).tolist() == [[10.0, 10.0], [30.0, 10.0], [12.0, 10.0]]


def test_points_that_coincide_do_no_harm():
    points = np.array([[10.0, 10.0]] * 3 + [[20.0, 10.0]] * 3 + [[20.0, 20.0]] * 2)
    corners = fewest_corners(points, 0.1, OPEN)
    assert corners.tolist() == [[10.0, 10.0], [20.0, 10.0], [20.0, 20.0]]
    assert fewest_corners(points[:1], 0.1, OPEN).tolist() == [[10.0, 10.0]]


def test_a_corner_of_an_obstacle_is_not_cut_however_much_deviation_is_allowed():
    mask = np.zeros((40, 40), dtype=bool)
    mask[:20, 20] = True
    forbidden = BitMask.of(mask)
    points = np.array([[10.0, 5.0], [19.0, 20.5], [22.0, 20.5], [30.0, 5.0]])
    corners = fewest_corners(points, 50.0, forbidden)
    assert len(corners) > 2
    assert all_seen(corners, forbidden)


@pytest.mark.parametrize('deviation', [-0.1, math.nan])
def test_a_deviation_below_zero_is_refused(deviation):
    with pytest.raises(ParameterError, match="'deviation'"):
        fewest_corners(np.zeros((2, 2)), deviation, OPEN)


def test_it_can_be_ended_from_outside():
    class EnoughError(Exception):
        pass

    calls = count()

    def check():
        if next(calls) == 2:
            raise EnoughError

    points = random_walk(np.random.default_rng(0), 3000, 190.0)
    with pytest.raises(EnoughError):
        fewest_corners(points, 1.0, OPEN, check)
