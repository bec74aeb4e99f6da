"""A steady map changes where pictures agree, and nowhere else."""

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_perception.tracking.steady_map import SteadyMap


def grid(*occupied, size=4, resolution=0.1):
    cells = np.zeros((size, size), dtype=np.int8)
    for row, column in occupied:
        cells[row, column] = 100
    return OccupancyGrid(cells, resolution, Pose2D(0.0, 0.0, 0.0))


def test_the_first_picture_is_the_map():
    steady = SteadyMap(3)
    assert steady.grid is None
    assert steady.add(grid((1, 1)))
    assert steady.grid.cells[1, 1] == 100


def test_a_change_counts_when_enough_pictures_in_a_row_show_it():
    steady = SteadyMap(3)
    steady.add(grid())
    assert not steady.add(grid((1, 1)))
    assert not steady.add(grid((1, 1)))
    assert steady.add(grid((1, 1)))
    assert steady.grid.cells[1, 1] == 100
    assert not steady.add(grid((1, 1)))


def test_flicker_changes_nothing():
    steady = SteadyMap(2)
    steady.add(grid())
    for k in range(20):
        assert not steady.add(grid((1, 1)) if k % 2 else grid((2, 2)))
    assert not steady.grid.cells.any()


def test_a_change_elsewhere_does_not_delay_one():
    steady = SteadyMap(2)
    steady.add(grid())
    steady.add(grid((1, 1)))
    assert steady.add(grid((1, 1), (2, 2)))
    assert steady.grid.cells[1, 1] == 100
    assert steady.grid.cells[2, 2] == 0


def test_a_map_that_was_given_out_does_not_change():
    steady = SteadyMap(1)
    steady.add(grid())
    first = steady.grid
    steady.add(grid((1, 1)))
    assert not first.cells.any()


def test_a_map_of_another_size_begins_anew():
    steady = SteadyMap(3)
    steady.add(grid())
    assert steady.add(grid((1, 1), size=5))
    assert steady.grid.cells.shape == (5, 5)


def test_no_confirmation_is_refused():
    with pytest.raises(ParameterError, match='confirmations'):
        SteadyMap(0)
