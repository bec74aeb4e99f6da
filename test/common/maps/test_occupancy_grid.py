"""Laws of the occupancy grid and its frames."""

import math

import numpy as np
import pytest

from quad_common.errors import MapError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D

UPRIGHT = Pose2D(0.0, 0.0, 0.0)


def grid_of(height=4, width=6, resolution=0.5, origin=UPRIGHT):
    return OccupancyGrid(np.zeros((height, width), dtype=np.int8), resolution, origin)


def test_the_origin_is_the_lower_left_corner_of_cell_zero_zero():
    grid = grid_of(origin=Pose2D(3.0, -2.0, 0.4))
    assert grid.map_to_world(np.zeros(2)) == pytest.approx([3.0, -2.0])


def test_columns_run_along_the_origins_x_axis_and_rows_along_its_y_axis():
    grid = grid_of(origin=Pose2D(1.0, 1.0, math.pi / 2))
    assert grid.map_to_world(np.array([2.0, 0.0])) == pytest.approx([1.0, 2.0])
    assert grid.map_to_world(np.array([0.0, 2.0])) == pytest.approx([0.0, 1.0])


def test_world_to_map_undoes_map_to_world():
    rng = np.random.default_rng(1)
    for _ in range(50):
        origin = Pose2D(*rng.uniform(-20.0, 20.0, 2), rng.uniform(-4.0, 4.0))
        grid = grid_of(resolution=rng.uniform(0.01, 2.0), origin=origin)
        points = rng.uniform(-10.0, 10.0, (3, 5, 2))
        assert grid.world_to_map(grid.map_to_world(points)) == pytest.approx(points, abs=1e-9)


def test_width_and_height_are_columns_and_rows():
    assert (grid_of().width, grid_of().height) == (6, 4)


def test_bounds_of_an_upright_map_are_its_sides():
    assert grid_of(origin=Pose2D(-1.0, 2.0, 0.0)).bounds() == pytest.approx((-1.0, 2.0, 2.0, 4.0))


def test_bounds_of_a_turned_map_hold_all_four_corners():
    grid = grid_of(origin=Pose2D(0.0, 0.0, math.pi / 2))
    assert grid.bounds() == pytest.approx((-2.0, 0.0, 0.0, 3.0))


def test_a_map_contains_its_border_and_nothing_beyond():
    grid = grid_of()
    assert grid.contains(0.0, 0.0)
    assert grid.contains(3.0, 2.0)
    assert not grid.contains(3.001, 1.0)
    assert not grid.contains(1.0, -0.001)
    assert not grid.contains(math.nan, 1.0)


def test_the_threshold_itself_is_occupied_and_unknown_is_not():
    cells = np.array([[-1, 0, 64, 65, 100]], dtype=np.int8)
    grid = OccupancyGrid(cells, 0.1, Pose2D(0.0, 0.0, 0.0))
    assert grid.occupied().tolist() == [[False, False, False, True, True]]
    assert grid.occupied(50).tolist() == [[False, False, True, True, True]]
    assert grid.unknown().tolist() == [[True, False, False, False, False]]


def test_the_cells_cannot_be_changed_through_the_grid():
    cells = np.zeros((2, 2), dtype=np.int8)
    grid = OccupancyGrid(cells, 0.1, Pose2D(0.0, 0.0, 0.0))
    with pytest.raises(ValueError, match='read-only'):
        grid.cells[0, 0] = 100
    assert cells.flags.writeable


@pytest.mark.parametrize(
    ('cells', 'resolution', 'origin', 'sentence'),
    [
        (np.zeros(4, np.int8), 0.1, (0, 0, 0), 'two-dimensional array of int8, not 1-dim'),
        (np.zeros((2, 2)), 0.1, (0, 0, 0), 'int8, not 2-dimensional of float64'),
        ([[0, 0]], 0.1, (0, 0, 0), 'int8, not a list'),
        (np.zeros((0, 3), np.int8), 0.1, (0, 0, 0), '3 x 0 cells; it must have between 1'),
        (np.broadcast_to(np.int8(0), (2**15, 2**14)), 0.1, (0, 0, 0), '16384 x 32768 cells'),
        (np.zeros((2, 2), np.int8), 0.0, (0, 0, 0), "the map cannot be used: 'resolution' is 0.0"),
        (np.zeros((2, 2), np.int8), math.nan, (0, 0, 0), "'resolution' is nan"),
        (np.zeros((2, 2), np.int8), 0.1, (0, math.inf, 0), "'origin.y' is inf"),
        (np.full((2, 2), 101, np.int8), 0.1, (0, 0, 0), 'hold values from 101 to 101'),
        (np.full((2, 2), -2, np.int8), 0.1, (0, 0, 0), 'hold values from -2 to -2'),
    ],
)
def test_what_is_not_a_map_is_refused_in_one_sentence(cells, resolution, origin, sentence):
    with pytest.raises(MapError, match=sentence):
        OccupancyGrid(cells, resolution, Pose2D(*origin))
