"""What is given out of a motion is nowhere faster than the motion itself."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.uneven.joint_motion import JointMotion, braking_time

ROBOT = load_robot('titan_viii')
FASTEST = np.full(12, 3.2)


def steady_motion(speed, given, samples=30, period=0.02):
    """All joints turn at one speed and, at the end, rest."""
    times = np.arange(samples) * period
    positions = ROBOT.initial_joint_angles + speed * times[:, None, None]
    velocities = np.full((samples, 4, 3), speed)
    velocities[0] = velocities[-1] = 0.0
    return JointMotion(
        ROBOT.joint_names, times, positions, velocities, FASTEST, 0.0, given, since=2
    )


@pytest.mark.parametrize('given', [6, 12, 28, 29])
def test_a_motion_that_is_cut_short_comes_to_rest_within_the_joints_speed(given):
    trajectory = steady_motion(3.0, given).trajectory(reaction_time=0.06)
    spline = CubicHermiteSpline(trajectory.times, trajectory.positions, trajectory.velocities)
    dense = np.linspace(trajectory.times[0], trajectory.times[-1], 2000)
    assert np.abs(spline.derivative()(dense)).max() <= 3.2 + 1e-9
    assert np.array_equal(trajectory.velocities[-1], np.zeros(12))


def test_a_motion_that_comes_to_rest_by_itself_keeps_its_times():
    times = np.arange(30) * 0.02
    fraction, rate = minimum_jerk(0.0, float(times[-1]), times)
    positions = ROBOT.initial_joint_angles + fraction[:, None, None]
    velocities = np.broadcast_to(rate[:, None, None], positions.shape)
    motion = JointMotion(ROBOT.joint_names, times, positions, velocities, FASTEST, 0.0, 29, since=2)
    assert motion.trajectory(reaction_time=0.06).times == pytest.approx(0.02 + times[2:])


def test_joints_brake_in_the_shortest_time_that_their_speed_allows():
    rng = np.random.default_rng(0)
    for _ in range(300):
        displacement, velocity, fastest = rng.uniform(0.01, 0.3), rng.uniform(-3.0, 3.0), 3.2
        time = braking_time(np.array([displacement]), np.array([velocity]), np.array([fastest]))
        for longer, holds in ((1.0 + 1e-9, True), (0.97, False)):
            spline = CubicHermiteSpline([0.0, time * longer], [0.0, displacement], [velocity, 0.0])
            peak = spline.derivative()(np.linspace(0.0, time * longer, 4000)).max()
            assert (peak <= fastest + 1e-6) == holds
