"""Stride and turn of a gait cycle follow from the leg, as S0 sec. 4 has it."""

import math
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import RobotModelError
from quad_common.robot.reach import (
    largest_step,
    largest_step_height,
    largest_stretch,
    largest_stride,
    largest_turn,
    lowest_at_step,
    lowest_at_stretch,
)
from quad_common.robot_files.robot_file import load_robot

ROBOT = load_robot('titan_viii')
LEG = ROBOT.legs[0]

# S0 sec. 6 [mm].
A, B, D, E, L0, H0, ROUGHNESS = 43.0, 200.0, 155.0, 45.0, 200.0, 243.0, 45.0
M, N = 101.0, 201.0


def test_the_largest_stretch_is_equation_16_with_e_outside_the_root():
    expected = math.sqrt((B + D) ** 2 - (H0 + ROUGHNESS - A) ** 2) + E
    assert 1e3 * largest_stretch(LEG, 0.243, 0.045) == pytest.approx(expected)


def test_with_e_inside_the_root_as_printed_the_leg_could_not_even_stand():
    # The paper's printed e is a length under a root of areas; in millimetres:
    printed = math.sqrt((B + D) ** 2 - (H0 + ROUGHNESS - A) ** 2 + E)
    corrected = 1e3 * largest_stretch(LEG, 0.243, 0.045)
    assert corrected - printed == pytest.approx(E, abs=0.1)
    assert math.sqrt(corrected**2 - L0**2) == pytest.approx(226.2, abs=0.05)
    # The paper's stride is out of reach with the printed formula.
    assert math.sqrt(printed**2 - L0**2) < 0.8 * 226.0


def test_at_the_largest_stretch_the_leg_is_straight():
    stretch = largest_stretch(LEG, ROBOT.hip_height, ROBOT.roughness)
    foot = np.asarray(LEG.hip) + [0.0, stretch, -(ROBOT.hip_height + ROBOT.roughness)]
    _, _, knee = LEG.inverse(foot * (1.0 - 1e-12))
    assert knee == pytest.approx(0.0, abs=1e-4)


def test_the_largest_stride_is_226_mm():
    assert 1e3 * ROBOT.largest_stride == pytest.approx(226.2, abs=0.05)
    assert round(1e3 * ROBOT.largest_stride) == 226


def test_at_the_largest_stride_the_foot_is_at_the_largest_stretch():
    stretch = largest_stretch(LEG, ROBOT.hip_height, ROBOT.roughness)
    assert math.hypot(ROBOT.largest_stride, ROBOT.stance_reach) == pytest.approx(stretch)


def test_the_largest_turn_is_44_degrees():
    assert math.degrees(ROBOT.largest_turn) == pytest.approx(44.1, abs=0.05)
    assert round(math.degrees(ROBOT.largest_turn)) == 44


def test_the_chord_of_the_largest_turn_is_the_largest_stride():
    chord = 2.0 * (0.101 + 0.200) * math.sin(ROBOT.largest_turn / 2.0)
    assert chord == pytest.approx(ROBOT.largest_stride)


def test_a_stride_as_long_as_the_circle_is_wide_is_half_a_turn_and_never_more():
    assert largest_turn(0.6, 0.3) == pytest.approx(math.pi)
    assert largest_turn(5.0, 0.3) == pytest.approx(math.pi)


def test_the_mesh_is_628_mm():
    assert round(1e3 * ROBOT.mesh_size) == 628
    assert 1e3 * ROBOT.mesh_size == pytest.approx(2.0 * N + 226.2, abs=0.05)


def test_rougher_ground_shortens_the_stride():
    strides = [
        largest_stride(largest_stretch(LEG, 0.243, roughness), 0.2)
        for roughness in (0.0, 0.02, 0.045, 0.08)
    ]
    assert strides == sorted(strides, reverse=True)


def test_a_leg_that_cannot_reach_the_ground_is_refused_with_the_numbers():
    with pytest.raises(RobotModelError, match=r'leg lf is 0\.355 m long .* reach 0\.400 m down'):
        largest_stretch(LEG, 0.243, 0.2)


def test_a_leg_that_just_reaches_the_ground_stretches_to_its_offset_only():
    straight_down = 0.043 + LEG.thigh_length + LEG.calf_length
    assert largest_stretch(LEG, straight_down - 1e-12, 0.0) == pytest.approx(0.045, abs=1e-5)


def test_a_posture_beyond_the_stretch_is_refused_with_the_numbers():
    with pytest.raises(RobotModelError, match=r'0\.150 m is less than .* needs, 0\.200 m'):
        largest_stride(0.15, 0.2)
    assert largest_stride(0.2, 0.2) == 0.0


