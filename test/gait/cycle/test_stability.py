"""The stability margin against plain geometry."""

import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from quad_common.planar_pose import distance_to_polyline
from quad_gait.cycle.stability import stability_margin, support_polygon

SQUARE = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
ALL = np.ones(4, dtype=bool)


def margin(point, feet, in_contact=ALL):
    return float(stability_margin(np.asarray(point, dtype=float), feet, np.asarray(in_contact)))


def reference(point, feet):
    """Distance to the border of the convex hull, as qhull finds it; negative outside."""
    hull = ConvexHull(feet)
    is_inside = np.all(hull.equations[:, :2] @ point + hull.equations[:, 2] <= 0.0)
    corners = feet[hull.vertices]
    distance = distance_to_polyline(tuple(point), np.concatenate([corners, corners[:1]]))
    return distance if is_inside else -distance


def test_the_margin_is_the_distance_to_the_border_of_the_hull():
    rng = np.random.default_rng(1)
    for _ in range(500):
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-1.0, 1.0, 2)
        assert margin(point, feet) == pytest.approx(reference(point, feet), abs=1e-9)


@pytest.mark.parametrize('lifted', range(4))
def test_a_lifted_foot_supports_nothing(lifted):
    rng = np.random.default_rng(2)
    in_contact = np.arange(4) != lifted
    for _ in range(200):
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-1.0, 1.0, 2)
        expected = reference(point, feet[in_contact])
        assert margin(point, feet, in_contact) == pytest.approx(expected, abs=1e-9)


def test_inside_the_margin_is_the_least_distance_to_the_half_planes_of_the_hull():
    rng = np.random.default_rng(3)
    inside = 0
    while inside < 100:
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-0.5, 0.5, 2)
        found = margin(point, feet)
        if found > 0.0:
            inside += 1
            planes = ConvexHull(feet).equations
            expected = np.min(-(planes[:, :2] @ point + planes[:, 2]))
            assert found == pytest.approx(expected, abs=1e-9)


def test_the_margin_never_changes_faster_than_the_point_moves():
    rng = np.random.default_rng(8)
    for _ in range(300):
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-2.0, 2.0, 2)
        step = rng.normal(0.0, 0.1, 2)
        change = margin(point + step, feet) - margin(point, feet)
        assert abs(change) <= np.linalg.norm(step) + 1e-9


def test_the_margin_has_a_sign_and_is_zero_on_the_border():
    assert margin([0.0, 0.0], SQUARE) == pytest.approx(1.0)
    assert margin([1.0, 0.3], SQUARE) == pytest.approx(0.0)
    assert margin([1.0, 1.0], SQUARE) == pytest.approx(0.0)
    assert margin([1.25, 0.0], SQUARE) == pytest.approx(-0.25)
    assert margin([1.3, 1.4], SQUARE) == pytest.approx(-0.5)


def test_the_papers_zero_margin_is_the_centre_on_a_diagonal():
    for lifted in range(4):
        assert margin([0.0, 0.0], SQUARE, np.arange(4) != lifted) == pytest.approx(0.0)


def test_the_margin_moves_with_feet_and_point_and_scales_with_them():
    rng = np.random.default_rng(4)
    c, s = math.cos(0.7), math.sin(0.7)
    rotation = np.array([[c, -s], [s, c]])
    for _ in range(50):
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-1.0, 1.0, 2)
        moved = margin(2.0 * rotation @ point + [3.0, -1.0], 2.0 * feet @ rotation.T + [3.0, -1.0])
        assert moved == pytest.approx(2.0 * margin(point, feet), abs=1e-9)


def test_the_order_of_the_feet_does_not_matter():
    rng = np.random.default_rng(5)
    feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-0.3, 0.3, 2)
    for _ in range(10):
        order = rng.permutation(4)
        assert margin(point, feet[order]) == pytest.approx(margin(point, feet))


def test_a_foot_within_the_others_triangle_changes_nothing():
    feet = np.array([[2.0, 0.0], [-1.0, 2.0], [-1.0, -2.0], [0.1, 0.1]])
    for point in ([0.0, 0.0], [0.5, 0.2], [3.0, 0.0]):
        assert margin(point, feet) == pytest.approx(margin(point, feet, [True, True, True, False]))


def test_on_two_feet_the_margin_is_minus_the_distance_to_the_segment_between_them():
    in_contact = [True, False, False, True]
    for point in ([0.0, 0.0], [0.9, 0.9], [1.0, 1.0]):
        assert margin(point, SQUARE, in_contact) == pytest.approx(0.0)
    for point in ([0.5, -0.5], [-0.5, 0.5]):
        assert margin(point, SQUARE, in_contact) == pytest.approx(-math.sqrt(0.5))
    # Beyond a foot, on their line or off it, the foot is nearest.
    assert margin([1.3, 1.3], SQUARE, in_contact) == pytest.approx(-0.3 * math.sqrt(2.0))
    assert margin([-1.0, -3.0], SQUARE, in_contact) == pytest.approx(-2.0)
    rng = np.random.default_rng(9)
    for _ in range(100):
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-2.0, 2.0, 2)
        expected = -distance_to_polyline(tuple(point), feet[[0, 3]])
        assert margin(point, feet, in_contact) == pytest.approx(expected, abs=1e-12)


