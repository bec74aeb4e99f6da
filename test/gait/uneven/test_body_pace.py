"""The body goes from one support to the next as fast as does not rock it."""

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_gait.state.body_placement import BodyPose
from quad_gait.uneven.body_pace import BodyPace
from quad_gait.uneven.uneven_options import UnevenOptions

GRAVITY = 9.81


@pytest.mark.parametrize('name', ['titan_viii', 'genibo', 'cuhk', 'pukyong', 'a1'])
def test_a_body_goes_over_three_feet_without_rocking(name):
    """Of a tall and narrow robot the zero moment point left a third of the support."""
    robot, options = load_robot(name), UnevenOptions()
    level = BodyPose(np.zeros(3), 0.0, 0.0, 0.0)
    height = robot.center_of_mass(robot.initial_joint_angles)[2] + robot.standing_height
    width = 2.0 * robot.neutral_feet[0, 1]
    scale = robot.relative_size
    pace = BodyPace(robot, options)
    for distance in np.linspace(0.005, 0.5, 30) * width:
        to = BodyPose(np.array([0.0, distance, 0.0]), 0.0, 0.0, 0.0)
        duration = pace.duration(level, to)
        usual = max(options.shift_time, distance / (scale * options.shift_speed))
        assert duration >= usual
        if name != 'a1':
            # Low and wide ones have always been slow enough.
            assert duration == usual
        s = np.linspace(0.0, 1.0, 1001)
        acceleration = distance * (60.0 * s - 180.0 * s**2 + 120.0 * s**3) / duration**2
        sway = height * np.abs(acceleration).max() / GRAVITY
        assert sway <= 0.1301 * width
