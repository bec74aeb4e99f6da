"""The body moves on arcs, and smoothly."""

import math

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from quad_common.planar_pose import Pose2D, Twist2D
from quad_gait.cycle.body_motion import BodyMotion, gather_speed, minimum_jerk, smooth_progress
from quad_gait.cycle.gait import available_gaits, load_gait


def random_poses(rng, count):
    bound = (0.4, 0.4, 0.999 * math.pi)
    return [Pose2D(*row) for row in rng.uniform(-np.array(bound), bound, (count, 3))]


def test_a_motion_that_reaches_a_pose_ends_in_it():
    poses = random_poses(np.random.default_rng(1), 300)
    for pose in (*poses, Pose2D(0.1, 0.2, 0.0), Pose2D(0.0, 0.0, 1.0), Pose2D(0.0, 0.0, 0.0)):
        end = BodyMotion.reaching(pose).end
        assert (end.x, end.y, end.yaw) == pytest.approx((pose.x, pose.y, pose.yaw), abs=1e-12)


def test_the_motion_to_the_end_of_a_motion_is_that_motion():
    for row in np.random.default_rng(2).uniform((-0.3, -0.3, -3.0), (0.3, 0.3, 3.0), (300, 3)):
        motion = BodyMotion(*row)
        again = BodyMotion.reaching(motion.end)
        assert (again.forward, again.left, again.turn) == pytest.approx(tuple(row), abs=1e-12)


