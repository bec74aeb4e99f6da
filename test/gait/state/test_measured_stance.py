"""Where feet are, from one measurement to another."""

from __future__ import annotations

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.state.stance import Stance

TITAN = load_robot('titan_viii')
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])


def standing(feet, pose):
    """A robot whose feet are at places in its body frame, shape (4, 3) [m]."""
    return Stance.measured(TITAN, 0.0, pose, LEVEL, TITAN.joint_angles(feet).reshape(-1), None)


@pytest.mark.parametrize('leg', range(4))
@pytest.mark.parametrize('lower', [0.0, 0.03, -0.02])
def test_a_place_on_which_a_foot_stood_stays_on_the_ground_while_the_body_moves(leg, lower):
    feet = TITAN.neutral_feet + np.array([[0.0, 0.0, 0.01 * k] for k in range(4)])
    before = standing(feet, Pose2D(1.0, 2.0, 0.3))
    # The body is lower and farther on; the foot hangs, another one has given way a little.
    moved = feet + np.array([-0.04, 0.02, lower])
    moved[leg, 2] += 0.05
    moved[(leg + 1) % 4, 2] -= 0.004
    later = standing(moved, Pose2D(1.0, 2.0, 0.3) @ Pose2D(0.04, -0.02, 0.0))
    place = before.place_in(later, leg)
    assert place[:2] == pytest.approx(before.feet[leg, :2])
    assert place[2] == pytest.approx(later.feet[leg, 2] - 0.05)
    assert place[2] == pytest.approx(before.feet[leg, 2] + lower)
