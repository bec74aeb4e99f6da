"""What a safety map tells of a part of the map is what the whole map says."""

import numpy as np
import pytest

from quad_common.errors import StartOccupied
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.grid.clearance import segment_clearance
from quad_planner.grid.inflated_map import InflatedMap

RESOLUTION = 0.1


def inflated_map(cells, radius=0.25):
    grid = OccupancyGrid(cells, RESOLUTION, Pose2D(0.0, 0.0, 0.0))
    return InflatedMap.of(grid, radius, occupied_threshold=65, unknown_is_free=False)


def scattered(seed, height, width, fraction=0.01):
    rng = np.random.default_rng(seed)
    return rng, np.where(rng.random((height, width)) < fraction, 100, 0).astype(np.int8)


def test_zones_are_the_same_as_bits_and_as_masks():
    _, cells = scattered(1, 70, 130)
    cells[5, 5] = -1
    zones = inflated_map(cells)
    assert (zones.blocked == (cells != 0)).all()
    assert (zones.forbidden == ~zones.allowed).all()
    assert zones.forbidden[zones.blocked].all()
    for row, column in np.ndindex(cells.shape):
        assert zones.is_allowed(np.array([column + 0.5, row + 0.5])) == zones.allowed[row, column]


def test_the_area_of_a_forbidden_point_is_that_of_the_nearest_allowed_cell():
    rng, cells = scattered(2, 260, 300, 0.02)
    # A block so large that its middle is far from every allowed cell.
    cells[40:220, 60:280] = 100
    zones = inflated_map(cells)
    rows, columns = np.nonzero(zones.allowed)
    for point in rng.uniform((0.0, 0.0), (300.0, 260.0), (60, 2)):
        apart = np.hypot(columns + 0.5 - point[0], rows + 0.5 - point[1])
        nearest = np.flatnonzero(apart <= apart.min() + 1e-9)
        areas = {int(zones.areas[rows[k], columns[k]]) for k in nearest}
        row, column = int(point[1]), int(point[0])
        wanted = {int(zones.areas[row, column])} if zones.allowed[row, column] else areas
        assert zones.area_of(point) in wanted


def test_where_nothing_is_allowed_there_is_no_area():
    zones = inflated_map(np.full((200, 9), 100, dtype=np.int8))
    assert zones.area_of(np.array([4.0, 100.0])) == 0


def test_a_start_that_is_refused_is_told_its_distance_to_the_nearest_obstacle():
    rng, cells = scattered(3, 120, 150, 0.003)
    zones = inflated_map(cells, radius=1.5)
    refused = 0
    for x, y in rng.uniform((0.0, 0.0), (15.0, 12.0), (60, 2)):
        point = np.array([x, y]) / RESOLUTION
        apart = segment_clearance(zones.blocked, point, point) * RESOLUTION
        if apart >= 1.5:
            continue
        refused += 1
        with pytest.raises(StartOccupied) as told:
            zones.check_ends(Pose2D(x, y, 0.0), Pose2D(x, y, 0.0), 0.0)
        assert f'{apart:.2f} m' in str(told.value)
    assert refused > 10
