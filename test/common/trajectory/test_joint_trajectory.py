"""A joint trajectory is whole, finite and ordered in time, or it is refused."""

import math

import numpy as np
import pytest

from quad_common.errors import TrajectoryError
from quad_common.trajectory.joint_trajectory import JointTrajectory


def trajectory(names=('a', 'b'), stamp=2.0, times=(0.0, 0.5, 1.0), positions=None, velocities=None):
    shape = (len(times), len(names))
    return JointTrajectory(
        joint_names=tuple(names),
        stamp=stamp,
        times=np.array(times, dtype=float),
        positions=np.zeros(shape) if positions is None else np.array(positions, dtype=float),
        velocities=np.zeros(shape) if velocities is None else np.array(velocities, dtype=float),
    )


def test_it_ends_with_its_last_point():
    assert trajectory().end == 3.0
    assert trajectory(stamp=0.0, times=(0.25,)).end == 0.25


def test_a_single_point_is_enough():
    assert trajectory(names=('a',), times=(0.0,)).positions.shape == (1, 1)


def test_the_first_point_may_be_later_than_the_stamp():
    assert trajectory(times=(0.6, 0.7)).times[0] == 0.6


@pytest.mark.parametrize('names', [(), ('a',)])
def test_without_points_or_joints_there_is_no_trajectory(names):
    times = () if names else (0.0, 1.0)
    with pytest.raises(TrajectoryError, match='it needs at least one'):
        trajectory(names=names, times=times)


def test_a_joint_named_twice_is_refused():
    with pytest.raises(TrajectoryError, match='names a joint twice'):
        trajectory(names=('a', 'b', 'a'))


@pytest.mark.parametrize('what', ['positions', 'velocities'])
@pytest.mark.parametrize('shape', [(2, 2), (3, 3), (3, 1), (6,), (0, 2)])
def test_sizes_that_disagree_are_told(what, shape):
    with pytest.raises(TrajectoryError) as caught:
        trajectory(**{what: np.zeros(shape)})
    assert str(caught.value) == (
        f'the trajectory has {what} of shape {shape}; 3 points of 2 joints need (3, 2)'
    )


@pytest.mark.parametrize('what', ['positions', 'velocities'])
@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_numbers_that_are_not_finite_are_refused(what, bad):
    values = np.zeros((3, 2))
    values[1, 1] = bad
    with pytest.raises(TrajectoryError, match=f'has {what} that are not finite'):
        trajectory(**{what: values})


@pytest.mark.parametrize('times', [(0.0, math.nan, 1.0), (0.0, 0.5, math.inf)])
def test_times_that_are_not_finite_are_refused(times):
    with pytest.raises(TrajectoryError, match='times that are not finite'):
        trajectory(times=times)


@pytest.mark.parametrize('stamp', [math.nan, math.inf])
def test_a_stamp_that_is_not_finite_is_refused(stamp):
    with pytest.raises(TrajectoryError, match='times that are not finite'):
        trajectory(stamp=stamp)


@pytest.mark.parametrize('times', [(0.0, 1.0, 1.0), (0.0, 1.0, 0.5), (-0.1, 0.5, 1.0)])
def test_times_must_rise_from_zero_or_later(times):
    with pytest.raises(TrajectoryError, match='must rise, from zero or later'):
        trajectory(times=times)
