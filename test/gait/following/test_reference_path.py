"""A path is lines and arcs that meet, and places on it are what they are said to be."""

import math
from itertools import pairwise

import numpy as np
import pytest

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline, wrap_angle
from quad_gait.following.reference_path import Piece, circle_pieces, rounded_pieces, straight_pieces

STOP_ANGLE = math.radians(12.0)


def random_pieces(rng, count=100):
    for x, y, yaw, length, bend in rng.uniform(
        (-3.0, -3.0, -math.pi, 0.1, -2.0), (3.0, 3.0, math.pi, 2.0, 2.0), (count, 5)
    ):
        # Up to 2 rad to either side: lines, gentle arcs and tight ones.
        yield Piece(Pose2D(x, y, yaw), length, 0.0 if abs(bend) < 0.4 else bend / length)


def random_plan(rng, corners=5):
    points = [np.zeros(2)]
    for _ in range(corners - 1):
        angle, length = rng.uniform(-math.pi, math.pi), rng.uniform(0.3, 2.0)
        points.append(points[-1] + length * np.array([math.cos(angle), math.sin(angle)]))
    return Plan.through(points, rng.uniform(-math.pi, math.pi))


def assert_same(a, b, tolerance=1e-9):
    assert (a.x, a.y) == pytest.approx((b.x, b.y), abs=tolerance)
    assert wrap_angle(a.yaw - b.yaw) == pytest.approx(0.0, abs=tolerance)


def sampled(pieces, step=0.005):
    """Points along all pieces, shape (n, 2)."""
    poses = [
        piece.at(distance)
        for piece in pieces
        for distance in np.linspace(0.0, piece.length, max(2, math.ceil(piece.length / step)))
    ]
    return np.array([(pose.x, pose.y) for pose in poses])


def test_what_is_projected_from_a_place_on_a_piece_is_that_place():
    rng = np.random.default_rng(1)
    for piece in random_pieces(rng):
        for distance in rng.uniform(0.0, piece.length, 5):
            assert piece.project(piece.at(distance)) == pytest.approx(distance, abs=1e-9)
            assert piece.distance_to(piece.at(distance)) == pytest.approx(0.0, abs=1e-9)


def test_beside_a_piece_a_pose_is_projected_to_where_it_is_beside():
    rng = np.random.default_rng(2)
    for piece in random_pieces(rng):
        room = 0.5 / abs(piece.curvature) if piece.curvature else 1.0
        for distance, side in rng.uniform((0.0, -room), (piece.length, room), (5, 2)):
            beside = piece.at(distance) @ Pose2D(0.0, side, rng.uniform(-3.0, 3.0))
            assert piece.project(beside) == pytest.approx(distance, abs=1e-9)
            assert piece.distance_to(beside) == pytest.approx(abs(side), abs=1e-9)


def test_the_projection_is_the_nearest_of_all_places():
    rng = np.random.default_rng(3)
    for piece in random_pieces(rng, 50):
        pose = Pose2D(*rng.uniform(-4.0, 4.0, 3))
        places = sampled([piece], 0.001)
        nearest = np.hypot(*(places - [pose.x, pose.y]).T).min()
        assert piece.distance_to(pose) <= nearest + 1e-9 or abs(piece.curvature) > 0.0
        if 0.0 <= piece.project(pose) <= piece.length:
            assert piece.distance_to(pose) == pytest.approx(nearest, abs=1e-3)


@pytest.mark.parametrize('curvature', [0.0, 1.0, -1.0, 5.0, -5.0])
def test_before_a_piece_projections_are_negative_and_after_it_beyond_its_length(curvature):
    piece = Piece(Pose2D(1.0, 2.0, 3.0), 0.2, curvature)
    before, after = piece.start @ Pose2D(-0.05, 0.0, 0.0), piece.end @ Pose2D(0.05, 0.0, 0.0)
    assert piece.project(before) < 0.0
    assert piece.project(after) > piece.length
    assert piece.distance_to(before) == pytest.approx(0.05)
    assert piece.distance_to(after) == pytest.approx(0.05)


