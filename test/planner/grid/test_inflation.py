"""Laws of the safety boundary, against brute force over all squares."""

import math

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.grid.clearance import clearance, segment_clearance
from quad_planner.grid.combined_obstacles import combined_obstacles
from quad_planner.grid.inflation import inflate

ORIGIN = Pose2D(0.0, 0.0, 0.0)


def random_cells(rng, height, width, fraction=0.05):
    return np.where(rng.random((height, width)) < fraction, 100, 0).astype(np.int8)


def square_distances(points, blocked):
    """Return the distance of each point to the nearest blocked square [cells]."""
    rows, columns = np.nonzero(blocked)
    centers = np.column_stack((columns, rows)) + 0.5
    apart = np.maximum(np.abs(points[:, None] - centers) - 0.5, 0.0)
    return np.linalg.norm(apart, axis=2).min(axis=1)


def test_inflation_is_the_exact_distance_between_squares():
    rng = np.random.default_rng(5)
    for _ in range(40):
        cells = random_cells(rng, *rng.integers(1, 40, 2))
        resolution, radius = rng.uniform(0.02, 0.2), rng.uniform(0.0, 0.7)
        forbidden = inflate(OccupancyGrid(cells, resolution, ORIGIN), radius)
        expected = cells == 100
        rows, columns = np.indices(cells.shape)
        for r, c in np.argwhere(cells == 100):
            apart = (np.maximum(np.abs(at - k) - 1, 0) for at, k in ((rows, r), (columns, c)))
            expected |= np.hypot(*apart) * resolution < radius
        assert (forbidden == expected).all()


def test_no_point_of_an_allowed_cell_is_nearer_than_the_radius():
    rng = np.random.default_rng(6)
    for radius in (0.5, 1.0, 2.0, 3.7):
        cells = random_cells(rng, 30, 30, 0.02)
        allowed = ~inflate(OccupancyGrid(cells, 1.0, ORIGIN), radius)
        inside = np.argwhere(allowed)[:, ::-1, None] + rng.random((1, 2, 20))
        points = np.moveaxis(inside, 1, 2).reshape(-1, 2)
        assert square_distances(points, cells == 100).min() >= radius - 1e-5


def test_a_cell_exactly_at_the_radius_is_allowed():
    cells = np.array([[100, 0, 0, 0]], np.int8)
    grid = OccupancyGrid(cells, 0.1, ORIGIN)
    assert inflate(grid, 0.2).tolist() == [[True, True, True, False]]
    assert inflate(grid, 0.2001).tolist() == [[True, True, True, True]]


def test_radius_zero_forbids_the_obstacles_only():
    cells = random_cells(np.random.default_rng(7), 20, 20)
    assert (inflate(OccupancyGrid(cells, 0.1, ORIGIN), 0.0) == (cells == 100)).all()


def test_unknown_is_an_obstacle_unless_it_is_said_to_be_free():
    grid = OccupancyGrid(np.array([[-1, 0, 0]], np.int8), 0.1, ORIGIN)
    assert inflate(grid, 0.05).tolist() == [[True, True, False]]
    assert not inflate(grid, 0.05, unknown_is_free=True).any()


@pytest.mark.parametrize('threshold', [-500, -1, 0, 1, 65, 100, 101, 500])
@pytest.mark.parametrize('unknown_is_free', [False, True])
def test_any_threshold_does_what_it_says(threshold, unknown_is_free):
    cells = np.arange(-1, 101, dtype=np.int8).reshape(2, 51)[::-1]
    grid = OccupancyGrid(cells, 0.1, ORIGIN)
    options = {'occupied_threshold': threshold, 'unknown_is_free': unknown_is_free}
    blocked = (cells >= threshold) | ((cells == -1) & (not unknown_is_free))
    assert (inflate(grid, 0.0, **options) == blocked).all()


def test_the_outside_of_the_map_is_no_obstacle():
    assert not inflate(OccupancyGrid(np.zeros((5, 5), np.int8), 0.1, ORIGIN), 10.0).any()


