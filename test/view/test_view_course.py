"""Tracks, goals, plots and the speed pad."""

from __future__ import annotations

import math

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D, Twist2D
from quad_view.scene.course import Track, distance_from_plan, goal_of_drag
from quad_view.scene.pad import HELD, STILL, Pad
from quad_view.scene.robots import namespaces_of
from quad_view.scene.series import Series

ROBOT = Pose2D(1.0, 1.0, 0.3)


def test_a_click_is_a_goal_with_the_heading_of_the_way_there():
    goal = goal_of_drag((2.0, 2.0), (2.0, 2.0), ROBOT)
    assert (goal.x, goal.y, goal.yaw) == pytest.approx((2.0, 2.0, math.pi / 4))


def test_a_drag_gives_its_direction_as_heading():
    goal = goal_of_drag((2.0, 2.0), (2.0, 1.0), ROBOT)
    assert (goal.x, goal.y, goal.yaw) == pytest.approx((2.0, 2.0, -math.pi / 2))


def test_a_click_on_the_robot_keeps_its_heading():
    assert goal_of_drag((1.0, 1.01), (1.0, 1.01), ROBOT).yaw == ROBOT.yaw
    assert goal_of_drag((1.0, 1.0), (1.0, 1.0), None).yaw == 0.0


def test_a_track_keeps_its_shape_and_its_size_whatever_is_walked():
    track = Track()
    for k in range(40_000):
        track.add(0.01 * k, math.sin(0.01 * k))
    points = track.points()
    assert len(points) <= 3001
    np.testing.assert_allclose(points[:, 1], np.sin(points[:, 0]), atol=1e-9)
    assert points[-1, 0] > 399.0


def test_a_robot_that_is_put_elsewhere_begins_its_track_there():
    track = Track()
    assert track.add(0.0, 0.0)
    assert not track.add(0.001, 0.0)
    assert track.add(5.0, 0.0)
    assert track.points().tolist() == [[5.0, 0.0]]


def test_the_distance_from_a_plan_is_not_known_without_one():
    assert math.isnan(distance_from_plan(ROBOT, np.zeros((0, 2))))
    assert math.isnan(distance_from_plan(None, np.array([[0.0, 0.0], [1.0, 0.0]])))
    assert distance_from_plan(ROBOT, np.array([[0.0, 0.0], [5.0, 0.0]])) == pytest.approx(1.0)


def test_a_pad_that_is_held_steers_ten_times_a_second():
    pad, forward = Pad(), Twist2D(0.1, 0.0, 0.0)
    commands = []
    for k in range(100):
        pad.hold(forward, 0.01 * k)
        commands.append(pad.command(0.01 * k))
    sent = [command for command in commands if command is not None]
    assert sent == [forward] * len(sent)
    assert 9 <= len(sent) <= 11


def test_a_pad_that_is_let_go_or_lost_says_stop_once():
    pad = Pad()
    assert pad.command(0.0) is None
    pad.hold(Twist2D(0.1, 0.0, 0.0), 0.0)
    assert pad.command(0.5 * HELD)
    assert pad.command(HELD) == STILL
    assert pad.command(HELD + 0.2) is None
    pad.hold(Twist2D(0.1, 0.0, 0.0), 5.0)
    pad.let_go()
    assert pad.command(5.01) == STILL


def test_a_plot_holds_the_last_seconds_and_begins_anew_when_time_does():
    series = Series(['a', 'b'], span=10.0, most=100)
    assert [len(column) for column in series.arrays()] == [1, 1, 1]
    for k in range(3000):
        series.add(0.01 * k, (k, -k))
    time, a, b = series.arrays()
    assert len(time) <= 100
    assert time[-1] - time[0] <= 10.0
    np.testing.assert_array_equal(a, -b)
    series.add(1.0, (1.0, 2.0))
    assert series.arrays()[0].tolist() == [1.0]


@pytest.mark.parametrize(
    ('wanted', 'topics', 'names'),
    [
        ('', ['/joint_states', '/b/joint_states', '/b/odom', '/my_joint_states'], ('', 'b')),
        ('left, /right/', ['/joint_states'], ('left', 'right')),
        ('', [], ()),
    ],
)
def test_robots_are_found_by_what_they_publish(wanted, topics, names):
    assert namespaces_of(wanted, topics) == names
