"""Narrow gaps are bridged where feet find holds on both sides; wide ones, and steps, remain."""

import numpy as np
import pytest

from quad_common.errors import PlannerError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.grid.bridged_ground import bridged
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.traversability import Ground
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters

ROBOT = load_robot('titan_viii')
LIMITS = GroundLimits.of(ROBOT, plans_footsteps=True)
GAP = LIMITS.largest_gap


def trench(width, beyond=0.0):
    """Cut a trench across level ground; behind it the ground is higher."""
    level = HeightMap.level((-2.0, -1.5, 2.0, 1.5), 0.02)
    x = level.centers[..., 0]
    heights = np.where(np.abs(x) < width / 2.0, -0.4, np.where(x > 0.0, beyond, 0.0))
    return level.with_heights(heights)


def test_without_footsteps_the_ground_is_as_it_is():
    heights = trench(0.1)
    assert bridged(heights, GroundLimits.of(ROBOT).largest_gap) is heights


@pytest.mark.parametrize('width', [0.04, 0.08, 0.12])
def test_a_narrow_trench_is_filled(width):
    assert not bridged(trench(width), GAP).heights.any()


@pytest.mark.parametrize('width', [0.3, 0.5, 1.0])
def test_a_wide_trench_is_left(width):
    heights = trench(width)
    assert (bridged(heights, GAP).heights == heights.heights).all()


def test_a_step_across_a_trench_remains():
    filled = bridged(trench(0.1, beyond=0.12), GAP).heights
    assert set(np.unique(filled)) == {0.0, 0.12}
    assert Ground(trench(0.1, beyond=0.12), LIMITS).obstacles.any()
    assert not Ground(trench(0.1, beyond=0.06), LIMITS).obstacles.any()


def test_what_stands_on_the_ground_and_what_is_unknown_stay():
    level = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    x, y = np.moveaxis(level.centers, -1, 0)
    heights = np.where((np.abs(x) < 0.03) & (np.abs(y) < 0.5), 0.3, 0.0)
    heights[y > 0.7] = np.nan
    assert bridged(level.with_heights(heights), GAP).heights == pytest.approx(heights, nan_ok=True)


def test_a_path_leads_over_a_trench_with_footsteps_only():
    grid = OccupancyGrid(np.zeros((60, 80), dtype=np.int8), 0.05, Pose2D(-2.0, -1.5, 0.0))
    start, goal = Pose2D(-1.2, 0.0, 0.0), Pose2D(1.2, 0.0, 0.0)
    planner = planner_from_parameters(PlannerParameters(any_angle=True), ROBOT)
    planner.set_map(Ground(trench(0.1), LIMITS).added_to(grid))
    assert planner.plan(start, goal).length == pytest.approx(2.4, abs=0.1)
    planner.set_map(Ground(trench(0.1), GroundLimits.of(ROBOT)).added_to(grid))
    with pytest.raises(PlannerError):
        planner.plan(start, goal)
