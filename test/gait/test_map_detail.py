"""Height maps have no smaller cells than feet need, and others stay as they are."""

import numpy as np
import pytest

from quad_common.maps.height_map import MAX_REACH, HeightMap
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.ground.map_detail import as_feet_need

ROBOTS = available_robots()


def boxes(resolution, side=1.2):
    """Return a map with an upright face at x = 0.5 m."""
    count = round(side / resolution)
    heights = np.zeros((count, count))
    heights[:, round(0.5 / resolution) :] = 0.05
    return HeightMap(heights, resolution, (0.0, 0.0))


@pytest.mark.parametrize('name', ROBOTS)
@pytest.mark.parametrize('resolution', [0.005, 0.01, 0.02, 0.1])
def test_cells_of_usual_maps_stay_as_they_are(name, resolution):
    heights = boxes(resolution)
    assert as_feet_need(heights, load_robot(name)) is heights


@pytest.mark.parametrize('name', ROBOTS)
@pytest.mark.parametrize('resolution', [0.0006, 0.001])
def test_fine_cells_are_thinned_as_far_as_the_feet_of_a_robot_allow(name, resolution):
    robot, fine = load_robot(name), boxes(resolution)
    heights = as_feet_need(fine, robot)
    assert heights.resolution <= max(robot.foot_radius / 6.0, 0.0036 * robot.relative_size)
    # Whatever is looked at around a place is within the largest radius.
    assert 0.18 * robot.relative_size / heights.resolution <= MAX_REACH
    # The face stays where it is, but for a cell.
    line = np.linspace(0.1, 1.1, 300)
    found = heights.height_at(np.column_stack([line, np.full(300, 0.6)]))
    assert abs(line[int(np.argmax(found > 0.025))] - 0.5) <= 1.5 * heights.resolution + 1.0 / 300.0
