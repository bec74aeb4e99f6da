"""Rough and steep ground costs walking time: what counts as rough, and what plans make of it."""

import math

import numpy as np
import pytest

from quad_common.errors import ParameterError
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_planner.costs.ground_difficulty import GridOverGround, difficulty
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.traversability import Ground
from quad_planner.methods.quickest_planner import walking_cycles
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters
from quad_planner.session.planning_map import PlanningMap

ROBOT: Robot = load_robot('titan_viii')
LIMITS = GroundLimits.of(ROBOT)
LEVEL = HeightMap.level((0.0, 0.0, 8.0, 6.0), 0.02)
X, Y = np.moveaxis(LEVEL.centers, -1, 0)
START, GOAL = Pose2D(1.0, 2.0, 0.0), Pose2D(7.0, 2.0, 0.0)


def over(heights, resolution=0.05, yaw=0.0):
    """Return a free map over ground of these heights."""
    cells = np.zeros((round(6.0 / resolution), round(8.0 / resolution)), np.int8)
    grid = OccupancyGrid(cells, resolution, Pose2D(0.0, 0.0, yaw))
    return GridOverGround.of(grid, Ground(LEVEL.with_heights(heights), LIMITS))


def bumps():
    """Return steps of 30 mm, one every 0.2 m, on a patch that is 2 m wide and 4 m long."""
    inside = (np.abs(X - 4.0) < 1.0) & (Y < 4.0)
    return np.where(inside & (np.floor(X / 0.1) % 2 == 0), 0.03, 0.0)


def test_level_ground_is_not_difficult_and_an_incline_is_not_rough():
    found = difficulty(over(np.zeros_like(X)))
    assert found.roughness.max() == found.slope.max() == 0.0
    angle = 0.1
    found = difficulty(over(math.tan(angle) * (0.6 * X + 0.8 * Y)))
    inner = (slice(10, -10), slice(10, -10))
    assert found.slope[inner] == pytest.approx(angle / LIMITS.largest_slope, abs=1e-6)
    assert found.roughness[inner].max() < 1e-5
    # At the border blocks are not whole.
    assert found.roughness.max() < 0.1


def test_a_step_is_as_rough_as_it_is_high():
    height = 0.5 * LIMITS.step_height
    found = difficulty(over(np.where(X < 4.0, 0.0, height)))
    # The square is counted by cells.
    assert found.roughness.max() == pytest.approx(0.5, rel=0.03)
    row = found.roughness[60]
    assert row[:60].max() == row[100:].max() == 0.0


def test_unknown_ground_costs_nothing_and_a_turned_map_lies_over_the_same_ground():
    heights = bumps()
    straight = difficulty(over(heights)).roughness
    turned_map = over(heights, yaw=0.3)
    turned = difficulty(turned_map).roughness
    rng = np.random.default_rng(0)
    for row, column in rng.integers(20, 60, (50, 2)):
        x, y = turned_map.map_to_world(np.array([column + 0.5, row + 0.5]))
        if 0.0 < x < 8.0 and 0.0 < y < 6.0:
            near = straight[int(y / 0.05) - 1 : int(y / 0.05) + 3, int(x / 0.05) - 1 :][:, :4]
            assert near.min() - 1e-9 <= turned[row, column] <= near.max() + 1e-9
    heights[:, :175] = np.nan
    cut = difficulty(over(heights)).roughness
    assert cut[:, :70].max() == 0.0
    # At the border of what is known it is as difficult as nearby.
    assert (cut[10:70, 72:76] > 0.3).all()
    assert difficulty(OccupancyGrid(np.zeros((5, 5), np.int8), 0.1, START)) is None


def walked(heights, **parameters):
    """Plan over ground as planner_node does; return the plan, and the factors of the map."""
    p = PlannerParameters(footing='ignore', **parameters)
    frame = MapFrame('map')
    planning_map = PlanningMap(planner_from_parameters(p, ROBOT), frame, LIMITS)
    planning_map.take_grid(OccupancyGrid(np.zeros((120, 160), np.int8), 0.05, START_OF_MAP), 'map')
    planning_map.take_heights(LEVEL.with_heights(heights), 'map')
    return planning_map.planner.plan(START, GOAL), planning_map.planner


START_OF_MAP = Pose2D(0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    'method',
    [
        {'method': 'shortest'},
        {'method': 'shortest', 'any_angle': True},
        {'method': 'quickest'},
        {'method': 'quickest', 'any_angle': True},
        {'method': 'potential', 'potential': 'navigation'},
    ],
)
def test_plans_lead_around_rough_ground_where_that_is_quicker_and_else_through_it(method):
    # Around it the robot walks 7.2 m or more, through it 6 m, of which 2 take longer.
    plain, _ = walked(bumps(), **method)
    through, _ = walked(bumps(), roughness_cost=1.2, **method)
    around, planner = walked(bumps(), roughness_cost=15.0, **method)
    assert plain.length == pytest.approx(6.0, abs=0.05)
    assert through.length == pytest.approx(6.0, abs=0.05)
    assert around.length > 7.0
    assert around.corners[:, 1].max() > 3.8
    assert planner.prepared is not None


def test_the_quickest_plan_is_quicker_than_the_one_through_at_every_cost():
    for cost in (1.5, 3.0, 6.0, 10.0):
        plan, planner = walked(bumps(), method='quickest', roughness_cost=cost)
        straight = type(plan).through([(START.x, START.y), (GOAL.x, GOAL.y)], GOAL.yaw)
        method = planner._method
        prepared = planner.prepared
        taken = walking_cycles(method.pace, prepared, START, plan)
        assert taken <= walking_cycles(method.pace, prepared, START, straight)
        is_through = plan.length < 6.1
        assert is_through == (taken == walking_cycles(method.pace, prepared, START, straight))


def test_steep_ground_costs_by_its_slope():
    ramp = 0.2 * np.clip(1.0 - np.abs(X - 4.0), 0.0, None) * (Y < 4.0)
    plain, _ = walked(ramp, method='shortest')
    rough, _ = walked(ramp, method='shortest', roughness_cost=1.0, slope_cost=10.0)
    assert plain.length == pytest.approx(6.0, abs=0.05)
    assert rough.length > 7.0


def test_without_a_cost_the_ground_changes_no_plan_and_is_not_looked_at():
    level, planner = walked(np.zeros_like(X), method='quickest')
    assert not planner.weighs_ground
    assert not isinstance(planner.prepared.grid, GridOverGround)
    assert walked(bumps(), method='quickest')[0] == level


def test_a_new_height_map_changes_the_costs():
    p = PlannerParameters(method='shortest', roughness_cost=15.0)
    planning_map = PlanningMap(planner_from_parameters(p, ROBOT), MapFrame('map'), LIMITS)
    grid = OccupancyGrid(np.zeros((120, 160), np.int8), 0.05, START_OF_MAP)
    planning_map.take_grid(grid, 'map')
    assert planning_map.take_heights(LEVEL.with_heights(bumps()), 'map')
    assert planning_map.planner.plan(START, GOAL).length > 7.0
    assert planning_map.take_heights(LEVEL, 'map')
    assert planning_map.planner.plan(START, GOAL).length == pytest.approx(6.0, abs=0.05)
    # The same map again is no news.
    assert not planning_map.take_grid(grid, 'map')


def test_methods_that_compare_other_things_refuse_it_in_a_sentence():
    with pytest.raises(ParameterError, match='GroundCost'):
        walked(bumps(), method='mesh', roughness_cost=2.0)