@pytest.mark.parametrize('radius', [-0.1, math.nan, math.inf])
def test_a_radius_that_is_no_distance_is_refused(radius):
    with pytest.raises(ParameterError, match=r"'radius' is .*; it must be a finite distance"):
        inflate(OccupancyGrid(np.zeros((5, 5), np.int8), 0.1, ORIGIN), radius)


def test_clearance_is_the_distance_to_the_nearest_square():
    rng = np.random.default_rng(8)
    cells = random_cells(rng, 25, 35)
    grid = OccupancyGrid(cells, 0.1, Pose2D(1.0, -2.0, 0.6))
    points = rng.uniform((0.0, 0.0), (35.0, 25.0), (100, 2))
    expected = square_distances(points, cells == 100) * 0.1
    measured = [clearance(grid, *point) for point in grid.map_to_world(points)]
    assert measured == pytest.approx(expected, abs=1e-9)


def test_clearance_without_obstacles_is_infinite():
    grid = OccupancyGrid(np.zeros((5, 5), np.int8), 0.1, ORIGIN)
    assert clearance(grid, 0.2, 0.2) == math.inf


def test_clearance_of_a_segment_is_the_least_of_its_points():
    rng = np.random.default_rng(9)
    for _ in range(100):
        blocked = rng.random((20, 20)) < 0.01
        blocked[tuple(rng.integers(0, 20, 2))] = True
        a, b = rng.uniform(0.0, 20.0, (2, 2))
        t = np.linspace(0.0, 1.0, 2001)[:, None]
        sampled = square_distances(a + t * (b - a), blocked).min()
        exact = segment_clearance(blocked, a, b)
        assert exact <= sampled + 1e-9
        assert sampled - exact <= np.linalg.norm(b - a) / 2000
        near = segment_clearance(blocked, a, b, within=3.0)
        assert near == pytest.approx(exact) or (near > 3.0 and exact > 3.0)


def test_an_obstacle_far_off_is_found_too():
    blocked = np.zeros((900, 700), dtype=bool)
    point = np.array([7.0, 7.0])
    for x, y in ((699, 0), (0, 899), (300, 7)):
        blocked[y, x] = True
        expected = square_distances(point[None], blocked)[0]
        assert segment_clearance(blocked, point, point) == pytest.approx(expected)
    # From outside of the map as well.
    for x, apart in ((-50.0, 350.0), (-1e9, 1e9)):
        outside = np.array([x, 7.5])
        assert segment_clearance(blocked, outside, outside) == pytest.approx(apart)
        assert segment_clearance(blocked, outside, outside, within=40.0) > 40.0


@pytest.mark.parametrize(('gap', 'count'), [(6, 1), (9, 2)])
def test_obstacles_too_near_each_other_are_one_combined_obstacle(gap, count):
    cells = np.zeros((30, 40), np.int8)
    cells[12:18, 10:14] = cells[12:18, 14 + gap : 18 + gap] = 100
    grid = OccupancyGrid(cells, 0.1, Pose2D(5.0, 0.0, 0.0))
    obstacles = combined_obstacles(grid, inflate(grid, 0.3))
    assert obstacles.count == len(obstacles.outlines) == count
    assert len({int(n) for n in obstacles.labels[cells == 100]}) == count
    for outline in obstacles.outlines:
        assert outline[:, 0].min() >= 5.0 + 0.1 * (10 - 4)


def test_the_line_around_a_combined_obstacle_lies_on_the_boundary():
    cells = np.zeros((30, 40), np.int8)
    cells[12:18, 10:14] = 100
    grid = OccupancyGrid(cells, 0.1, Pose2D(1.0, 2.0, 0.8))
    (outline,) = combined_obstacles(grid, inflate(grid, 0.5)).outlines
    for x, y in outline:
        assert 0.4 <= clearance(grid, x, y) < 0.6


def test_a_room_has_a_line_along_its_inside():
    cells = np.full((20, 20), 100, np.int8)
    cells[2:-2, 2:-2] = 0
    grid = OccupancyGrid(cells, 0.1, ORIGIN)
    obstacles = combined_obstacles(grid, inflate(grid, 0.2))
    assert (obstacles.count, len(obstacles.outlines)) == (1, 2)
