"""What is given out of a motion is nowhere faster than the motion itself."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from quad_common.robot import load_robot
from quad_gait.body_motion import minimum_jerk
from quad_gait.joint_motion import JointMotion

ROBOT = load_robot('titan_viii')


def steady_motion(speed, given, samples=30, period=0.02):
    """All joints turn at one speed and, at the end, rest."""
    times = np.arange(samples) * period
    positions = ROBOT.initial_joint_angles + speed * times[:, None, None]
    velocities = np.full((samples, 4, 3), speed)
    velocities[0] = velocities[-1] = 0.0
    return JointMotion(ROBOT.joint_names, times, positions, velocities, 0.0, given, since=2)


@pytest.mark.parametrize('given', [6, 12, 28, 29])
def test_a_motion_that_is_cut_short_comes_to_rest_without_exceeding_its_speed(given):
    trajectory = steady_motion(3.0, given).trajectory(reaction_time=0.06)
    spline = CubicHermiteSpline(trajectory.times, trajectory.positions, trajectory.velocities)
    dense = np.linspace(trajectory.times[0], trajectory.times[-1], 2000)
    assert np.abs(spline.derivative()(dense)).max() <= 3.0 + 1e-9
    assert np.array_equal(trajectory.velocities[-1], np.zeros(12))


def test_a_motion_that_comes_to_rest_by_itself_keeps_its_times():
    times = np.arange(30) * 0.02
    share, rate = minimum_jerk(0.0, float(times[-1]), times)
    positions = ROBOT.initial_joint_angles + share[:, None, None]
    velocities = np.broadcast_to(rate[:, None, None], positions.shape)
    motion = JointMotion(ROBOT.joint_names, times, positions, velocities, 0.0, 29, since=2)
    assert motion.trajectory(reaction_time=0.06).times == pytest.approx(0.02 + times[2:])
