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


def test_a_motion_that_never_began_is_given_out_again_from_where_the_joints_are():
    motion = steady_motion(1.0, given=29)
    rest = motion.positions[2]
    after = 0.58 + 1.1
    for repeats in (1, 2):
        waiting = motion.followed(after, rest)
        assert waiting.repeated(after - 0.2, rest, 0.06) is None
        motion = waiting.repeated(after, rest, 0.06)
        assert (motion.repeats, motion.given, motion.since) == (repeats, 29, 2)
        assert motion.trajectory(0.06).positions[0] == pytest.approx(rest.reshape(-1))
        after += 0.06 + 0.54 + 1.1
    # Something holds the joints: it goes on without them.
    lost = motion.followed(after, rest)
    assert lost.repeated(after, rest, 0.06) is None
    assert lost.is_done


def test_a_motion_that_is_late_is_not_given_out_twice():
    motion = steady_motion(1.0, given=29)
    late = motion.followed(1.4, motion.positions[15])
    assert late.repeated(1.4, motion.positions[15], 0.06) is None
    near = motion.positions[29] + 0.02
    assert motion.followed(1.7, near).repeated(1.7, near, 0.06) is None


@pytest.mark.parametrize('joint', [0, 4, 11])
def test_a_motion_that_all_joints_but_one_made_is_over_and_not_given_out_again(joint):
    motion = steady_motion(0.5, given=20)
    joints = motion.positions[20].copy()
    joints.flat[joint] = motion.positions[0].flat[joint]
    motion = motion.followed(1.0, joints)
    after = motion.end + 1.1
    assert motion.repeated(after, joints, 0.06) is None
    assert motion.followed(after, joints).done == 20
