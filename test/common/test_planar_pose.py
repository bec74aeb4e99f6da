"""Poses in the plane are the group SE(2), and headings live on a circle."""

import itertools
import math

import numpy as np
import pytest

from quad_common.planar_pose import (
    STILL,
    Pose2D,
    Twist2D,
    distance_aside,
    distance_to_polyline,
    distances_to_polyline,
    wrap_angle,
)

IDENTITY = Pose2D(0.0, 0.0, 0.0)


def random_poses(rng, count):
    return [Pose2D(*row) for row in rng.uniform((-5, -5, -math.pi), (5, 5, math.pi), (count, 3))]


def matrix(pose):
    c, s = math.cos(pose.yaw), math.sin(pose.yaw)
    return np.array([[c, -s, pose.x], [s, c, pose.y], [0.0, 0.0, 1.0]])


def assert_same(a, b):
    assert matrix(a) == pytest.approx(matrix(b), abs=1e-12)


def test_composition_is_the_product_of_homogeneous_matrices():
    rng = np.random.default_rng(1)
    for a, b in zip(random_poses(rng, 100), random_poses(rng, 100)):
        assert matrix(a @ b) == pytest.approx(matrix(a) @ matrix(b), abs=1e-12)


def test_composition_is_associative():
    rng = np.random.default_rng(2)
    for a, b, c in zip(*(random_poses(rng, 100) for _ in range(3))):
        assert_same((a @ b) @ c, a @ (b @ c))


def test_the_identity_changes_nothing():
    for pose in random_poses(np.random.default_rng(3), 20):
        assert_same(pose @ IDENTITY, pose)
        assert_same(IDENTITY @ pose, pose)


def test_a_pose_and_its_inverse_cancel_on_both_sides():
    poses = random_poses(np.random.default_rng(4), 100)
    for pose in (*poses, Pose2D(1.0, 2.0, -math.pi), Pose2D(1.0, 2.0, math.pi)):
        assert_same(pose @ pose.inverse(), IDENTITY)
        assert_same(pose.inverse() @ pose, IDENTITY)
        assert_same(pose.inverse().inverse(), pose)


def test_transforming_by_a_product_is_transforming_twice():
    rng = np.random.default_rng(5)
    points = rng.uniform(-2.0, 2.0, (4, 7, 3))
    for a, b in zip(random_poses(rng, 20), random_poses(rng, 20)):
        moved = (a @ b).transform(points)
        assert moved == pytest.approx(a.transform(b.transform(points)), abs=1e-12)
        assert (moved[..., 2] == points[..., 2]).all()


def test_a_transformation_keeps_distances_and_leaves_its_argument_alone():
    rng = np.random.default_rng(6)
    points = rng.uniform(-2.0, 2.0, (10, 2))
    before = points.copy()
    (pose,) = random_poses(rng, 1)
    moved = pose.transform(points)
    assert (points == before).all()
    apart = np.linalg.norm(points[:, None] - points, axis=-1)
    assert np.linalg.norm(moved[:, None] - moved, axis=-1) == pytest.approx(apart, abs=1e-12)


def test_the_position_of_a_pose_is_where_its_origin_goes():
    pose = Pose2D(1.5, -0.5, 2.0)
    assert pose.transform(np.zeros(2)) == pytest.approx([1.5, -0.5])


def test_a_wrapped_angle_is_the_same_direction_within_half_a_turn():
    for angle in np.random.default_rng(7).uniform(-50.0, 50.0, 200):
        wrapped = wrap_angle(angle)
        assert -math.pi <= wrapped < math.pi
        assert math.remainder(wrapped - angle, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)


def test_half_a_turn_is_minus_pi_from_either_side():
    assert wrap_angle(math.pi) == wrap_angle(-math.pi) == wrap_angle(3.0 * math.pi) == -math.pi


@pytest.mark.parametrize('turns', [-3, -1, 1, 3])
def test_the_interval_is_half_open_even_for_the_neighbours_of_half_a_turn(turns):
    for towards in (-math.inf, math.inf):
        wrapped = wrap_angle(math.nextafter(turns * math.pi, towards))
        assert -math.pi <= wrapped < math.pi
        assert abs(wrapped) == pytest.approx(math.pi)


def test_an_angle_within_the_interval_stays():
    for angle in np.random.default_rng(8).uniform(-math.pi, math.pi, 100):
        assert wrap_angle(angle) == pytest.approx(angle, abs=1e-15)


