"""The stability margin against plain geometry."""

import math

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from quad_gait.stability import stability_margin, support_polygon

SQUARE = np.array([[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]])
ALL = np.ones(4, dtype=bool)


def margin(point, feet, in_contact=ALL):
    return float(stability_margin(np.asarray(point, dtype=float), feet, np.asarray(in_contact)))


def reference(point, feet):
    """Least distance to the half-planes of the convex hull, as qhull finds them."""
    hull = ConvexHull(feet)
    return float(np.min(-(hull.equations[:, :2] @ point + hull.equations[:, 2])))


def distance_to_edges(point, feet):
    """Distance from a point to the hull's border, by sampling it densely."""
    corners = feet[ConvexHull(feet).vertices]
    t = np.linspace(0.0, 1.0, 20001)[:, None]
    border = [a + t * (b - a) for a, b in zip(corners, np.roll(corners, -1, axis=0))]
    return float(np.linalg.norm(np.concatenate(border) - point, axis=1).min())


def test_the_margin_is_the_least_distance_to_the_half_planes_of_the_hull():
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


def test_inside_the_margin_is_the_distance_to_the_border():
    rng = np.random.default_rng(3)
    inside = 0
    while inside < 30:
        feet, point = rng.uniform(-1.0, 1.0, (4, 2)), rng.uniform(-0.5, 0.5, 2)
        found = margin(point, feet)
        if found > 0.0:
            inside += 1
            assert found == pytest.approx(distance_to_edges(point, feet), abs=1e-4)


def test_the_margin_has_a_sign_and_is_zero_on_the_border():
    assert margin([0.0, 0.0], SQUARE) == pytest.approx(1.0)
    assert margin([1.0, 0.3], SQUARE) == pytest.approx(0.0)
    assert margin([1.0, 1.0], SQUARE) == pytest.approx(0.0)
    assert margin([1.25, 0.0], SQUARE) == pytest.approx(-0.25)


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


def test_on_two_feet_the_margin_is_minus_the_distance_to_their_line():
    in_contact = [True, False, False, True]
    assert margin([0.0, 0.0], SQUARE, in_contact) == pytest.approx(0.0)
    for point in ([0.5, -0.5], [-0.5, 0.5]):
        assert margin(point, SQUARE, in_contact) == pytest.approx(-math.sqrt(0.5))


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


def test_the_support_polygon_lists_the_hull_counter_clockwise():
    rng = np.random.default_rng(7)
    for in_contact in (ALL, np.array([True, True, False, True])):
        feet = SQUARE + rng.uniform(-0.3, 0.3, (4, 2))
        corners = support_polygon(feet, in_contact)
        x, y = corners.T
        area = 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))
        # In the plane, qhull's "volume" is the area.
        assert area == pytest.approx(ConvexHull(feet[in_contact]).volume)
        assert {tuple(corner) for corner in corners} == {tuple(foot) for foot in feet[in_contact]}


@pytest.mark.parametrize('count', [0, 1, 2])
def test_on_two_feet_or_fewer_the_support_polygon_is_those_feet(count):
    assert (support_polygon(SQUARE, np.arange(4) < count) == SQUARE[:count]).all()
