"""Markers fit on the robots, and their colors are colors."""

import math

import pytest

from quad_common.errors import ParameterError
from quad_common.robot_files.robot_file import load_robot
from quad_common.vision.markers import GoalMarker, RobotMarker

ROBOTS = ('titan_viii', 'pukyong', 'cuhk', 'genibo')


@pytest.mark.parametrize('name', ROBOTS)
def test_the_discs_are_on_the_plate_apart_and_above_the_body(name):
    robot = load_robot(name)
    marker = RobotMarker.on(robot)
    assert 2.0 * marker.disc_radius < marker.disc_distance
    assert marker.disc_distance + 2.0 * marker.disc_radius < marker.length
    assert 2.0 * marker.disc_radius < marker.width
    assert marker.height > robot.body_center[2] + robot.body_size[2] / 2.0


def test_the_marker_of_titan_viii_is_the_one_that_nobody_asked_for():
    fitted, default = RobotMarker.on(load_robot('titan_viii')), RobotMarker()
    for name in ('length', 'width', 'height', 'disc_radius', 'disc_distance'):
        assert math.isclose(getattr(fitted, name), getattr(default, name), abs_tol=1e-3)
    assert fitted.front_color == default.front_color


def test_the_discs_of_the_goal_do_not_touch():
    marker = GoalMarker()
    assert marker.radius + marker.heading_radius < marker.heading_distance


@pytest.mark.parametrize('color', [(0, 0), (0, 0, 256), (-1, 0, 0), (0.5, 0.5, 0.5)])
def test_what_is_no_color_is_refused(color):
    for make in (
        lambda: RobotMarker(front_color=color),
        lambda: GoalMarker(heading_color=color),
    ):
        with pytest.raises(ParameterError, match='whole numbers from 0 to 255'):
            make()
