"""Where shins are while feet stand, wherever they were put."""

from __future__ import annotations

import numpy as np
import pytest

from quad_common.footing.shin import leaning_shin, shin_points
from quad_common.robot_files.robot_file import load_robot


@pytest.mark.parametrize('leg', range(4))
@pytest.mark.parametrize('name', ['titan_viii', 'genibo', 'a1'])
def test_a_shin_leans_as_inverse_kinematics_has_it_where_its_foot_is_put_aside(name, leg):
    robot = load_robot(name)
    stride = 0.3 * robot.largest_stride * np.array([0.8, 0.6])
    shin = leaning_shin(robot, leg, stride, 0.7)
    assert shin.points == pytest.approx(shin_points(robot, leg, stride, 0.7), abs=1e-12)
    aside = 0.03 * robot.relative_size * np.array([[1.0, 0.0], [0.0, -1.0], [-0.6, 0.8]])
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s], [s, c]])
    for offset, moved in zip(aside, shin.beside(aside)):
        # The body stays where it was: it is as far beside the foot, the other way.
        sway = leaning_shin(robot, leg, np.zeros(2), 0.7, -np.array([[*(offset @ turn), 0.0]]))
        # Of a body that does not go on all postures are the same.
        still = leaning_shin(robot, leg, np.zeros(2), 0.7).beside(offset[None])[0]
        assert still[:8] == pytest.approx(sway.points[:8], abs=0.002 * robot.relative_size)
        assert np.isfinite(moved).all()


def test_a_foot_that_is_put_aside_is_followed_by_its_knee_in_part():
    robot = load_robot('titan_viii')
    rates = leaning_shin(robot, 0, np.zeros(2), 0.0).rates
    assert rates[0] == pytest.approx(0.0, abs=0.1)
    highest = rates[7, :2]
    assert (np.diag(highest) > -1.0).all()
    assert (np.diag(highest) < 0.01).all()
    assert np.diag(highest).min() < -0.1


def test_postures_beyond_a_leg_s_reach_are_left_out():
    robot = load_robot('genibo')
    near = leaning_shin(robot, 0, np.zeros(2), 0.0)
    far = leaning_shin(robot, 0, np.array([0.15, 0.0]), 0.0)
    assert 0 < len(far.points) < len(near.points)
    assert np.isfinite(far.rates).all()
