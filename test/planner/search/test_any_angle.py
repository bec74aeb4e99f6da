"""Paths at any angle are taut, and as short as a full visibility graph's."""

from itertools import combinations

import numpy as np
import pytest
from scipy.sparse.csgraph import dijkstra

from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.inflation import points_allowed, segments_allowed
from quad_planner.search import any_angle


def sees(allowed, *ends):
    forbidden = BitMask.of(~allowed)
    return any_angle.sees(forbidden.words, forbidden.width, *ends)


def convex_corners(allowed):
    return any_angle.convex_corners(BitMask.of(~allowed))


def any_angle_path(allowed, *arguments):
    return any_angle.any_angle_path(BitMask.of(~allowed), *arguments)


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


def length(points):
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


@pytest.mark.parametrize('seed', range(25))
def test_what_is_seen_is_what_an_exact_test_of_pieces_allows(seed):
    rng, allowed = boxes(seed)
    corners = convex_corners(allowed)
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


def test_corners_are_where_the_forbidden_zone_is_convex():
    allowed = np.ones((5, 6), dtype=bool)
    allowed[1:3, 2:4] = False
    assert sorted(map(tuple, convex_corners(allowed))) == [(2, 1), (2, 3), (4, 1), (4, 3)]
    # An L has five outside; its inner corner is none.
    allowed[2, 2] = True
    corners = sorted(map(tuple, convex_corners(allowed)))
    assert corners == [(2, 1), (2, 2), (3, 3), (4, 1), (4, 3)]
    # What the map's edge cuts off is no corner.
    allowed[:] = True
    allowed[0, 0] = False
    assert convex_corners(allowed).tolist() == [[1.0, 1.0]]


@pytest.mark.parametrize('seed', range(25))
def test_taut_paths_are_as_short_as_in_the_whole_visibility_graph(seed):
    rng, allowed = boxes(seed, 22)
    corners = convex_corners(allowed)
    start, goal = random_point(rng, allowed), random_point(rng, allowed)
    points = np.vstack((start, goal, corners))
    distances = np.zeros((len(points), len(points)))
    for i, j in combinations(range(len(points)), 2):
        if segments_allowed(allowed, points[i][None], points[j] - points[i])[0]:
            distances[i, j] = np.hypot(*(points[j] - points[i]))
    shortest = dijkstra(distances, directed=False, indices=0)[1]
    path = any_angle_path(allowed, corners, start, goal, 1e6)
    if path is None:
        assert shortest == np.inf
        return
    assert length(path) == pytest.approx(shortest, abs=1e-9)
    assert path[0] == pytest.approx(start)
    assert path[-1] == pytest.approx(goal)
    assert points_allowed(allowed, path).all()
    assert {tuple(p) for p in path[1:-1]} <= {tuple(c) for c in corners}
    # A bound that is just long enough changes nothing; a shorter one leaves no path.
    assert length(any_angle_path(allowed, corners, start, goal, shortest)) == pytest.approx(
        shortest
    )
    assert any_angle_path(allowed, corners, start, goal, 0.99 * shortest) is None


def test_the_time_is_checked_again_and_again():
    _, allowed = boxes(3)
    corners = convex_corners(allowed)
    ends = np.array([0.5, 0.5]), np.array([11.5, 11.5])
    calls = []
    any_angle_path(allowed, corners, *ends, 1e6, lambda: calls.append(1))
    assert calls

    def stop():
        raise TimeoutError

    with pytest.raises(TimeoutError):
        any_angle_path(allowed, corners, *ends, 1e6, stop)