@pytest.mark.parametrize('yaw', [math.pi, -math.pi, 3.0, 1e-9, -1e-9, 1e-160])
def test_half_a_turn_and_hardly_a_turn_are_reached_as_well(yaw):
    end = BodyMotion.reaching(Pose2D(0.1, -0.05, yaw)).end
    assert (end.x, end.y) == pytest.approx((0.1, -0.05), abs=1e-12)
    assert math.remainder(end.yaw - yaw, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize('turn', [0.3, -0.3, 1.5, -3.0])
def test_forward_motion_with_a_turn_is_an_arc_of_their_ratio(turn):
    motion = BodyMotion(forward=0.2, turn=turn)
    poses = motion.pose_at(np.linspace(0.0, 1.0, 101))
    radius = 0.2 / turn
    from_center = poses[:, :2] - [0.0, radius]
    assert np.hypot(*from_center.T) == pytest.approx(abs(radius))
    # The heading stays along the arc.
    heading = np.column_stack([np.cos(poses[:, 2]), np.sin(poses[:, 2])])
    assert np.sum(heading * from_center, axis=1) == pytest.approx(0.0, abs=1e-12)


def test_without_a_turn_the_motion_is_straight():
    fraction = np.linspace(0.0, 1.0, 11)
    poses = BodyMotion(forward=0.2, left=-0.1).pose_at(fraction)
    assert poses == pytest.approx(np.outer(fraction, [0.2, -0.1, 0.0]))


def test_a_motion_is_run_through_at_a_steady_rate_in_the_bodys_own_axes():
    rng = np.random.default_rng(3)
    fraction, h = np.linspace(0.05, 0.95, 50), 1e-6
    for forward, left, turn in rng.uniform(-0.5, 0.5, (20, 3)):
        motion = BodyMotion(forward, left, turn)
        rate = (motion.pose_at(fraction + h) - motion.pose_at(fraction - h)) / (2.0 * h)
        yaw = motion.pose_at(fraction)[:, 2]
        along = np.cos(yaw) * rate[:, 0] + np.sin(yaw) * rate[:, 1]
        across = np.cos(yaw) * rate[:, 1] - np.sin(yaw) * rate[:, 0]
        assert along == pytest.approx(forward, abs=1e-8)
        assert across == pytest.approx(left, abs=1e-8)
        assert rate[:, 2] == pytest.approx(turn, abs=1e-8)


def test_two_halves_of_a_motion_make_the_whole():
    for row in np.random.default_rng(4).uniform(-0.5, 0.5, (50, 3)):
        whole, half = BodyMotion(*row).end, BodyMotion(*(row / 2.0)).end
        both = half @ half
        assert (both.x, both.y, both.yaw) == pytest.approx((whole.x, whole.y, whole.yaw))


def test_a_velocity_for_a_time_is_a_motion_and_back():
    for row in np.random.default_rng(6).uniform(-0.5, 0.5, (50, 3)):
        twist, duration = Twist2D(*row), 3.0
        motion = BodyMotion.during(twist, duration)
        assert (motion.forward, motion.left, motion.turn) == pytest.approx(tuple(3.0 * row))
        again = motion.rate(duration)
        assert (again.forward, again.left, again.turn) == pytest.approx(tuple(row))


def test_a_scaled_motion_ends_where_that_share_of_the_motion_is():
    for row in np.random.default_rng(7).uniform(-0.5, 0.5, (50, 3)):
        end = BodyMotion(*row).scaled(0.3).end
        on_the_way = BodyMotion(*row).pose_at(np.array(0.3))
        assert (end.x, end.y, end.yaw) == pytest.approx(tuple(on_the_way), abs=1e-12)


def test_a_mirrored_motion_ends_mirrored():
    for forward, left, turn in np.random.default_rng(5).uniform(-0.5, 0.5, (50, 3)):
        end, mirrored = BodyMotion(forward, left, turn).end, BodyMotion(forward, -left, -turn).end
        assert (mirrored.x, mirrored.y, mirrored.yaw) == pytest.approx((end.x, -end.y, -end.yaw))


def test_minimum_jerk_rises_from_0_to_1_at_rest_at_both_ends():
    times = np.array([-1.0, 0.5, 1.0, 1.5, 9.0])
    value, rate = minimum_jerk(0.5, 1.5, times)
    assert value == pytest.approx([0.0, 0.0, 0.5, 1.0, 1.0])
    assert rate == pytest.approx([0.0, 0.0, 1.875, 0.0, 0.0])


def test_minimum_jerk_has_no_acceleration_at_its_ends():
    h = 1e-4
    _, rate = minimum_jerk(0.5, 1.5, np.array([0.5 + h, 1.5 - h]))
    assert rate / h == pytest.approx([0.0, 0.0], abs=0.01)


def test_minimum_jerk_is_the_polynomial_whose_sixth_derivative_is_zero():
    value, _ = minimum_jerk(0.0, 1.0, np.linspace(0.0, 1.0, 30))
    fit = np.polynomial.Polynomial.fit(np.linspace(0.0, 1.0, 30), value, 7).convert()
    assert fit.coef == pytest.approx([0, 0, 0, 10, -15, 6, 0, 0], abs=1e-8)


def test_the_rate_of_minimum_jerk_is_its_derivative():
    times, h = np.linspace(0.0, 3.0, 301), 1e-6
    up, down = (minimum_jerk(0.7, 2.2, times + step)[0] for step in (h, -h))
    assert minimum_jerk(0.7, 2.2, times)[1] == pytest.approx((up - down) / (2.0 * h), abs=1e-5)


def test_gathering_speed_changes_the_speed_at_the_start_and_nothing_else():
    value, rate = gather_speed(2.0, np.array([0.0, 2.0]))
    assert value == pytest.approx([0.0, 0.0], abs=1e-12)
    assert rate == pytest.approx([1.0, 0.0], abs=1e-12)
    h = 1e-5
    _, rate = gather_speed(2.0, np.array([0.0, h, 2.0 - h, 2.0]))
    assert np.diff(rate)[[0, 2]] / h == pytest.approx([0.0, 0.0], abs=1e-3)


def test_the_rate_of_gathering_speed_is_its_derivative_at_any_duration():
    for duration in (0.4, 1.0, 5.0):
        times, h = np.linspace(0.0, duration, 101), 1e-6
        up, down = (gather_speed(duration, times + step)[0] for step in (h, -h))
        assert gather_speed(duration, times)[1] == pytest.approx((up - down) / (2 * h), abs=1e-6)


KNOTS = [p for name in available_gaits() if (p := load_gait(name).body_progress) is not None]
KNOTS.append(((1.0, 0.0), (2.0, 0.25), (3.0, 0.5), (4.0, 0.75), (5.0, 1.0)))
KNOTS.append(((0.5, 0.0), (1.0, 0.0), (1.1, 0.9), (3.0, 1.0)))

each_progress = pytest.mark.parametrize('knots', KNOTS)


@each_progress
def test_progress_passes_its_knots(knots):
    t, values = (np.array(column) for column in zip(*knots))
    assert smooth_progress(knots, t)[0] == pytest.approx(values, abs=1e-12)


@each_progress
def test_progress_never_goes_back_and_stays_within_0_and_1(knots):
    value, rate = smooth_progress(knots, np.linspace(0.0, 6.0, 3001))
    assert (np.diff(value) >= -1e-12).all()
    assert (rate >= -1e-12).all()
    assert (value.min(), value.max()) == pytest.approx((0.0, 1.0))


@each_progress
def test_before_and_after_its_knots_progress_is_at_rest(knots):
    t = [time for time, _ in knots]
    value, rate = smooth_progress(knots, np.array([0.0, t[0], t[-1], 6.0]))
    assert value == pytest.approx([0.0, 0.0, 1.0, 1.0], abs=1e-12)
    assert rate == pytest.approx(np.zeros(4), abs=1e-12)


@each_progress
def test_the_rate_of_progress_is_its_derivative_and_continuous(knots):
    times, h = np.linspace(0.0, 5.5, 2203), 1e-6
    up, down = (smooth_progress(knots, times + step)[0] for step in (h, -h))
    rate = smooth_progress(knots, times)[1]
    assert rate == pytest.approx((up - down) / (2.0 * h), abs=1e-4)
    steepest = np.abs(np.diff(rate)).max() / rate.max()
    assert steepest < 0.1


@pytest.mark.parametrize('seed', range(5))
def test_curves_through_knots_are_those_of_scipy_to_the_last_bit(seed):
    rng = np.random.default_rng(seed)
    for count in range(2, 9):
        t, values = np.sort(rng.uniform(0.0, 5.0, (2, count)))
        # Level, falling and turning pieces too.
        values = rng.permutation(np.round(values, seed))
        times = np.concatenate([t, rng.uniform(t[0], t[-1], 100)])
        ends = [t[0] - 1.0], [t[-1] + 1.0]
        curve = PchipInterpolator(
            np.concatenate([ends[0], t, ends[1]]), np.pad(values, 1, mode='edge')
        )
        value, rate = smooth_progress(tuple(zip(t, values)), times)
        np.testing.assert_array_equal(value, curve(times))
        np.testing.assert_array_equal(rate, curve(times, 1))