def test_a_right_hand_arc_mirrors_a_left_hand_arc():
    rng = np.random.default_rng(4)
    start = Pose2D(0.0, 0.0, 0.0)
    left, right = Piece(start, 1.5, 0.8), Piece(start, 1.5, -0.8)
    for x, y, yaw in rng.uniform(-1.0, 1.0, (50, 3)):
        pose, mirrored = Pose2D(x, y, yaw), Pose2D(x, -y, -yaw)
        assert right.project(mirrored) == pytest.approx(left.project(pose))
        assert right.distance_to(mirrored) == pytest.approx(left.distance_to(pose))


def test_an_arc_keeps_its_distance_from_its_centre_and_heads_along_itself():
    rng = np.random.default_rng(5)
    for piece in random_pieces(rng):
        if not piece.curvature:
            continue
        center = piece.start @ Pose2D(0.0, 1.0 / piece.curvature, 0.0)
        for distance in np.linspace(0.0, piece.length, 7):
            place = piece.at(distance)
            assert place.distance_to(center) == pytest.approx(1.0 / abs(piece.curvature))
            h = 1e-6
            course = piece.at(distance - h).heading_to(piece.at(distance + h))
            assert wrap_angle(course - place.yaw) == pytest.approx(0.0, abs=1e-6)


# Straight from turning point to turning point.


def test_straight_pieces_lead_from_turning_point_to_turning_point():
    rng = np.random.default_rng(6)
    for _ in range(30):
        plan = random_plan(rng)
        pieces = straight_pieces(plan, STOP_ANGLE)
        assert sum(piece.length for piece in pieces) == pytest.approx(plan.length)
        assert len(pieces) == len(plan.poses) - 1
        for piece, a, b in zip(pieces, plan.poses, plan.poses[1:]):
            assert piece.curvature == 0.0
            assert_same(piece.start, Pose2D(a.x, a.y, a.heading_to(b)))
            assert (piece.end.x, piece.end.y) == pytest.approx((b.x, b.y))


def test_the_robot_stops_at_sharp_corners_and_at_the_end():
    plan = Plan.through([[0, 0], [1, 0], [2, 0.1], [2, 1]], 0.0)
    assert [piece.ends_in_stop for piece in straight_pieces(plan, STOP_ANGLE)] == [
        False,
        True,
        True,
    ]
    assert [piece.ends_in_stop for piece in straight_pieces(plan, math.pi)] == [
        False,
        False,
        True,
    ]


@pytest.mark.parametrize('make', [straight_pieces, lambda p, s: rounded_pieces(p, 0.1, 1.0, s)])
def test_a_plan_of_one_pose_has_no_path(make):
    assert make(Plan((Pose2D(1.0, 2.0, 3.0),)), STOP_ANGLE) == []


# Rounded corners.


def test_rounded_corners_join_in_place_and_heading():
    rng = np.random.default_rng(7)
    for _ in range(100):
        plan = random_plan(rng)
        pieces = rounded_pieces(plan, 0.1, 1.0, STOP_ANGLE)
        for piece, after in pairwise(pieces):
            assert_same(piece.end, after.start, 1e-6)
        assert_same(pieces[0].start, straight_pieces(plan, STOP_ANGLE)[0].start)
        last, goal = pieces[-1].end, plan.poses[-1]
        assert (last.x, last.y) == pytest.approx((goal.x, goal.y), abs=1e-6)
        assert [piece.ends_in_stop for piece in pieces[:-1]] == [False] * (len(pieces) - 1)
        assert pieces[-1].ends_in_stop


def test_a_rounded_corner_stays_within_its_deviation_and_radius():
    rng = np.random.default_rng(8)
    for _ in range(50):
        plan = random_plan(rng)
        deviation, radius = rng.uniform((0.02, 0.1), (0.3, 2.0))
        pieces = rounded_pieces(plan, deviation, radius, STOP_ANGLE)
        path = sampled(pieces)
        # No turning point is farther from the path, and the path from the plan's lines.
        for x, y in plan.corners:
            assert np.hypot(*(path - [x, y]).T).min() <= deviation + 0.005
        for place in path[::5]:
            assert distance_to_polyline(tuple(place), plan.corners) <= deviation + 1e-9
        for piece in pieces:
            assert not piece.curvature or 1.0 / abs(piece.curvature) <= radius + 1e-9


