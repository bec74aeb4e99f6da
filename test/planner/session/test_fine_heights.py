"""A height map with finer cells than steps need is planned on with larger ones."""

import numpy as np
import pytest

from quad_common.errors import PlannerError
from quad_common.frames.map_frame import MapFrame
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters
from quad_planner.session.planning_map import PlanningMap

ROBOT = load_robot('genibo')
GRID = OccupancyGrid(np.zeros((16, 50), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
START, GOAL = Pose2D(0.4, 0.4, 0.0), Pose2D(2.1, 0.4, 0.0)


def with_kerb(resolution, height):
    """Return a map with a kerb across the way."""
    heights = np.zeros((round(0.8 / resolution), round(2.5 / resolution)))
    heights[:, round(1.25 / resolution) :] = height
    return HeightMap(heights, resolution, (0.0, 0.0))


@pytest.mark.parametrize('resolution', [0.0008, 0.02])
def test_a_kerb_is_in_the_way_as_on_larger_cells_if_it_is_too_high(resolution):
    made = PlanningMap(
        planner_from_parameters(PlannerParameters(robot='genibo'), ROBOT),
        MapFrame('map'),
        GroundLimits.of(ROBOT),
    )
    made.take_grid(GRID, 'map')
    assert made.take_heights(with_kerb(resolution, 0.5 * ROBOT.step_height), 'map')
    made.search(START, GOAL, None)()
    assert made.take_heights(with_kerb(resolution, 2.0 * ROBOT.step_height), 'map')
    with pytest.raises(PlannerError):
        made.search(START, GOAL, None)()
    # The same map again is no news, whatever became of its cells.
    assert not made.take_heights(with_kerb(resolution, 2.0 * ROBOT.step_height), 'map')
