"""Strides down steps, of legs whose shins would lie flat over the edge behind a foot."""

import numpy as np
import pytest

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.uneven.stride_goal import Descent

A1, GENIBO = load_robot('a1'), load_robot('genibo')
ORIGIN = Pose2D(0.0, 0.0, 0.0)
SIDE = 0.02


def ground_with_a_step(place, rise):
    """Return ground that is higher from x = place on."""
    x = np.arange(-60, 160) * SIDE
    heights = np.where(x >= place, rise, 0.0)[None, :].repeat(100, axis=0)
    return HeightMap(heights, SIDE, (-60 * SIDE, -1.0))


def shortened(robot, rise, strides_ahead=1.0, motion=None):
    motion = motion or BodyMotion(forward=robot.largest_stride)
    ahead = robot.neutral_feet[:, 0].max() + strides_ahead * robot.largest_stride
    ground = ground_with_a_step(ahead - 2 * SIDE, rise)
    return Descent(robot).shortened(motion, ORIGIN, ground), motion


@pytest.mark.parametrize('strides_ahead', [1.0, 2.0])
def test_strides_are_half_as_long_down_a_step_that_is_near(strides_ahead):
    short, motion = shortened(A1, -0.5 * A1.step_height, strides_ahead)
    assert short == motion.scaled(0.5)


@pytest.mark.parametrize(
    ('rise', 'strides_ahead'),
    [(0.5, 1.0), (0.0, 1.0), (-0.1, 1.0), (-0.5, 3.0)],
    ids=['up', 'level', 'hardly down', 'far away'],
)
def test_elsewhere_strides_are_as_long_as_they_were(rise, strides_ahead):
    short, motion = shortened(A1, rise * A1.step_height, strides_ahead)
    assert short == motion


@pytest.mark.parametrize('motion', [BodyMotion(forward=-0.2), BodyMotion(turn=0.4)])
def test_only_strides_forward_bring_hind_feet_far_below_the_body(motion):
    short, _ = shortened(A1, -0.5 * A1.step_height, motion=motion)
    assert short == motion


def test_legs_whose_hind_knees_are_ahead_of_their_feet_go_on_as_they_did():
    short, motion = shortened(GENIBO, -0.5 * GENIBO.step_height)
    assert short == motion


def test_where_no_map_shows_a_step_strides_stay_as_they_are():
    motion = BodyMotion(forward=A1.largest_stride)
    assert Descent(A1).shortened(motion, ORIGIN, None) == motion
    # Nor does a map of another place.
    away = HeightMap(np.zeros((4, 4)), SIDE, (50.0, 50.0))
    assert Descent(A1).shortened(motion, ORIGIN, away) == motion