def test_composed_headings_do_not_leave_the_circle():
    pose = IDENTITY
    for _ in range(100):
        pose = pose @ Pose2D(0.1, 0.0, 1.0)
        assert -math.pi <= pose.yaw < math.pi
    assert wrap_angle(pose.yaw - 100.0) == pytest.approx(0.0, abs=1e-12)


def test_distance_and_heading_lead_from_one_pose_to_the_other():
    for a, b in zip(*(random_poses(np.random.default_rng(seed), 50) for seed in (9, 10))):
        d, heading = a.distance_to(b), a.heading_to(b)
        assert a.x + d * math.cos(heading) == pytest.approx(b.x)
        assert a.y + d * math.sin(heading) == pytest.approx(b.y)


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_a_pose_is_finite_only_if_all_its_numbers_are(bad):
    assert Pose2D(1.0, 2.0, 3.0).is_finite()
    for place in range(3):
        numbers = [1.0, 2.0, 3.0]
        numbers[place] = bad
        assert not Pose2D(*numbers).is_finite()


def test_distance_to_a_polyline_is_the_least_over_its_points():
    rng = np.random.default_rng(11)
    for _ in range(30):
        corners = rng.uniform(-3.0, 3.0, (rng.integers(2, 6), 2))
        point = rng.uniform(-4.0, 4.0, 2)
        t = np.linspace(0.0, 1.0, 5001)[:, None]
        samples = np.concatenate([a + t * (b - a) for a, b in itertools.pairwise(corners)])
        sampled = np.linalg.norm(samples - point, axis=1).min()
        exact = distance_to_polyline(tuple(point), corners)
        assert exact <= sampled + 1e-12
        assert sampled - exact < 2e-3


def test_distances_of_many_points_are_those_of_each():
    rng = np.random.default_rng(12)
    points = rng.uniform(-4.0, 4.0, (20, 2))
    for count in (1, 2, 5):
        corners = rng.uniform(-3.0, 3.0, (count, 2))
        each = [distance_to_polyline(tuple(point), corners) for point in points]
        assert distances_to_polyline(points, corners) == pytest.approx(each, abs=1e-12)


def test_a_polyline_of_one_corner_or_of_equal_corners_is_a_point():
    corner = np.array([[1.0, 2.0]])
    for corners in (corner, np.repeat(corner, 2, axis=0), np.repeat(corner, 5, axis=0)):
        assert distance_to_polyline((4.0, 6.0), corners) == pytest.approx(5.0)
        assert distance_to_polyline((1.0, 2.0), corners) == 0.0


def test_beyond_its_ends_a_polyline_is_as_far_as_the_end():
    line = np.array([[0.0, 0.0], [1.0, 0.0]])
    assert distance_to_polyline((4.0, 4.0), line) == pytest.approx(5.0)
    assert distance_to_polyline((-3.0, -4.0), line) == pytest.approx(5.0)
    assert distance_to_polyline((0.3, -0.2), line) == pytest.approx(0.2)


@pytest.mark.parametrize('bad', [math.nan, math.inf, -math.inf])
def test_a_twist_is_finite_only_if_all_its_numbers_are(bad):
    assert Twist2D(1.0, 2.0, 3.0).is_finite()
    for part in ('forward', 'left', 'turn'):
        assert not Twist2D(**{part: bad}).is_finite()


def test_a_twist_is_true_if_anything_moves():
    assert not STILL
    assert not Twist2D(0.0, -0.0, 0.0)
    for part in ('forward', 'left', 'turn'):
        for speed in (1e-12, -1.0):
            assert Twist2D(**{part: speed})


def test_scaling_a_twist_scales_all_its_parts():
    for row in np.random.default_rng(12).uniform(-1.0, 1.0, (20, 3)):
        twist = Twist2D(*row)
        assert twist.scaled(1.0) == twist
        assert twist.scaled(-2.0) == Twist2D(*(-2.0 * row))
        assert twist.scaled(3.0).scaled(0.5) == Twist2D(*(1.5 * row))
        assert twist.scaled(0.0) == STILL
    assert STILL.scaled(5.0) == STILL


@pytest.mark.parametrize('course', [0.0, 0.7, -2.5])
def test_a_robot_on_its_course_has_no_drift_however_its_body_is_turned(course):
    along = [Pose2D(d * math.cos(course), d * math.sin(course), d) for d in (0.0, 0.4, 1.7)]
    assert distance_aside(along, course) == pytest.approx(0.0, abs=1e-12)
    assert distance_aside(along, course + 0.1) == pytest.approx(1.7 * math.sin(0.1))
