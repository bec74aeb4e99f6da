"""The body goes level over its feet, where it is in balance."""

import math

import numpy as np
import pytest

from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.stability import stability_margin
from quad_gait.state.body_placement import BodyPose, balanced, balanced_on_four, body_over

TRIANGLE = np.array([[0.0, 0.0], [0.6, 0.0], [0.0, 0.4]])


@pytest.mark.parametrize('name', available_robots())
def test_over_feet_in_the_initial_posture_the_body_is_in_it(name):
    robot = load_robot(name)
    pose = BodyPose(np.array([1.0, 2.0, 0.3]), 0.0, 0.0, 0.7)
    found = body_over(robot, pose.transform(robot.neutral_feet), 0.7, np.zeros(2), 0.0)
    assert found.position == pytest.approx(pose.position)
    assert (found.roll, found.pitch, found.yaw) == pytest.approx((0.0, 0.0, 0.7))


@pytest.mark.parametrize('fraction', [0.0, 0.5, 1.0])
def test_on_a_slope_the_body_takes_the_share_of_its_tilt_that_it_is_told(fraction):
    robot = load_robot('titan_viii')
    slope, yaw = np.array([0.15, 0.05]), 0.4
    feet = BodyPose(np.zeros(3), 0.0, 0.0, yaw).transform(robot.neutral_feet)
    feet[:, 2] += feet[:, :2] @ slope
    body = body_over(robot, feet, yaw, slope, fraction)
    normal = np.array([-slope[0], -slope[1], 1.0])
    tilt = math.acos(body.rotation[:, 2] @ normal / np.linalg.norm(normal))
    assert tilt == pytest.approx((1.0 - fraction) * math.atan(math.hypot(*slope)), abs=0.003)


def test_a_balanced_point_stays_and_another_one_moves_just_inside():
    inside = np.array([0.15, 0.12])
    assert balanced(inside, TRIANGLE, 0.03) is inside
    feet = np.vstack([TRIANGLE, [9.0, 9.0]])
    down = np.array([True, True, True, False])
    for point in ([0.3, 0.3], [-0.2, 0.1], [0.7, -0.1], [0.0, 0.5], [0.3, 0.2]):
        moved = balanced(np.array(point), TRIANGLE, 0.03)
        assert stability_margin(moved, feet, down) == pytest.approx(0.03, abs=1e-9)


def test_in_a_triangle_that_is_too_small_the_middle_is_best():
    moved = balanced(np.array([5.0, 5.0]), TRIANGLE, 1.0)
    inner = (0.6 + 0.4 - math.hypot(0.6, 0.4)) / 2.0
    assert moved == pytest.approx([inner, inner])


def test_it_does_not_matter_which_way_round_the_feet_are_given():
    point = np.array([0.3, 0.3])
    assert balanced(point, TRIANGLE[::-1], 0.03) == pytest.approx(balanced(point, TRIANGLE, 0.03))


@pytest.mark.parametrize('point', [(0.1, 0.05), (0.5, 0.0), (0.4, 0.5), (0.0, -0.4), (-0.9, 0.9)])
def test_a_body_is_kept_inside_four_feet(point):
    feet = np.array([[0.35, 0.2], [0.3, -0.25], [-0.2, 0.2], [-0.3, -0.2]])
    kept = balanced_on_four(np.array(point), feet, 0.03)
    corners = feet[[0, 1, 3, 2]]
    edges = np.roll(corners, -1, axis=0) - corners
    arms = kept - corners
    # Counted clockwise the inside is to the right of each edge.
    far = (edges[:, 1] * arms[:, 0] - edges[:, 0] * arms[:, 1]) / np.linalg.norm(edges, axis=1)
    assert far.min() > 0.03 - 2e-4
    if point == (0.1, 0.05):
        assert kept.tolist() == list(point)
    if point == (0.5, 0.0):
        assert kept[0] == pytest.approx(0.297, abs=0.01)


def test_a_body_between_feet_that_are_too_near_to_one_another_is_not_moved_away_from_them():
    feet = np.array([[0.01, 0.2], [0.01, -0.2], [-0.01, 0.2], [-0.01, -0.2]])
    kept = balanced_on_four(np.array([0.3, 0.0]), feet, 0.03)
    assert abs(kept[0]) < 0.05


@pytest.mark.parametrize('inner', range(4))
@pytest.mark.parametrize('point', [(0.0, 0.0), (0.1, 0.05), (-0.3, 0.0), (0.0, -0.4), (0.05, 0.3)])
def test_a_foot_between_the_others_bears_no_edge(inner, point):
    # As they stood after footsteps over stones: the quadrilateral of the legs has a corner inwards.
    corners = np.array([[0.13, 0.24], [0.11, -0.19], [-0.04, 0.03], [0.0, -0.07]])
    corners = np.roll(corners, inner - 2, axis=0)
    triangle = np.delete(corners, inner, axis=0)
    corners[inner] = triangle.mean(axis=0) + [0.02, 0.01]
    kept = balanced_on_four(np.array(point), corners, 0.03)
    assert kept == pytest.approx(balanced(np.array(point), triangle, 0.03))
    edges = np.roll(triangle, -1, axis=0) - triangle
    arms = kept - triangle
    off = (edges[:, 0] * arms[:, 1] - edges[:, 1] * arms[:, 0]) / np.hypot(*edges.T)
    assert np.abs(off).min() > 0.02
    assert (off > 0.0).all() or (off < 0.0).all()
