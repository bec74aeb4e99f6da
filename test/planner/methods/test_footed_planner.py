"""Plans keep to where the robot finds footholds, and say where they cannot."""

import math

import numpy as np
import pytest

from quad_common.errors import GoalWithoutFooting, NoPathFound
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.methods.footed_planner import BY_FOOTING
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters
from quad_planner.session.planning_map import PlanningMap

ROBOT = load_robot('titan_viii')
LIMITS = GroundLimits.of(ROBOT)
SIDE = 0.04
LEVEL = HeightMap(np.zeros((100, 150)), SIDE, (0.0, 0.0))
GRID = OccupancyGrid(np.zeros((80, 120), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
START, GOAL = Pose2D(0.8, 2.0, 0.0), Pose2D(5.2, 2.0, 0.0)


def with_ribs(bottom, top, left, right):
    """Lay ribs along x, lower than a step and too narrow for a foot, over some rows and columns."""
    heights = LEVEL.heights.copy()
    heights[bottom:top:2, left:right] = 0.06
    return LEVEL.with_heights(heights)


def planning_map(heights=None, **parameters):
    p = PlannerParameters(**parameters)
    made = PlanningMap(planner_from_parameters(p, ROBOT), MapFrame('map'), LIMITS)
    made.take_grid(GRID, 'map')
    if heights is not None:
        made.take_heights(heights, 'map')
    return made


def lowest_clearance(plan, bottom, top, left, right):
    """Return the least distance of a plan from a rectangle [m]."""
    points = np.vstack(
        [np.linspace((a.x, a.y), (b.x, b.y), 200) for a, b in zip(plan.poses[:-1], plan.poses[1:])]
    )
    x = np.maximum(np.maximum(left - points[:, 0], points[:, 0] - right), 0.0)
    y = np.maximum(np.maximum(bottom - points[:, 1], points[:, 1] - top), 0.0)
    return float(np.hypot(x, y).min())


@pytest.mark.sweep(kept=2)
@pytest.mark.parametrize('footprint', ['circle', 'outline'])
@pytest.mark.parametrize('method', ['mesh', 'shortest'])
def test_a_plan_leads_around_ground_without_footholds(method, footprint):
    heights = with_ribs(0, 70, 65, 85)
    across = planning_map(heights, method=method, footprint=footprint, footing='ignore')
    around = planning_map(heights, method=method, footprint=footprint)
    field = (0.0, 70 * SIDE, 65 * SIDE, 85 * SIDE)
    assert lowest_clearance(across.planner.plan(START, GOAL), *field) == 0.0
    plan = around.planner.plan(START, GOAL)
    assert plan.remark == BY_FOOTING
    assert (plan.poses[-1].x, plan.poses[-1].y) == (GOAL.x, GOAL.y)
    # Feet stand aside of the body's center.
    assert lowest_clearance(plan, *field) > 0.1


@pytest.mark.parametrize('method', ['mesh', 'shortest', 'quickest', 'potential'])
def test_on_good_ground_the_plan_is_the_methods_own(method):
    rng = np.random.default_rng(0)
    heights = LEVEL.with_heights(0.01 * rng.random(LEVEL.heights.shape))
    checked, ignored, bare = (
        planning_map(given, method=method, footing=footing).planner.plan(START, GOAL)
        for given, footing in ((heights, 'check'), (heights, 'ignore'), (None, 'check'))
    )
    assert checked == ignored == bare


def test_a_goal_without_footholds_is_refused_in_a_sentence():
    planner = planning_map(with_ribs(0, 70, 65, 105)).planner
    goal = Pose2D(3.4, 2.0, math.pi / 2.0)
    with pytest.raises(GoalWithoutFooting) as caught:
        planner.plan(START, goal)
    assert caught.value.code == 206
    assert (caught.value.x, caught.value.y, caught.value.heading) == (goal.x, goal.y, goal.yaw)
    assert 'cannot stand at the goal (3.40, 2.00) m at a heading of 90 degrees' in str(caught.value)
    assert '0.06 m and 5 degrees' in str(caught.value)


def test_a_goal_is_refused_no_nearer_to_such_ground_than_feet_are():
    planner = planning_map(with_ribs(0, 70, 65, 105)).planner
    front = ROBOT.neutral_feet[:, 0].max()
    planner.plan(START, Pose2D(65 * SIDE - front - 0.1, 2.0, 0.0))
    with pytest.raises(GoalWithoutFooting):
        planner.plan(START, Pose2D(65 * SIDE + front + 0.2, 2.0, 0.0))


def test_where_no_other_plan_is_found_it_is_said_where_footholds_are_missing():
    planner = planning_map(with_ribs(0, 100, 65, 85)).planner
    plan = planner.plan(START, GOAL)
    own = planning_map(with_ribs(0, 100, 65, 85), footing='ignore').planner.plan(START, GOAL)
    assert plan.poses == own.poses
    assert 'without footholds' in plan.remark
    x = float(plan.remark.split('(')[1].split(',')[0])
    assert 65 * SIDE - 0.6 < x < 85 * SIDE


def test_a_robot_that_stands_on_such_ground_may_leave_it():
    planner = planning_map(with_ribs(30, 70, 15, 40)).planner
    plan = planner.plan(Pose2D(1.1, 2.0, 0.0), GOAL)
    assert (plan.poses[-1].x, plan.poses[-1].y) == (GOAL.x, GOAL.y)


def test_a_new_height_map_counts_from_the_next_plan_on():
    at = planning_map(LEVEL)
    assert at.planner.plan(START, GOAL).remark != BY_FOOTING
    at.take_heights(with_ribs(0, 70, 65, 85), 'map')
    assert at.planner.plan(START, GOAL).remark == BY_FOOTING
    at.take_heights(LEVEL, 'map')
    assert at.planner.plan(START, GOAL).remark != BY_FOOTING


def test_walls_that_come_later_leave_what_is_known_of_the_ground():
    at = planning_map(with_ribs(0, 70, 65, 85))
    plan = at.planner.plan(START, GOAL)
    known = at.planner.prepared.footing
    cells = GRID.cells.copy()
    cells[78:, 10:12] = 100
    at.take_grid(OccupancyGrid(cells, GRID.resolution, GRID.origin), 'map')
    assert at.planner.prepared.footing is known
    assert at.planner.plan(START, GOAL).remark == plan.remark == BY_FOOTING
    cells = cells.copy()
    cells[:, 70] = 100
    at.take_grid(OccupancyGrid(cells, GRID.resolution, GRID.origin), 'map')
    with pytest.raises(NoPathFound):
        at.planner.plan(START, GOAL)
