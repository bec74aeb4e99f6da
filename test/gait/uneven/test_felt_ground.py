"""What feet meet says how far a height map is off, and feet reckon with that."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.stance import Stance
from quad_gait.uneven.felt_ground import FeltGround
from quad_gait.uneven.ground_model import GroundModel
from quad_gait.uneven.swing_planner import SwingPlanner
from quad_gait.uneven.uneven_options import UnevenOptions

ROBOT = load_robot('titan_viii')
CELL = 0.02
RNG = np.random.default_rng(5)
STEP = 0.05


def hills():
    """Smooth ground of a few waves."""
    level = HeightMap.level((-2.0, -2.0, 2.0, 2.0), CELL)
    x, y = np.moveaxis(level.centers, -1, 0)
    return level.with_heights(0.06 * np.sin(4.0 * x) + 0.05 * np.cos(5.0 * y + x))


def kerb(at=0.0):
    """Ground that is a step higher beyond an x."""
    level = HeightMap.level((-2.0, -2.0, 2.0, 2.0), CELL)
    return level.with_heights(np.where(level.centers[..., 0] > at, STEP, 0.0))


def standing(ground, x=0.0, y=0.0, feet=None):
    """Return the robot with its feet on ground that is truly so, seen from its own base."""
    feet = ROBOT.neutral_feet.copy() if feet is None else feet
    feet[:, :2] += (x, y)
    feet[:, 2] = ground.height_at(feet[:, :2]) + ROBOT.foot_radius
    # z is measured from the body, which is somewhere above its feet.
    feet[:, 2] -= feet[:, 2].mean() + 0.25
    body = BodyPose(np.array([x, y, 0.0]), 0.0, 0.0, 0.0)
    return Stance(0.0, body, feet, ROBOT.initial_joint_angles, lambda: None)


def crawled(felt, truth, shown, start=-0.8, end=0.8):
    """Crawl over the ground with a map that shows other ground; yield after each landing."""
    feet, k = standing(truth, start).feet, 0
    while start < end:
        feet = feet.copy()
        feet[k % 4, :2] = ROBOT.neutral_feet[k % 4, :2] + (start, 0.0)
        stance = standing(truth, feet=feet)
        felt.note_contact(k % 4, stance, shown)
        yield stance
        start, k = start + 0.05, k + 1


def test_a_map_that_is_right_is_believed_as_it_is_whatever_its_zero():
    truth, felt = hills(), FeltGround(ROBOT)
    raised = truth.with_heights(truth.heights + 3.0)
    for _ in crawled(felt, truth, raised):
        assert not felt.map_shift.any()
    assert felt.map_error == 0.0
    assert felt.remark == ''
    under = standing(truth).feet
    model = felt.model(under, raised)
    assert model.height_map is raised
    assert model.map_error == 0.0
    assert model.shift == GroundModel.through(under, raised).shift


def moved(heights, shift):
    """Return a map that shows everything so much farther."""
    return HeightMap(heights.heights, heights.resolution, tuple(heights.origin + shift))


@pytest.mark.parametrize('shift', [(0.06, -0.08), (-0.1, 0.04), (0.0, 0.1)])
def test_a_map_of_hills_is_moved_back_by_what_feet_meet(shift):
    truth, felt = hills(), FeltGround(ROBOT)
    shown = moved(truth, np.array(shift))
    stance = list(crawled(felt, truth, shown))[-1]
    assert np.hypot(*(felt.map_shift - shift)) < 0.5 * np.hypot(*shift)
    assert felt.map_error <= 2.0 * CELL
    assert felt.remark
    under = stance.feet - (0.0, 0.0, ROBOT.foot_radius)
    off = felt.model(under, shown).height(under[:, :2]) - under[:, 2]
    assert abs(off).max() < 0.012


@pytest.mark.parametrize('off', [0.06, 0.1])
@pytest.mark.parametrize('side', [-1.0, 1.0])
def test_a_kerb_is_found_where_feet_meet_it(off, side):
    felt, shown = FeltGround(ROBOT), moved(kerb(), np.array([side * off, 0.0]))
    noticed = False
    for _ in crawled(felt, kerb(), shown):
        assert felt.map_error <= off + 2.0 * CELL
        noticed |= felt.map_error > 0.0 or felt.map_shift.any()
    assert noticed
    if felt.map_shift.any():
        # It lies somewhere between two footholds.
        assert felt.map_shift[0] == pytest.approx(side * off, abs=0.06)


def test_pebbles_under_a_foot_move_no_map_that_is_right():
    shown, truth = kerb(), kerb()
    pebbles = truth.heights.copy()
    x, y = np.moveaxis(truth.centers, -1, 0)
    pebbles[(np.abs(x + 0.45) < 0.03) & (y > 0.0)] += 0.02
    truth, felt = truth.with_heights(pebbles), FeltGround(ROBOT)
    for _ in crawled(felt, truth, shown):
        assert not felt.map_shift.any()
    assert felt.count > 24


def test_level_ground_moves_no_map():
    level, felt = HeightMap.level((-2.0, -2.0, 2.0, 2.0), CELL), FeltGround(ROBOT)
    for _ in crawled(felt, level, level):
        assert not felt.map_shift.any()
        assert felt.map_error == 0.0


def test_a_map_of_other_ground_is_not_used_until_ten_strides_agree_with_it():
    felt, level = FeltGround(ROBOT), HeightMap.level((-2.0, -2.0, 2.0, 2.0), CELL)
    stance = standing(level)
    stance.feet[1, 2] += 0.06
    felt.note_contact(1, stance, level)
    assert math.isinf(felt.map_error)
    assert felt.model(stance.feet, level).height_map is None
    assert 'feel their way' in felt.remark
    for k in range(40):
        assert math.isinf(felt.map_error)
        felt.note_contact(k % 4, standing(level), level)
    assert felt.map_error == 0.0


def test_another_map_is_believed_again():
    felt, level = FeltGround(ROBOT), HeightMap.level((-2.0, -2.0, 2.0, 2.0), CELL)
    stance = standing(level)
    stance.feet[1, 2] += 0.06
    felt.note_contact(1, stance, level)
    felt.forget_map()
    assert felt.map_error == 0.0


def test_what_is_unknown_is_no_reason_to_doubt():
    felt, shown = FeltGround(ROBOT), hills()
    heights = shown.heights.copy()
    heights[:, :100] = math.nan
    for k in range(8):
        felt.note_contact(k % 4, standing(kerb()), shown.with_heights(heights * math.nan))
    assert felt.map_error == 0.0
    assert len(felt.points) == 8


def test_a_foot_that_found_no_ground_says_that_it_is_lower():
    felt, level = FeltGround(ROBOT), HeightMap.level((-2.0, -2.0, 2.0, 2.0), CELL)
    stance = standing(level)
    felt.note_gap(0, stance, level)
    assert felt.map_error == 0.0
    stance.feet[0, 2] -= 0.08
    felt.note_gap(0, stance, level)
    assert math.isinf(felt.map_error)
    assert len(felt.points) == 0


@pytest.mark.parametrize('has_map', [True, False])
def test_places_are_remembered_at_their_heights(has_map):
    truth, felt = hills(), FeltGround(ROBOT)
    x, stance = -1.0, None
    for k in range(40):
        # One foot after the other goes on, as in a crawl.
        feet = (standing(truth, x).feet if stance is None else stance.feet).copy()
        feet[k % 4, :2] = ROBOT.neutral_feet[k % 4, :2] + (x + 0.2, 0.0)
        x += 0.05
        stance = standing(truth, feet=feet)
        felt.note_contact(k % 4, stance, truth if has_map else None)
    points = felt.points
    assert points.shape == (40, 3)
    off = points[:, 2] - truth.height_at(points[:, :2])
    assert np.ptp(off) < 0.003
    if has_map:
        assert abs(off).max() < 0.003


def test_the_more_a_map_may_be_off_the_more_ground_counts():
    shown, under = hills(), standing(hills()).feet
    models = [GroundModel.through(under, shown, error) for error in (0.0, 0.04, 0.08, 0.12)]
    for _ in range(20):
        a, b = RNG.uniform(-0.5, 0.5, (2, 2))
        passed = [model.highest_between(a, b, 0.02) for model in models]
        ranges = [model.range_at(a) for model in models]
        assert passed == sorted(passed)
        assert [low for low, _ in ranges] == sorted((low for low, _ in ranges), reverse=True)
        assert [high for _, high in ranges] == sorted(high for _, high in ranges)
        assert ranges[0][0] == ranges[0][1] == float(models[0].height(a))


@pytest.mark.parametrize('error', [0.0, 0.06])
def test_a_foot_feels_for_the_ground_from_the_highest_place_at_which_it_may_be(error):
    truth = kerb(0.45)
    stance = replace(standing(truth), find_loads=lambda: np.full(4, 1.0))
    under = stance.feet - (0.0, 0.0, ROBOT.foot_radius)
    ground = GroundModel.through(under, truth, error)
    planner = SwingPlanner(ROBOT, UnevenOptions(), 0.05)
    # To just before the kerb, where a map that is off would have the foot meet it.
    place = np.array([0.41, ROBOT.neutral_feet[0, 1]])
    start = stance.feet[0, :2]
    stance.feet[0, :2] = np.minimum(start, place - (0.1, 0.0))
    swing = planner.swing_onto(stance, None, ground, 0, place)
    motion = swing.motion
    feet = [ROBOT.foot_positions(joints) for joints in motion.positions]
    # The three others stand: heights count from them.
    heights = np.array([foot[0, 2] - foot[1:, 2].mean() for foot in feet])
    at_once = heights[min(swing.given, len(heights) - 1)]
    assert at_once == pytest.approx(STEP + 0.01 if error else 0.0, abs=0.004)


def test_a_correction_that_makes_up_for_the_drift_leaves_no_shift():
    truth, felt, drift = hills(), FeltGround(ROBOT), 0.07
    shown = HeightMap(truth.heights, CELL, (-2.0 + drift, -2.0))
    for _ in crawled(felt, truth, shown):
        pass
    assert felt.map_shift[0] == pytest.approx(drift, abs=0.02)
    # The localiser says at last that the robot is farther on.
    felt.note_correction(Pose2D(drift, 0.0, 0.0), Pose2D(0.8 + drift, 0.0, 0.0))
    assert not felt.map_shift.any()
    assert felt.moved(shown) is shown
    off = shown.height_at(np.array(felt._recent)[:, :2]) - np.array(felt._recent)[:, 2]
    assert np.nanmax(np.abs(off - np.nanmedian(off))) < 0.012


def test_a_part_of_the_drift_leaves_a_part_of_the_shift():
    felt = FeltGround(ROBOT)
    felt.map_shift = np.array([0.10, 0.0])
    felt.note_correction(Pose2D(0.04, 0.0, 0.0), Pose2D(1.0, 0.0, 0.0))
    assert felt.map_shift == pytest.approx([0.06, 0.0])


def test_a_correction_that_turns_counts_where_the_robot_is():
    felt = FeltGround(ROBOT)
    felt.map_shift = np.array([0.10, 0.10])
    pose = Pose2D(2.0, 0.0, 0.1)
    about = pose @ Pose2D(0.0, 0.0, 0.1) @ pose.inverse()
    felt.note_correction(about, pose)
    assert felt.map_shift == pytest.approx([0.10, 0.10])


def test_without_a_shift_a_correction_brings_none():
    felt = FeltGround(ROBOT)
    felt.note_correction(Pose2D(0.5, 0.2, 0.1), Pose2D(1.0, 0.0, 0.0))
    assert not felt.map_shift.any()
