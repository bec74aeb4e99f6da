"""Maps become pictures that lie where the map lies, and a ray meets the floor where one points."""

from __future__ import annotations

import math

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_view.scene.floor import floor_picture, floor_point, laid_on, surface_of, with_walls


def test_the_first_row_of_the_picture_is_the_top_of_the_map():
    cells = np.zeros((3, 5), dtype=np.int8)
    cells[0, 0], cells[2, 4] = 100, -1
    picture = floor_picture(OccupancyGrid(cells, 0.1, Pose2D(1.0, 2.0, 0.0)))
    free, wall, unknown = picture.pixels[0, 0], picture.pixels[2, 0], picture.pixels[0, 4]
    assert wall.mean() < unknown.mean() < free.mean()
    assert picture.size == pytest.approx((0.5, 0.3))
    assert (picture.center.x, picture.center.y) == pytest.approx((1.25, 2.15))


def test_the_middle_of_a_turned_map_turns_with_it():
    grid = OccupancyGrid(np.zeros((2, 4), dtype=np.int8), 0.5, Pose2D(0.0, 0.0, math.pi / 2))
    center = floor_picture(grid).center
    assert (center.x, center.y, center.yaw) == pytest.approx((-0.5, 1.0, math.pi / 2))


def test_thin_walls_of_a_large_map_stay_visible():
    cells = np.zeros((3000, 2999), dtype=np.int8)
    cells[:, 1501] = 100
    picture = floor_picture(OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0)))
    assert max(picture.pixels.shape[:2]) <= 1024
    assert (picture.pixels.mean(axis=2) < 100).any(axis=1).all()
    assert picture.size[0] == pytest.approx(2999 * 0.05, abs=0.2)


def test_a_surface_goes_through_the_heights_and_looks_up():
    heights = np.array([[0.0, 0.1, 0.2], [0.3, 0.4, np.nan]])
    surface = surface_of(HeightMap(heights, 0.5, (1.0, 1.0)))
    assert len(surface.faces) == 2
    np.testing.assert_allclose(surface.vertices[4], (1.75, 1.75, 0.4))
    a, b, c = (surface.vertices[surface.faces[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0.0).all()


def test_a_large_height_map_has_few_corners():
    surface = surface_of(HeightMap(np.zeros((1000, 800)), 0.02, (0.0, 0.0)))
    assert len(surface.vertices) <= 41_000


@pytest.mark.parametrize('target', [(0.0, 0.0), (3.0, -2.0), (-7.0, 5.5)])
def test_a_ray_meets_the_floor_where_it_points(target):
    eye = np.array([1.0, -4.0, 3.0])
    direction = np.array([*target, 0.0]) - eye
    assert floor_point(eye, 2.5 * direction) == pytest.approx(target)


@pytest.mark.parametrize('direction', [(0.0, 1.0, 0.0), (0.0, 0.0, 1.0), (1.0, 0.0, -1e-6)])
def test_a_ray_to_the_horizon_meets_no_floor(direction):
    assert floor_point(np.array([0.0, 0.0, 2.0]), np.array(direction)) is None


def test_walls_of_the_map_are_drawn_on_the_ground():
    cells = np.zeros((4, 4), dtype=np.int8)
    cells[1, 2] = 100
    floor = floor_picture(OccupancyGrid(cells, 1.0, Pose2D(0.0, 0.0, 0.0)))
    plain = surface_of(HeightMap(np.zeros((6, 6)), 1.0, (-1.0, -1.0)))
    shown = with_walls(plain, floor)
    changed = (shown.colors != plain.colors).any(axis=1)
    np.testing.assert_allclose(plain.vertices[changed], [(2.5, 1.5, 0.0)])


def test_a_line_is_laid_on_the_ground_between_its_corners_too():
    heights = np.zeros((40, 60))
    heights[:, 20:30] = 0.2
    surface = surface_of(HeightMap(heights, 0.1, (0.0, 0.0)))
    line = np.array([[0.5, 1.0], [5.5, 3.0], [5.5, 1.0]])
    laid = laid_on(surface, line, 0.01)
    assert all((np.abs(laid[:, :2] - corner).max(axis=1) < 1e-9).any() for corner in line)
    over = (laid[:, 0] > 2.05) & (laid[:, 0] < 2.95)
    assert over.sum() > 10
    np.testing.assert_allclose(laid[over, 2], 0.21)
    np.testing.assert_allclose(laid[(laid[:, 0] < 1.95) | (laid[:, 0] > 3.05), 2], 0.01)
    assert np.linalg.norm(np.diff(laid, axis=0), axis=1).max() < 0.25
    np.testing.assert_allclose(laid_on(surface, np.array([[99.0, -99.0]]), 0.0), [(99.0, -99.0, 0)])


def test_without_a_height_map_a_line_has_its_corners_only():
    line = np.array([[0.5, 1.0], [5.5, 3.0]])
    np.testing.assert_allclose(laid_on(None, line, 0.02), [(0.5, 1.0, 0.02), (5.5, 3.0, 0.02)])
