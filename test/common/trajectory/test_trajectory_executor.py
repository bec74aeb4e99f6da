"""Trajectories are executed as ros2_control's joint_trajectory_controller does it."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from quad_common.errors import JointNotFound, TrajectoryError
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor

NAMES = ('a', 'b', 'c')
HELD = np.array([0.1, 0.2, 0.3])


def make_executor():
    return TrajectoryExecutor(NAMES, HELD)


def random_trajectory(rng, stamp=10.0, points=6, names=NAMES, first=0.0):
    times = first + np.concatenate([[0.0], np.cumsum(rng.uniform(0.05, 0.3, points - 1))])
    shape = (points, len(names))
    return JointTrajectory(names, stamp, times, rng.normal(size=shape), rng.normal(size=shape))


def follow(executor, times):
    """Commands at each of some times, as (positions, velocities)."""
    positions, velocities = zip(*(executor.command(time) for time in times))
    return np.array(positions), np.array(velocities)


def test_without_a_trajectory_the_joints_hold():
    executor = make_executor()
    for time in (0.0, 5.0, 1e6):
        position, velocity = executor.command(time)
        assert (position == HELD).all()
        assert (velocity == 0.0).all()


def test_between_points_the_joints_follow_cubic_hermite_splines():
    rng = np.random.default_rng(1)
    for _ in range(10):
        trajectory = random_trajectory(rng)
        executor = make_executor()
        executor.accept(trajectory, now=10.0)
        spline = CubicHermiteSpline(
            10.0 + trajectory.times, trajectory.positions, trajectory.velocities
        )
        times = np.linspace(10.0, trajectory.end - 1e-9, 200)
        positions, velocities = follow(executor, times)
        assert positions == pytest.approx(spline(times), abs=1e-12)
        assert velocities == pytest.approx(spline(times, 1), abs=1e-10)


def test_every_point_is_passed_at_its_time_with_its_velocity():
    trajectory = random_trajectory(np.random.default_rng(2))
    executor = make_executor()
    executor.accept(trajectory, now=10.0)
    positions, velocities = follow(executor, 10.0 + trajectory.times[:-1])
    assert positions == pytest.approx(trajectory.positions[:-1])
    assert velocities == pytest.approx(trajectory.velocities[:-1])


def test_commanded_velocities_are_the_derivative_of_commanded_positions():
    trajectory = random_trajectory(np.random.default_rng(3), first=0.5)
    executor = make_executor()
    executor.accept(trajectory, now=10.0)
    times, h = np.linspace(10.001, trajectory.end - 0.001, 300), 1e-6
    ahead, _ = follow(executor, times + h)
    behind, _ = follow(executor, times - h)
    _, velocities = follow(executor, times)
    assert velocities == pytest.approx((ahead - behind) / (2.0 * h), abs=1e-4)


def test_after_the_last_point_the_joints_hold_it_at_rest():
    trajectory = random_trajectory(np.random.default_rng(4))
    executor = make_executor()
    executor.accept(trajectory, now=10.0)
    assert executor.end == trajectory.end
    for time in (trajectory.end, trajectory.end + 100.0):
        position, velocity = executor.command(time)
        assert (position == trajectory.positions[-1]).all()
        assert (velocity == 0.0).all()


def test_joints_are_matched_by_name_whatever_their_order():
    rng = np.random.default_rng(5)
    trajectory = random_trajectory(rng)
    times = np.linspace(10.0, trajectory.end + 0.1, 50)
    straight = make_executor()
    straight.accept(trajectory, now=10.0)
    for _ in range(5):
        order = rng.permutation(3)
        permuted = make_executor()
        permuted.accept(
            JointTrajectory(
                tuple(NAMES[k] for k in order),
                trajectory.stamp,
                trajectory.times,
                trajectory.positions[:, order],
                trajectory.velocities[:, order],
            ),
            now=10.0,
        )
        for one, other in zip(follow(straight, times), follow(permuted, times)):
            assert (one == other).all()


def test_until_the_first_point_the_joints_go_there_from_where_they_are():
    trajectory = random_trajectory(np.random.default_rng(6), first=0.6)
    executor = make_executor()
    executor.accept(trajectory, now=9.0)
    bridge = CubicHermiteSpline(
        [9.0, 10.6],
        np.vstack([HELD, trajectory.positions[0]]),
        np.vstack([np.zeros(3), trajectory.velocities[0]]),
    )
    times = np.linspace(9.0, 10.5999, 50)
    positions, velocities = follow(executor, times)
    assert positions == pytest.approx(bridge(times), abs=1e-12)
    assert velocities == pytest.approx(bridge(times, 1), abs=1e-12)


def test_a_new_trajectory_replaces_the_old_one_without_a_jump():
    rng = np.random.default_rng(7)
    executor = make_executor()
    executor.accept(random_trajectory(rng), now=10.0)
    before = executor.command(10.3)
    new = random_trajectory(rng, stamp=10.5)
    executor.accept(new, now=10.3)
    for one, other in zip(before, executor.command(10.3)):
        assert other == pytest.approx(one, abs=1e-12)
    assert executor.command(10.5)[0] == pytest.approx(new.positions[0])
    assert executor.end == new.end


def test_a_trajectory_that_has_begun_is_joined_where_it_is_by_now():
    trajectory = random_trajectory(np.random.default_rng(8))
    on_time, late = make_executor(), make_executor()
    on_time.accept(trajectory, now=10.0)
    late.accept(trajectory, now=10.25)
    times = np.linspace(10.25, trajectory.end, 40)
    for one, other in zip(follow(on_time, times), follow(late, times)):
        assert (one == other).all()


def test_a_stamp_of_zero_means_on_arrival():
    trajectory = random_trajectory(np.random.default_rng(9), stamp=0.0)
    executor = make_executor()
    executor.accept(trajectory, now=3.0)
    assert executor.command(3.0)[0] == pytest.approx(trajectory.positions[0])
    assert executor.end == pytest.approx(3.0 + trajectory.times[-1])


@pytest.mark.parametrize('late', [0.0, 0.5])
def test_a_trajectory_that_has_ended_is_refused_and_the_last_one_stays(late):
    trajectory = random_trajectory(np.random.default_rng(10))
    executor = make_executor()
    end = trajectory.end
    with pytest.raises(TrajectoryError, match=rf'ended at {end:.3f} s, {late:.3f} s ago'):
        executor.accept(trajectory, now=end + late)
    assert (executor.command(end + late)[0] == HELD).all()


def test_a_trajectory_that_leaves_out_joints_is_refused_with_their_names():
    executor = make_executor()
    with pytest.raises(TrajectoryError, match='leaves out a, c'):
        executor.accept(random_trajectory(np.random.default_rng(11), names=('b',)), now=10.0)
    assert (executor.command(11.0)[0] == HELD).all()


def test_a_joint_that_does_not_exist_is_refused_with_those_that_do():
    executor = make_executor()
    trajectory = random_trajectory(np.random.default_rng(12), names=('a', 'b', 'c', 'tail'))
    with pytest.raises(JointNotFound, match="no joint 'tail'; available: a, b, c"):
        executor.accept(trajectory, now=10.0)
    assert (executor.command(11.0)[0] == HELD).all()


def test_holding_drops_the_trajectory():
    executor = make_executor()
    executor.accept(random_trajectory(np.random.default_rng(13)), now=10.0)
    executor.hold(np.ones(3))
    for time in (10.1, 20.0):
        position, velocity = executor.command(time)
        assert (position == 1.0).all()
        assert (velocity == 0.0).all()


def test_the_command_depends_on_the_time_alone_and_not_on_what_was_asked_before():
    trajectory = random_trajectory(np.random.default_rng(14), points=20)
    executor, other = make_executor(), make_executor()
    executor.accept(trajectory, now=10.0)
    other.accept(trajectory, now=10.0)
    times = np.linspace(10.0, trajectory.end + 0.5, 100)
    forward = follow(executor, times)
    backward = follow(other, times[::-1])
    for one, another in zip(forward, backward):
        assert (one == another[::-1]).all()


def test_a_single_point_is_a_goal_to_go_to():
    executor = make_executor()
    goal = JointTrajectory(NAMES, 10.0, np.array([2.0]), np.ones((1, 3)), np.zeros((1, 3)))
    executor.accept(goal, now=10.0)
    assert executor.command(11.0)[0] == pytest.approx((HELD + 1.0) / 2.0)
    assert executor.command(12.0)[0] == pytest.approx(np.ones(3))
