"""What is known of the ground: a plane through the feet, a height map, good footholds."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_gait.uneven.ground_model import FootholdChoice, GroundModel

FEET = np.array([[0.2, 0.3, 0.0], [0.2, -0.3, 0.0], [-0.2, 0.3, 0.0], [-0.2, -0.3, 0.0]])
CHOICE = FootholdChoice(reach=0.06, radius=0.03, largest_step=0.025, largest_offset=0.1)


def tilted(points, along=0.1, across=-0.2, height=0.5):
    points = np.array(points)
    points[:, 2] = height + points[:, :2] @ [along, across]
    return points


def step_at_zero(height=0.05):
    """Make ground that is higher from x = 0 on."""
    heights = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    return heights.with_heights(np.where(heights.centers[..., 0] > 0.0, height, 0.0))


def test_the_plane_goes_through_feet_that_lie_in_one():
    ground = GroundModel.through(tilted(FEET))
    assert ground.slope == pytest.approx([0.1, -0.2])
    assert ground.height(np.array([1.0, 1.0])) == pytest.approx(0.4)


def test_three_feet_give_a_plane_and_feet_on_a_line_one_that_is_level_across():
    assert GroundModel.through(tilted(FEET[:3])).slope == pytest.approx([0.1, -0.2])
    line = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.1]])
    assert GroundModel.through(line).slope == pytest.approx([0.1, 0.0])
    assert GroundModel.through(line[:1]).slope == pytest.approx([0.0, 0.0])


def test_a_map_is_shifted_to_the_feet_and_believed_where_it_knows():
    heights = step_at_zero()
    ground = GroundModel.through(FEET + [-0.5, 0.0, 0.3], heights)
    assert ground.shift == pytest.approx(0.3)
    assert ground.height(np.array([0.5, 0.0])) == pytest.approx(0.35)
    # Beyond the map the plane goes on.
    assert ground.height(np.array([5.0, 0.0])) == pytest.approx(0.3)


def test_one_foot_on_something_the_map_does_not_show_does_not_shift_it():
    feet = FEET + [-0.5, 0.0, 0.0]
    feet[0, 2] += 0.04
    assert GroundModel.through(feet, step_at_zero()).shift == pytest.approx(0.0)


def test_a_map_that_does_not_know_the_feet_is_not_used():
    far = HeightMap.level((10.0, 10.0, 11.0, 11.0), 0.02, 5.0)
    ground = GroundModel.through(FEET, far)
    assert ground.height_map is None
    assert ground.height(np.array([10.5, 10.5])) == pytest.approx(0.0)


def test_the_highest_ground_between_two_places_is_found_also_beside_the_path():
    heights = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    bump = np.hypot(heights.centers[..., 0], heights.centers[..., 1] - 0.06) < 0.015
    ground = GroundModel.through(FEET, heights.with_heights(np.where(bump, 0.06, 0.0)))
    start, end = np.array([-0.3, 0.0]), np.array([0.3, 0.0])
    assert ground.highest_between(start, end, 0.08) == pytest.approx(0.06)
    assert ground.highest_between(start, end, 0.01) == pytest.approx(0.0)
    assert ground.highest_between(start, np.array([-0.1, 0.0]), 0.05) == pytest.approx(0.0)


def test_a_corner_beside_a_fine_map_s_path_is_found_wherever_it_is():
    level = HeightMap.level((-0.2, -0.2, 0.2, 0.2), 0.005)
    start, end = np.array([-0.1, 0.0]), np.array([0.1, 0.0])
    for x in np.arange(-0.05, 0.05, 0.005):
        corner = np.hypot(level.centers[..., 0] - x, level.centers[..., 1] - 0.01) < 0.004
        ground = GroundModel.through(FEET / 10.0, level.with_heights(np.where(corner, 0.03, 0.0)))
        assert ground.highest_between(start, end, 0.01) == pytest.approx(0.03)


@pytest.mark.parametrize('x', [-0.02, -0.01, 0.0, 0.01, 0.02])
def test_a_foothold_moves_off_an_edge(x):
    ground = GroundModel.through(FEET + [-0.5, 0.0, 0.0], step_at_zero())
    best = ground.best_foothold(np.array([x, 0.1]), CHOICE)
    assert abs(best[0]) >= 0.02
    assert math.dist(best, (x, 0.1)) <= CHOICE.reach + 1e-9


@pytest.mark.parametrize('lean', [-0.6, 0.0, 0.6])
def test_a_foothold_leaves_room_for_the_shin(lean):
    ground = GroundModel.through(FEET + [-0.5, 0.0, 0.0], step_at_zero())
    up = np.linspace(0.0, 0.15, 8)
    shin = np.column_stack([lean * up, np.zeros(8), 0.015 + up])
    choice = replace(CHOICE, reach=0.1, shin=shin, shin_radius=0.025)
    best = ground.best_foothold(np.array([-0.04, 0.1]), choice)
    assert best[0] < 0.0
    below_the_edge = best[0] + shin[shin[:, 2] < 0.05, 0]
    assert (below_the_edge < -choice.shin_radius).all()
    # It goes no farther than it must.
    assert best[0] > -0.04 - choice.reach
    if lean <= 0.0:
        assert best == pytest.approx([-0.04, 0.1], abs=0.026)


@pytest.mark.parametrize('x', [-0.015, 0.005, 0.015])
def test_a_foot_stands_neither_beside_nor_on_the_edge_of_a_step_that_is_small(x):
    ground = GroundModel.through(FEET + [-0.5, 0.0, 0.0], step_at_zero(0.022))
    assert ground.best_foothold(np.array([x, 0.1]), CHOICE) == pytest.approx([x, 0.1])
    choice = replace(CHOICE, shin=np.array([[0.0, 0.0, 0.015]]), shin_radius=0.025)
    best = ground.best_foothold(np.array([x, 0.1]), choice)
    assert abs(best[0]) >= choice.shin_radius


def test_good_ground_is_left_as_it_is_and_so_is_ground_without_a_map():
    ground = GroundModel.through(FEET + [-0.5, 0.0, 0.0], step_at_zero())
    wanted = np.array([-0.3, 0.1])
    assert ground.best_foothold(wanted, CHOICE) == pytest.approx(wanted)
    assert GroundModel.through(FEET).best_foothold(wanted, CHOICE) is wanted


def test_a_foothold_moves_out_of_a_hole():
    heights = HeightMap.level((-1.0, -1.0, 1.0, 1.0), 0.02)
    hole = np.hypot(*np.moveaxis(heights.centers, -1, 0)) < 0.05
    ground = GroundModel.through(
        FEET + [-0.5, 0.0, 0.0], heights.with_heights(np.where(hole, -0.3, 0.0))
    )
    choice = FootholdChoice(reach=0.1, radius=0.03, largest_step=0.025, largest_offset=0.1)
    best = ground.best_foothold(np.array([0.0, 0.0]), choice)
    assert ground.height(best) == pytest.approx(0.0)
    assert np.hypot(*best) > 0.05
