"""Where a robot can stand on a height map: what each foot finds, and what its legs reach."""

import numpy as np
import pytest

from quad_common.footing.foothold_criterion import FootholdCriterion, FootholdImages
from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_planner.footing import footing as module
from quad_planner.footing.foothold_lattice import BINS
from quad_planner.footing.footing import FootedRobot
from quad_planner.grid.bit_grid import BitMask
from quad_planner.outline.heading_kernels import CLASSES, STEP

ROBOT = load_robot('titan_viii')
FOOTED = FootedRobot.of(ROBOT)
SIDE = 0.04
GRID = OccupancyGrid(np.zeros((60, 75), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
LEVEL = HeightMap(np.zeros((75, 94)), SIDE, (0.0, 0.0))


def unfit(heights, grid=GRID, footed=FOOTED):
    layers = footed.on(heights).layers(grid)
    return np.array([BitMask(layer, grid.width).unpacked() for layer in layers])


def with_ribs(bottom, top, left, right, height=0.06):
    """Lay ribs along x, lower than a step and too narrow for a foot, over some rows and columns."""
    heights = LEVEL.heights.copy()
    heights[bottom:top:2, left:right] = height
    return LEVEL.with_heights(heights)


def test_level_ground_has_footholds_everywhere():
    assert not unfit(LEVEL).any()
    assert not unfit(LEVEL.with_heights(LEVEL.heights + 0.3)).any()


def test_of_ground_that_is_not_known_nothing_bad_is_supposed():
    assert not unfit(LEVEL.with_heights(np.full(LEVEL.heights.shape, np.nan))).any()


def test_a_robot_stands_where_each_foot_finds_a_place_of_the_gaits_criterion_in_reach():
    heights = with_ribs(25, 50, 30, 64)
    found = unfit(heights)
    assert 0.1 < found.mean() < 0.6
    images = FootholdImages(ROBOT, FootholdCriterion(), heights)
    side = np.arange(-4, 5) * SIDE
    rng = np.random.default_rng(1)
    # Well inside: what lies beyond the map is not known.
    rows, columns = rng.integers(15, 45, 300), rng.integers(15, 60, 300)
    for row, column, k in zip(rows, columns, rng.integers(0, CLASSES, 300)):
        pose = Pose2D((column + 0.5) * 0.05, (row + 0.5) * 0.05, k * STEP)
        shins = FOOTED.shins[round(k * BINS / CLASSES) % BINS]
        near, far = [], []
        for leg, foot in enumerate(pose.transform(ROBOT.neutral_feet)[:, :2]):
            # The places of the lattice are the centers of cells.
            middle = (np.floor(foot / SIDE) + 0.5) * SIDE
            places = middle + np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
            fits = images.is_fit_beside(shins[leg], places)
            away = np.hypot(*(places - foot).T)
            near.append(bool(fits[away < FootholdCriterion.reach - SIDE / 2.0].any()))
            far.append(bool(fits[away < FootholdCriterion.reach + 2.0 * SIDE].any()))
        if all(near):
            assert not found[k, row, column]
        if not all(far):
            assert found[k, row, column]


def test_no_stance_has_two_feet_higher_than_legs_reach():
    raised = LEVEL.heights.copy()
    for foot in Pose2D(1.525, 1.525, 0.0).transform(ROBOT.neutral_feet)[[0, 3], :2]:
        x, y = (foot / SIDE).astype(int)
        raised[y - 4 : y + 5, x - 4 : x + 5] = 1.0
    at = 0, 30, 30
    assert unfit(LEVEL.with_heights(0.3 * raised))[at]
    assert not unfit(LEVEL.with_heights(0.1 * raised))[at]


def test_a_plane_that_the_body_tilts_with_can_be_stood_on():
    x = LEVEL.centers[..., 0]
    assert not unfit(LEVEL.with_heights(0.2 * x)).any()


def test_headings_are_seen_from_the_maps_frame():
    heights = with_ribs(25, 50, 0, 94)
    turned = OccupancyGrid(np.zeros((75, 60), dtype=np.int8), 0.05, Pose2D(3.75, 0.0, np.pi / 2.0))
    # Row and column of a cell of the turned map are those of this one, turned about a corner.
    here, there = unfit(heights), unfit(heights, turned)
    moved = np.roll(np.rot90(here, axes=(1, 2)), -CLASSES // 4, axis=0)
    back = np.rot90(moved, 2, axes=(1, 2))
    assert min((moved != there).mean(), (back != there).mean()) < 0.01


@pytest.mark.parametrize('seed', range(3))
def test_what_is_looked_at_again_is_what_all_of_the_map_says(seed):
    rng = np.random.default_rng(seed)
    heights = 0.02 * rng.random(LEVEL.heights.shape)
    before = FOOTED.on(LEVEL.with_heights(heights))
    before.layers(GRID)
    changed = heights.copy()
    row, column = rng.integers(20, 50, 2)
    changed[row : row + 16 : 2, column : column + 14] += 0.1
    changed[row + 1, column] = np.nan
    after = FOOTED.on(LEVEL.with_heights(changed), before)
    whole = FOOTED.on(LEVEL.with_heights(changed))
    assert np.array_equal(after.layers(GRID), whole.layers(GRID))
    assert not np.array_equal(after.layers(GRID), before.layers(GRID))


def test_only_what_has_changed_is_looked_at_again(monkeypatch):
    before = FOOTED.on(with_ribs(25, 50, 30, 64))
    before.layers(GRID)
    looked = []
    find = module.footholds
    monkeypatch.setattr(
        module, 'footholds', lambda *args: looked.append(args[2].heights.size) or find(*args)
    )
    heights = before._heights.heights.copy()
    heights[5, 5] = 0.1
    FOOTED.on(LEVEL.with_heights(heights), before).layers(GRID)
    assert sum(looked) < 0.5 * heights.size
    FOOTED.on(LEVEL.with_heights(heights.copy()), before).layers(GRID)
    same = FOOTED.on(LEVEL.with_heights(before._heights.heights.copy()), before)
    count = len(looked)
    assert same.layers(GRID) is before.layers(GRID)
    assert len(looked) == count


def test_large_maps_are_left_to_the_gait(monkeypatch):
    monkeypatch.setattr(module, 'LARGEST', 1000)
    assert FOOTED.on(LEVEL).layers(GRID) is None


def test_large_height_maps_are_left_to_the_gait(monkeypatch):
    monkeypatch.setattr(module, 'LARGEST_LATTICE', 1000)
    assert FOOTED.on(LEVEL).layers(GRID) is None


@pytest.mark.parametrize('shape', [(1, 1), (1, 50), (50, 1), (2, 3)])
def test_height_maps_smaller_than_a_place_are_looked_at(shape):
    assert not unfit(HeightMap(np.zeros(shape), 0.005, (1.0, 1.0))).any()
