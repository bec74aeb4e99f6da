"""Paths at any angle are taut, and as short as a full visibility graph's."""

from itertools import combinations, pairwise

import numpy as np
import pytest
from exact_segments import segments_allowed
from random_floors import random_floor, random_place
from scipy.sparse.csgraph import dijkstra

from quad_planner.any_angle.free_space import FreeSpace
from quad_planner.any_angle.interval_search import any_angle_path, lengths_from
from quad_planner.any_angle.rectangles import corner_places, corners_of
from quad_planner.grid.bit_grid import BitMask
from quad_planner.grid.line_of_sight import sees


def length(points):
    return float(np.hypot(*np.diff(points, axis=0).T).sum())


def least_lengths(free, points):
    """Return the lengths from the first point to the others over all that see each other."""
    distances = np.zeros((len(points), len(points)))
    for i, j in combinations(range(len(points)), 2):
        if segments_allowed(free, points[i][None], points[j] - points[i])[0]:
            distances[i, j] = np.hypot(*(points[j] - points[i])) + 1e-12
    return dijkstra(distances, directed=False, indices=0)


@pytest.mark.parametrize('seed', range(12))
def test_no_path_is_shorter(seed):
    rng = np.random.default_rng(seed)
    free = random_floor(rng, 20)
    if not free.any():
        return
    forbidden = BitMask.of(~free)
    space = FreeSpace.outside(forbidden)
    corners = corners_of(space.rectangles)
    for _ in range(3):
        start, goal = random_place(rng, free), random_place(rng, free)
        shortest = least_lengths(free, np.vstack((start, goal, corners)))[1]
        path = any_angle_path(space, start, goal)
        if path is None:
            assert shortest == np.inf
            continue
        assert length(path) == pytest.approx(shortest, abs=1e-8)
        assert (path[0] == start).all()
        assert (path[-1] == goal).all()
        assert {tuple(p) for p in path[1:-1]} <= {tuple(c) for c in corners}
        for a, b in pairwise(path):
            assert sees(forbidden.words, forbidden.width, *a, *b)
        # A bound that is just long enough changes nothing; a shorter one leaves no path.
        assert length(any_angle_path(space, start, goal, shortest)) == pytest.approx(shortest)
        if shortest > 0.1:
            assert any_angle_path(space, start, goal, 0.99 * shortest) is None


@pytest.mark.parametrize('seed', range(12))
def test_no_corner_is_left_out(seed):
    # Not a corner that is seen along a side either, where no shortest path turns.
    rng = np.random.default_rng(seed)
    free = random_floor(rng, 16)
    if not free.any():
        return
    space = FreeSpace.outside(BitMask.of(~free))
    corners = np.unique(corners_of(space.rectangles), axis=0)
    places = corner_places(space.rectangles, np.arange(4 * len(space.rectangles.bounds)))
    for _ in range(2):
        start, goal = random_place(rng, free), random_place(rng, free)
        lengths = lengths_from(space, start, goal, np.inf)
        others = corners[(corners != start).any(axis=1)]
        measured = [lengths[(places == corner).all(axis=1)].min() for corner in others]
        least = least_lengths(free, np.vstack((start, others)))[1:]
        assert measured == pytest.approx(least.tolist(), abs=1e-8)


def test_a_mirrored_floor_has_a_path_as_long():
    rng = np.random.default_rng(5)
    for _ in range(40):
        free = random_floor(rng, 60)
        if not free.any():
            continue
        ends = np.array([random_place(rng, free), random_place(rng, free)])
        height, width = free.shape
        lengths = []
        for mirrored, places in (
            (free, ends),
            (free[::-1], [0.0, height] + [1.0, -1.0] * ends),
            (free[:, ::-1], [width, 0.0] + [-1.0, 1.0] * ends),
            (free.T, ends[:, ::-1]),
        ):
            path = any_angle_path(FreeSpace.outside(BitMask.of(~mirrored)), *places)
            lengths.append(np.inf if path is None else length(path))
        assert lengths == pytest.approx(lengths[:1] * 4, abs=1e-8)


def test_a_path_leads_through_a_point_between_two_walls():
    free = np.ones((10, 10), dtype=bool)
    free[:5, 5:], free[5:, :5] = False, False
    path = any_angle_path(
        FreeSpace.outside(BitMask.of(~free)), np.array([1.0, 3.0]), np.array([8.0, 9.0])
    )
    assert path.tolist() == [[1.0, 3.0], [5.0, 5.0], [8.0, 9.0]]


def test_many_openings_fit_into_the_first_arrays():
    free = np.ones((3, 9000), dtype=bool)
    free[1, ::2] = False
    path = any_angle_path(
        FreeSpace.outside(BitMask.of(~free)), np.array([1.0, 0.5]), np.array([8990.0, 2.5])
    )
    assert length(path) == pytest.approx(8989.0, abs=1.0)


def test_a_search_can_be_ended():
    space = FreeSpace.outside(BitMask.of(np.zeros((9, 9), dtype=bool)))

    def end():
        raise TimeoutError

    with pytest.raises(TimeoutError):
        any_angle_path(space, np.array([0.5, 0.5]), np.array([8.5, 8.5]), check=end)
