"""The world is the map's occupied cells, no more and no less."""

import math

import numpy as np
import pytest

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_sim.world.world import merge_cells, world_from_map


def covered(rectangles, shape):
    """Count how often each cell is covered."""
    count = np.zeros(shape, dtype=int)
    for x0, y0, x1, y1 in rectangles:
        assert 0 <= x0 < x1 <= shape[1]
        assert 0 <= y0 < y1 <= shape[0]
        count[y0:y1, x0:x1] += 1
    return count


@pytest.mark.parametrize('fraction', [0.0, 0.05, 0.3, 0.5, 0.7, 0.95, 1.0])
def test_rectangles_cover_the_true_cells_exactly_once(fraction):
    rng = np.random.default_rng(1)
    for _ in range(20):
        occupied = rng.random(rng.integers(1, 30, 2)) < fraction
        rectangles = merge_cells(occupied)
        assert (covered(rectangles, occupied.shape) == occupied).all()
        assert len(rectangles) <= max(occupied.sum(), 0)


def test_a_rectangle_of_cells_is_one_rectangle():
    occupied = np.zeros((10, 12), dtype=bool)
    occupied[3:7, 2:9] = True
    assert merge_cells(occupied).tolist() == [[2, 3, 9, 7]]


def test_equal_runs_with_a_gap_between_them_are_not_merged():
    occupied = np.zeros((5, 4), dtype=bool)
    occupied[[0, 1, 3, 4], 1:3] = True
    assert merge_cells(occupied).tolist() == [[1, 0, 3, 2], [1, 3, 3, 5]]


def test_a_room_of_walls_is_a_handful_of_rectangles():
    occupied = np.ones((200, 300), dtype=bool)
    occupied[2:-2, 2:-2] = False
    assert len(merge_cells(occupied)) == 4


@pytest.mark.parametrize('shape', [(1, 1), (1, 7), (7, 1)])
def test_the_smallest_grids_are_covered_as_well(shape):
    assert merge_cells(np.zeros(shape, dtype=bool)).shape == (0, 4)
    assert merge_cells(np.ones(shape, dtype=bool)).tolist() == [[0, 0, shape[1], shape[0]]]


def inside(boxes, points):
    """Tell which points lie within any of the boxes, corners counter-clockwise."""
    found = np.zeros(len(points), dtype=bool)
    for box in boxes:
        edges = np.roll(box, -1, axis=0) - box
        arms = points[:, None] - box
        cross = edges[:, 0] * arms[..., 1] - edges[:, 1] * arms[..., 0]
        found |= (cross > 0.0).all(axis=1)
    return found


@pytest.mark.parametrize('yaw', [0.0, 0.7, -2.5, math.pi])
def test_a_point_is_in_a_box_if_and_only_if_its_cell_is_occupied(yaw):
    rng = np.random.default_rng(2)
    cells = rng.choice(np.array([-1, 0, 64, 65, 100], np.int8), (15, 20))
    grid = OccupancyGrid(cells, 0.1, Pose2D(1.0, -2.0, yaw))
    columns, rows = rng.integers(0, 20, 500), rng.integers(0, 15, 500)
    offsets = rng.uniform(0.01, 0.99, (500, 2))
    points = grid.map_to_world(np.column_stack([columns, rows]) + offsets)
    boxes = world_from_map(grid).boxes
    assert (inside(boxes, points) == (cells[rows, columns] >= 65)).all()


def test_boxes_of_a_turned_map_are_turned_and_counter_clockwise():
    cells = np.zeros((10, 10), np.int8)
    cells[2:4, 5:9] = 100
    grid = OccupancyGrid(cells, 0.5, Pose2D(1.0, 2.0, math.pi / 2))
    (box,) = world_from_map(grid).boxes
    # Columns 5 to 9 run along +y from 2 + 2.5, rows 2 to 4 along -x from 1 - 1.
    assert box == pytest.approx(np.array([[0.0, 4.5], [0.0, 6.5], [-1.0, 6.5], [-1.0, 4.5]]))


def test_without_a_map_the_floor_is_empty():
    world = world_from_map(None, obstacle_height=0.7, friction=0.3)
    assert world.boxes.shape == (0, 4, 2)
    assert (world.obstacle_height, world.friction) == (0.7, 0.3)


def test_a_map_without_obstacles_is_an_empty_floor():
    grid = OccupancyGrid(np.array([[0, -1], [64, 0]], np.int8), 0.1, Pose2D(0.0, 0.0, 0.0))
    assert world_from_map(grid).boxes.shape == (0, 4, 2)