def test_a_polygon_that_shrinks_to_a_segment_has_its_margin():
    rng = np.random.default_rng(10)
    flat = np.array([[-1.0, 0.0], [0.2, 0.0], [0.5, 0.0], [2.0, 0.0]])
    for width in (1e-3, 1e-6, 1e-8, 1e-10, 0.0):
        for point in rng.uniform(-3.0, 3.0, (20, 2)):
            feet = flat + np.array([[0.0, 0.0], [0.0, width], [0.0, -width], [0.0, 0.0]])
            expected = -distance_to_polyline(tuple(point), flat)
            assert margin(point, feet) == pytest.approx(expected, abs=2.0 * width + 1e-12)


@pytest.mark.parametrize('apart', [0.0, 1e-12, 1e-9, 1e-7])
def test_feet_in_one_place_support_like_one_of_them(apart):
    rng = np.random.default_rng(11)
    for _ in range(50):
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-1.0, 1.0, 2)
        triangle = reference(point, feet[:3])
        feet[3] = feet[1] + apart * rng.normal(size=2)
        assert margin(point, feet) == pytest.approx(triangle, abs=10.0 * apart + 1e-9)
        assert margin(point, feet, [False, True, False, True]) == pytest.approx(
            -np.linalg.norm(point - feet[1]), abs=10.0 * apart + 1e-9
        )


@pytest.mark.parametrize('count', [0, 1])
def test_on_fewer_than_two_feet_there_is_no_support(count):
    assert margin([1.0, 1.0], SQUARE, np.arange(4) < count) == -math.inf


@pytest.mark.parametrize('count', [3, 4])
def test_feet_in_a_line_support_like_two(count):
    feet = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [4.0, 0.0]])
    in_contact = np.arange(4) < count
    assert margin([1.0, 0.0], feet, in_contact) == pytest.approx(0.0)
    assert margin([1.0, 0.3], feet, in_contact) == pytest.approx(-0.3)
    assert margin([1.0, -0.3], feet, in_contact) == pytest.approx(-0.3)
    assert margin([-0.5, 0.0], feet, in_contact) == pytest.approx(-0.5)
    assert margin([4.3, 0.4], feet) == pytest.approx(-0.5)


def test_three_of_four_feet_in_a_line_leave_a_triangle():
    feet = np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]])
    assert margin([1.0, 0.2], feet) == pytest.approx(0.2)
    assert margin([1.0, -0.2], feet) == pytest.approx(-0.2)


def test_many_instants_at_once_are_many_instants_one_by_one():
    rng = np.random.default_rng(6)
    feet, points = rng.uniform(-1.0, 1.0, (3, 20, 4, 2)), rng.uniform(-1.0, 1.0, (3, 20, 2))
    in_contact = rng.random((3, 20, 4)) < 0.8
    together = stability_margin(points, feet, in_contact)
    assert together.shape == (3, 20)
    for index in np.ndindex(3, 20):
        assert together[index] == margin(points[index], feet[index], in_contact[index])


def area(corners):
    x, y = corners.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


def test_the_support_polygon_is_the_convex_hull_counter_clockwise():
    rng = np.random.default_rng(7)
    for in_contact in (ALL, np.array([True, True, False, True])):
        for _ in range(100):
            feet = rng.uniform(-1.0, 1.0, (4, 2))
            corners = support_polygon(feet, in_contact)
            hull = ConvexHull(feet[in_contact])
            # In the plane, qhull's "volume" is the area.
            assert area(corners) == pytest.approx(hull.volume)
            expected = feet[in_contact][hull.vertices]
            assert {tuple(corner) for corner in corners} == {tuple(corner) for corner in expected}


def test_a_foot_within_the_others_triangle_is_no_corner():
    feet = np.array([[0.1, 0.1], [2.0, 0.0], [-1.0, 2.0], [-1.0, -2.0]])
    assert (support_polygon(feet, ALL) == feet[1:]).all()
    assert (support_polygon(feet[::-1], ALL) == feet[[3, 1, 2]]).all()


def test_feet_in_a_line_leave_the_outermost_two_as_corners():
    feet = np.array([[1.0, 0.0], [4.0, 0.0], [0.0, 0.0], [2.0, 0.0]])
    assert (support_polygon(feet, ALL) == feet[[1, 2]]).all()


def test_feet_in_one_place_are_one_corner():
    assert support_polygon(np.ones((4, 2)), ALL).tolist() == [[1.0, 1.0]]
    triangle = SQUARE[[0, 1, 2, 1]]
    assert sorted(support_polygon(triangle, ALL).tolist()) == sorted(SQUARE[:3].tolist())
    assert area(support_polygon(triangle, ALL)) == pytest.approx(2.0)


@pytest.mark.parametrize('count', [0, 1, 2])
def test_on_two_feet_or_fewer_the_support_polygon_is_those_feet(count):
    polygon = support_polygon(SQUARE, np.arange(4) < count)
    assert polygon.shape == (count, 2)
    assert (polygon == SQUARE[:count]).all()
