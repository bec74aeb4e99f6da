"""The body goes from one support to the next as fast as does not rock it."""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.state.body_placement import BodyPose
from quad_gait.state.stance import Stance
from quad_gait.uneven.body_pace import BodyPace
from quad_gait.uneven.uneven_options import UnevenOptions

GRAVITY = 9.81


def standing_on(robot, feet, x=0.0):
    """Return a robot that stands level on feet (4, 3), its center of mass at an x [m]."""
    center = robot.center_of_mass(robot.initial_joint_angles)
    level = BodyPose(np.array([x - center[0], -center[1], 0.0]), 0.0, 0.0, 0.0)
    return Stance(0.0, level, feet, robot.initial_joint_angles, lambda: None)


def moved_by(stance, x=0.0, y=0.0):
    """Return the pose of the body so much farther on [m]."""
    return BodyPose(stance.body.position + np.array([x, y, 0.0]), 0.0, 0.0, 0.0)


def height_of(robot):
    return robot.center_of_mass(robot.initial_joint_angles)[2] + robot.standing_height


def zero_moment_points(height, start, end, duration):
    """Return them during a motion of the center of mass along x, shape (n,) [m]."""
    times = np.linspace(0.0, duration, 2001)
    progress, speed = minimum_jerk(0.0, duration, times)
    places = start + (end - start) * progress
    return places - height / GRAVITY * (end - start) * np.gradient(speed, times)


@pytest.mark.parametrize('name', ['titan_viii', 'genibo', 'cuhk', 'pukyong', 'a1'])
def test_a_body_goes_over_three_feet_without_rocking(name):
    """Of a tall and narrow robot the zero moment point left a third of the support."""
    robot, options = load_robot(name), UnevenOptions()
    stance = standing_on(robot, robot.neutral_feet)
    height = height_of(robot)
    width = 2.0 * robot.neutral_feet[0, 1]
    scale = robot.relative_size
    pace = BodyPace(robot, options)
    # Within the feet, where there is room before the motion and behind it.
    for distance in np.linspace(0.005, 0.2, 30) * width:
        duration = pace.duration(stance, moved_by(stance, y=distance))
        usual = max(options.shift_time, distance / (scale * options.shift_speed))
        assert duration >= usual
        if name != 'a1':
            # Low and wide ones have always been slow enough.
            assert duration == usual
        s = np.linspace(0.0, 1.0, 1001)
        acceleration = distance * (60.0 * s - 180.0 * s**2 + 120.0 * s**3) / duration**2
        sway = height * np.abs(acceleration).max() / GRAVITY
        assert sway <= 0.1301 * width


@pytest.mark.parametrize('name', ['titan_viii', 'genibo', 'a1'])
@pytest.mark.parametrize('room', [0.1, 0.2, 0.4])
@pytest.mark.parametrize('is_backward', [False, True])
def test_where_feet_leave_little_room_the_body_goes_so_slowly_that_it_does_not_tip_over(
    name, room, is_backward
):
    # TITAN-VIII went back over three feet, 0.1 m in 0.4 s with 46 mm behind it, and fell.
    robot, options = load_robot(name), UnevenOptions()
    reach = 2.0 * robot.neutral_feet[0, 0]
    feet = robot.neutral_feet.copy()
    # Both pairs are so far from where the body is, or is to be.
    start, end = 0.25 * reach, -0.25 * reach
    feet[:2, 0], feet[2:, 0] = start + room * reach, end - room * reach
    if is_backward:
        start, end = end, start
    stance = standing_on(robot, feet, start)
    duration = BodyPace(robot, options).duration(stance, moved_by(stance, x=end - start))
    points = zero_moment_points(height_of(robot), start, end, duration)
    within = 0.5 * room * reach
    low, high = min(start, end) - within, max(start, end) + within
    if duration < 1.5:
        assert low - 1e-3 <= points.min()
        assert points.max() <= high + 1e-3
    assert feet[2, 0] < points.min()
    assert points.max() < feet[0, 0]


def test_where_there_is_no_room_the_body_does_not_take_for_ever():
    robot, options = load_robot('titan_viii'), UnevenOptions()
    pace = BodyPace(robot, options)
    outside = standing_on(robot, robot.neutral_feet, 0.5)
    for x, most in ((0.1, 1.5), (0.5, 2.5)):
        assert 0.4 < pace.duration(outside, moved_by(outside, x=x)) <= most