@pytest.mark.parametrize('degrees', [10.0, 45.0, 90.0, 135.0])
@pytest.mark.parametrize('side', [1.0, -1.0])
def test_where_there_is_room_either_the_deviation_or_the_radius_is_used_up(degrees, side):
    turn = side * math.radians(degrees)
    corner = [5.0 + 5.0 * math.cos(turn), 5.0 * math.sin(turn)]
    plan = Plan.through([[0.0, 0.0], [5.0, 0.0], corner], 0.0)
    line, arc, on = rounded_pieces(plan, 0.1, 1.0, STOP_ANGLE)
    assert (line.curvature, on.curvature) == (0.0, 0.0)
    assert math.copysign(1.0, arc.curvature) == side
    assert arc.length * arc.curvature == pytest.approx(turn)
    radius = 1.0 / abs(arc.curvature)
    middle = arc.at(arc.length / 2.0)
    passed = math.hypot(middle.x - 5.0, middle.y)
    assert passed == pytest.approx(radius * (1.0 / math.cos(turn / 2.0) - 1.0))
    assert max(radius / 1.0, passed / 0.1) == pytest.approx(1.0)


def test_a_side_shared_by_two_corners_is_divided_between_them():
    plan = Plan.through([[0, 0], [2, 0], [2, 0.1], [0, 0.1]], 0.0)
    pieces = rounded_pieces(plan, 1.0, 1.0, STOP_ANGLE)
    assert [piece.curvature for piece in pieces] == pytest.approx([0.0, 20.0, 20.0, 0.0])
    for piece, after in pairwise(pieces):
        assert_same(piece.end, after.start, 1e-9)


def test_a_turn_back_is_no_bend_but_a_stop():
    plan = Plan.through([[0, 0], [1, 0], [0, 0]], 0.0)
    there, back = rounded_pieces(plan, 0.1, 1.0, STOP_ANGLE)
    assert there.ends_in_stop
    assert back.ends_in_stop
    assert (there.curvature, back.curvature) == (0.0, 0.0)


def test_a_curve_of_many_points_is_followed_without_a_stop():
    angle = np.linspace(0.0, 1.5 * math.pi, 60)
    plan = Plan.through(np.stack([np.cos(angle), np.sin(angle)], axis=1), 0.0)
    pieces = rounded_pieces(plan, 0.05, 1.0, STOP_ANGLE)
    assert [piece.ends_in_stop for piece in pieces] == [False] * (len(pieces) - 1) + [True]
    arcs = [piece for piece in pieces if piece.curvature]
    # Its bends become circles of its radius.
    assert [arc.curvature for arc in arcs] == pytest.approx([1.0] * len(arcs), rel=0.01)


# Circles.


@pytest.mark.parametrize('turn', [2.0 * math.pi, -2.0 * math.pi, 0.3, -4.0, 6.0 * math.pi])
def test_a_circle_is_as_long_as_it_turns_and_all_on_the_circle(turn):
    start = Pose2D(1.0, -2.0, 0.7)
    pieces = circle_pieces(start, 0.4, turn)
    assert sum(piece.length for piece in pieces) == pytest.approx(0.4 * abs(turn))
    center = start @ Pose2D(0.0, math.copysign(0.4, turn), 0.0)
    assert np.hypot(*(sampled(pieces) - [center.x, center.y]).T) == pytest.approx(0.4)
    assert_same(pieces[0].start, start)
    for piece, after in pairwise(pieces):
        assert_same(piece.end, after.start)
        # So that what is projected is never ambiguous.
        assert piece.length <= 0.4 * math.pi / 2.0 + 1e-9
    assert_same(pieces[-1].end, center @ Pose2D(0, 0, turn) @ center.inverse() @ start)
    assert [piece.ends_in_stop for piece in pieces] == [False] * (len(pieces) - 1) + [True]


@pytest.mark.parametrize('laps', [1, -1, 3])
def test_whole_laps_close_the_circle(laps):
    start = Pose2D(1.0, -2.0, 0.7)
    pieces = circle_pieces(start, 0.4, 2.0 * math.pi * laps)
    assert_same(pieces[-1].end, start)
    assert len(pieces) == 4 * abs(laps)
