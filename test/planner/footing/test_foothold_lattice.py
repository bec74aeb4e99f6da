"""Footholds that are found fast are, bit for bit, those of the criterion, place by place."""

import numpy as np
import pytest

from quad_common.footing.foothold_criterion import FootholdImages
from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.ground_walk import TERRAINS
from quad_planner.footing.foothold_lattice import BINS, _offsets, footholds, lattice_side
from quad_planner.footing.footing import FootedRobot
from quad_sim.world.terrain_spec import make_terrain, specs_from_text

LENGTH = 1.1
"""Side of the ground [m, of TITAN-VIII]."""


def ground(robot, name, seed, resolution):
    """Make a small part of a terrain, with a hole of which nothing is known."""
    scale = robot.relative_size
    specs = tuple(spec.scaled(scale, seed) for spec in specs_from_text(TERRAINS[name]))
    bounds = (-0.3, 0.2, scale * LENGTH - 0.3, scale * LENGTH + 0.2)
    start = Pose2D(bounds[0], scale * LENGTH / 2.0, 0.3)
    heights = make_terrain(specs, bounds, start, resolution=scale * resolution).height_map
    # Steeper than it is walked on, so that every condition counts somewhere.
    values = (1.0 + seed) * heights.heights
    values[5:12, 20:30] = np.nan
    return HeightMap(values, heights.resolution, heights.origin)


def nearest_of(fit, offsets):
    """Return the nearest place that is fit to each place, -1 where there is none."""
    rows, columns = fit.shape
    row, column = np.indices(fit.shape)
    nearest = np.full(fit.shape, -1)
    for down, right in offsets[::-1]:
        i, j = row + down, column + right
        inside = (i >= 0) & (j >= 0) & (i < rows) & (j < columns)
        is_fit = inside & fit[np.clip(i, 0, rows - 1), np.clip(j, 0, columns - 1)]
        nearest = np.where(is_fit, i * columns + j, nearest)
    return nearest


@pytest.mark.sweep(kept=5)
@pytest.mark.parametrize('name', TERRAINS)
@pytest.mark.parametrize(
    ('robot_name', 'resolution', 'seed'),
    [('titan_viii', 0.02, 0), ('titan_viii', 0.012, 1), ('genibo', 0.03, 2)],
)
def test_the_nearest_footholds_are_those_of_the_criterion(robot_name, resolution, name, seed):
    robot = load_robot(robot_name)
    footed = FootedRobot.of(robot, plans_footsteps=seed == 1)
    heights = ground(robot, name, seed, resolution)
    found = footholds(robot, footed.criterion, heights, footed.shins)
    side = lattice_side(robot, heights)
    rows, columns = found.heights.shape
    x, y = (c + (np.arange(n) + 0.5) * side for c, n in zip(heights.origin, (columns, rows)))
    points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
    expected = heights.height_at(points).reshape(rows, columns)
    assert np.array_equal(found.heights, expected, equal_nan=True)
    images = FootholdImages(robot, footed.criterion, heights)
    offsets = _offsets(robot.relative_size * footed.criterion.reach / side)
    unknown = np.isnan(expected)
    for of_bin in (0, 1 + seed, BINS - 1):
        for leg in range(4):
            fit = images.is_fit_beside(footed.shins[of_bin][leg], points).reshape(rows, columns)
            nearest = nearest_of(fit | unknown, offsets)
            assert np.array_equal(found.nearest[of_bin, leg], nearest)