def test_the_figures_of_a_robot_follow_from_its_data():
    longer = replace(ROBOT, roughness=0.0)
    assert longer.largest_stride == pytest.approx(
        math.sqrt((math.sqrt(0.355**2 - 0.2**2) + 0.045) ** 2 - 0.2**2)
    )


dogs = pytest.mark.parametrize('name', ['cuhk', 'genibo'])


@dogs
@pytest.mark.parametrize('direction', [-1, 1])
@pytest.mark.parametrize('index', range(4))
def test_a_dogs_legs_are_straight_at_the_largest_stride_either_way(name, direction, index):
    robot = load_robot(name)
    leg = robot.legs[index]
    step = np.array([direction * robot.largest_stride, 0.0, -robot.roughness])
    foot = robot.neutral_feet[index] + step
    pitch_axis, _, _ = leg.chain(leg.inverse(foot - 1e-9 * step))
    assert np.linalg.norm(foot - pitch_axis) == pytest.approx(leg.reach()[1], abs=1e-8)


@pytest.mark.parametrize(('name', 'stride', 'turn'), [('cuhk', 68.3, 30.8), ('genibo', 64.3, 39.9)])
def test_the_figures_of_the_dogs_are_those_of_the_document(name, stride, turn):
    robot = load_robot(name)
    assert 1e3 * robot.largest_stride == pytest.approx(stride, abs=0.05)
    assert math.degrees(robot.largest_turn) == pytest.approx(turn, abs=0.05)


@dogs
def test_the_chord_of_a_dogs_largest_turn_at_its_feet_is_the_largest_stride(name):
    robot = load_robot(name)
    radius = np.linalg.norm(robot.neutral_feet[0, :2])
    chord = 2.0 * radius * math.sin(robot.largest_turn / 2.0)
    assert chord == pytest.approx(robot.largest_stride)


def test_a_foot_that_stands_off_its_pitch_axis_has_so_much_less_to_go():
    robot = load_robot('cuhk')
    leg, foot = robot.legs[0], robot.neutral_feet[0]
    for off in (-0.01, 0.01):
        less = largest_step(leg, foot + [off, 0.0, 0.0], 0.004)
        assert less == pytest.approx(robot.largest_stride - 0.01)


def test_a_dogs_leg_that_cannot_reach_the_ground_is_refused_with_the_numbers():
    robot = load_robot('cuhk')
    with pytest.raises(RobotModelError, match=r'leg lf is 0\.095 m long .* reach 0\.162 m down'):
        largest_step(robot.legs[0], robot.neutral_feet[0], 0.1)


def test_down_a_step_a_leg_reaches_a_third_of_the_largest_stride():
    # By hand, for S0's numbers [mm]: A = hypot(226.16 / 3, 200) = 213.74, and
    # sqrt(355^2 - (213.74 - 45)^2) + 43 - 243 = 112.3.
    stride = ROBOT.largest_stride / 3.0
    lower = lowest_at_stretch(LEG, 0.243, math.hypot(stride, 0.2))
    assert 1e3 * lower == pytest.approx(112.3, abs=0.05)
    assert largest_stride(largest_stretch(LEG, 0.243, lower), 0.2) == pytest.approx(stride)


@dogs
@pytest.mark.parametrize('index', range(4))
def test_down_a_step_a_dogs_leg_reaches_a_third_of_the_largest_stride(name, index):
    robot = load_robot(name)
    leg, foot = robot.legs[index], robot.neutral_feet[index]
    lower = lowest_at_step(leg, foot, robot.largest_stride / 3.0)
    assert largest_step(leg, foot, lower) == pytest.approx(robot.largest_stride / 3.0)
    assert lowest_at_step(leg, foot, robot.largest_stride) == pytest.approx(robot.roughness)


def test_a_step_is_no_higher_than_a_third_of_the_hips():
    assert largest_step_height(0.112, 0.243) == pytest.approx(0.081)
    assert largest_step_height(0.05, 0.243) == 0.05
    assert largest_step_height(-0.01, 0.243) == 0.0


# genibo by hand [mm]: its legs of 130 mm reach sqrt(130^2 - 21.4^2) = 128.2 down at a third of
# 64.3, and stand 105 below the hips: 23.2 lower. Of the others the legs reach farther.
@pytest.mark.parametrize(
    ('name', 'step'), [('titan_viii', 81.0), ('genibo', 23.2), ('cuhk', 28.0), ('pukyong', 19.2)]
)
def test_the_step_heights_of_the_robots(name, step):
    assert 1e3 * load_robot(name).step_height == pytest.approx(step, abs=0.05)


def test_a_leg_that_cannot_stretch_so_far_is_refused_with_the_numbers():
    with pytest.raises(RobotModelError, match=r'leg lf is 0\.355 m long .* reach 0\.455 m out'):
        lowest_at_stretch(LEG, 0.243, 0.5)
