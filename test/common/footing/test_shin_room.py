"""Shins over a map of the ground, wherever body and feet are."""

import numpy as np
import pytest

from quad_common.errors import ShinTooNear
from quad_common.footing.shin_room import ShinRoom
from quad_common.maps.height_map import HeightMap
from quad_common.robot_files.robot_file import load_robot
from quad_common.rotations import matrix_from_angles

ROBOT = load_robot('titan_viii')
LEVEL = HeightMap.level((-1.5, -1.5, 1.5, 1.5), 0.02)
ATTITUDE = matrix_from_angles(np.array([0.05, -0.08, 0.7]))
PLACE = np.array([0.2, -0.1, -ROBOT.neutral_feet[0, 2] + ROBOT.foot_radius])


def placed():
    """A robot at a tilt and a heading, its feet in the initial posture."""
    feet = PLACE + ROBOT.neutral_feet @ ATTITUDE.T
    return PLACE[None], ATTITUDE[None], feet[None]


def test_points_go_from_the_feet_to_the_knees():
    room = ShinRoom(ROBOT, 0.01, LEVEL)
    position, rotation, feet = placed()
    points = room.points(position, rotation, feet)[0]
    assert points[:, 0] == pytest.approx(feet[0])
    for leg in range(4):
        kinematics = ROBOT.legs[leg]
        knee = kinematics.chain(kinematics.inverse(ROBOT.neutral_feet[leg]))[1]
        assert points[leg, -1] == pytest.approx(PLACE + ATTITUDE @ knee)


@pytest.mark.parametrize('leg', range(4))
def test_ground_as_high_as_a_knee_touches_its_shin_alone(leg):
    room = ShinRoom(ROBOT, 0.01, LEVEL)
    points = room.points(*placed())
    knee = points[0, leg, -1]
    heights = LEVEL.heights - 1.0
    column, row = np.floor((knee[:2] - LEVEL.origin) / LEVEL.resolution).astype(int)
    heights[row, column] = knee[2] + 0.01
    post = LEVEL.with_heights(heights)
    touched = ShinRoom(ROBOT, 0.01, post).touched(points)
    assert touched.tolist() == [[other == leg for other in range(4)]]
    assert not ShinRoom(ROBOT, 0.01, post, shift=-0.5).touched(points).any()


def test_neither_what_is_beyond_reach_nor_what_is_not_known_touches():
    room = ShinRoom(ROBOT, 0.01, LEVEL.with_heights(LEVEL.heights + 1.0))
    position, rotation, feet = placed()
    assert room.touched(room.points(position, rotation, feet)).all()
    feet[0, 1] += ATTITUDE @ [0.0, -1.0, 0.0]
    points = room.points(position, rotation, feet)
    assert np.isnan(points[0, 1]).all()
    assert room.touched(points).tolist() == [[True, False, True, True]]
    unknown = LEVEL.with_heights(np.full_like(LEVEL.heights, np.nan))
    assert not ShinRoom(ROBOT, 0.01, unknown).touched(points).any()


def test_the_first_leg_whose_shin_touches_in_a_stance_is_named():
    (position,), (rotation,), (feet,) = placed()
    points = ShinRoom(ROBOT, 0.01, LEVEL).points(position[None], rotation[None], feet[None])
    knee = points[0, 2, -1]
    near = np.hypot(*np.moveaxis(LEVEL.centers - knee[:2], -1, 0)) < 0.03
    post = LEVEL.with_heights(np.where(near, knee[2], -1.0))
    room = ShinRoom(ROBOT, 0.01, post)
    with pytest.raises(ShinTooNear, match='shin of lh would come too near'):
        room.check(position, rotation, feet[None])
    # As the body is higher, or nowhere near.
    room.check(position + [0.0, 0.0, 0.2], rotation, feet[None] + [0.0, 0.0, 0.2])
    aside = feet + [0.5, 0.0, 0.0]
    room.check(position + [0.5, 0.0, 0.0], rotation, aside[None])
    with pytest.raises(ShinTooNear):
        room.check(position, rotation, np.stack([aside, feet]))
