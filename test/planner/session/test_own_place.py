"""No start is refused for what a height map shows where the robot itself stands."""

import numpy as np
import pytest

from quad_common.errors import StartOccupied
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.outline.robot_outline import standing_outline
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters
from quad_planner.session.own_place import OWN_PLACE, without_robot
from quad_planner.session.planning_map import PlanningMap

ROBOT = load_robot('titan_viii')
OUTLINE = standing_outline(ROBOT)
LEVEL = HeightMap.level((0.0, 0.0, 6.0, 4.0), 0.04)
GRID = OccupancyGrid(np.zeros((80, 120), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
START, GOAL = Pose2D(1.4, 2.0, 0.7), Pose2D(4.8, 2.0, 0.0)
ELSEWHERE = Pose2D(3.0, 2.0, 0.0)


def seen(pose):
    """Return a height map that shows the robot at a pose, as high as its body."""
    corners = pose.transform(OUTLINE)
    along = np.roll(corners, -1, axis=0) - corners
    relative = LEVEL.centers[..., None, :] - corners
    inside = (along[:, 0] * relative[..., 1] - along[:, 1] * relative[..., 0] >= 0.0).all(axis=-1)
    return LEVEL.with_heights(np.where(inside, 0.3, 0.0))


def planning_map(heights, **parameters):
    p = PlannerParameters(**parameters)
    made = PlanningMap(planner_from_parameters(p, ROBOT), MapFrame('map'), GroundLimits.of(ROBOT))
    made.outline = OUTLINE
    made.take_grid(GRID, 'map')
    made.take_heights(heights, 'map')
    return made


@pytest.mark.parametrize('footing', ['check', 'ignore'])
@pytest.mark.parametrize('footprint', ['circle', 'outline'])
def test_a_robot_that_the_height_map_shows_may_start(footprint, footing):
    shown = planning_map(seen(START), footprint=footprint, footing=footing)
    level = planning_map(LEVEL, footprint=footprint, footing=footing)
    with pytest.raises(StartOccupied):
        shown.planner.plan(START, GOAL)
    plan = shown.search(START, GOAL, START)()
    assert plan.poses == level.planner.plan(START, GOAL).poses
    assert OWN_PLACE in plan.remark
    assert OWN_PLACE in shown.search_without_bodies(START, GOAL)().remark


def test_what_stands_where_the_robot_does_not_refuses_a_start():
    shown = planning_map(seen(START))
    for robot in (ELSEWHERE, None):
        with pytest.raises(StartOccupied):
            shown.search(START, GOAL, robot)()
    # Nor is anything left out where no start is refused.
    assert not shown.search(GOAL, ELSEWHERE, GOAL)().remark


def test_a_wall_beside_the_robot_still_refuses_its_start_in_the_same_sentence():
    at = planning_map(seen(START))
    cells = GRID.cells.copy()
    cells[38:42, 28] = 100
    at.take_grid(OccupancyGrid(cells, GRID.resolution, GRID.origin), 'map')
    with pytest.raises(StartOccupied) as plain:
        at.planner.plan(START, GOAL)
    with pytest.raises(StartOccupied) as caught:
        at.search(START, GOAL, START)()
    assert str(caught.value) == str(plain.value)


def test_all_of_the_robot_is_left_out_and_little_else():
    pose = Pose2D(2.03, 1.51, -1.1)
    left = without_robot(seen(pose), OUTLINE, pose)
    assert np.nanmax(left.heights) == 0.0
    away = np.hypot(*(LEVEL.centers - (pose.x, pose.y))[np.isnan(left.heights)].T)
    assert away.max() < np.hypot(*OUTLINE.T).max() + 3.0 * LEVEL.resolution
    assert without_robot(left, OUTLINE, pose) is None
    assert without_robot(LEVEL, OUTLINE, Pose2D(-3.0, -3.0, 0.0)) is None
