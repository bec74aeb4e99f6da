"""What planners tell one another of their robots can be read again, and nonsense is refused."""

import numpy as np
import pytest

pytest.importorskip('visualization_msgs')

from builtin_interfaces.msg import Time
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage, InvalidPose
from quad_common.planar_pose import Pose2D
from quad_planner.traffic.robot_on_map import RobotOnMap
from quad_planner.traffic_topics import robot_from_message, robot_markers

PATH = np.array([[1.0, 2.0], [3.0, 2.5]])


def told(path=PATH, goes_first=False):
    robot = RobotOnMap('left', Pose2D(1.0, 2.0, 0.5), 0.3, path, goes_first)
    return robot_markers(robot, 'map', Time(sec=3))


@pytest.mark.parametrize('goes_first', [True, False])
@pytest.mark.parametrize('path', [PATH, np.empty((0, 2))])
def test_a_robot_is_read_as_it_was_written(path, goes_first):
    robot = robot_from_message(told(path, goes_first), 'map')
    assert (robot.name, robot.radius, robot.goes_first) == ('left', 0.3, goes_first)
    assert robot.pose.distance_to(Pose2D(1.0, 2.0, 0.5)) < 1e-9
    assert robot.pose.yaw == pytest.approx(0.5)
    assert np.array_equal(robot.path, path)


def test_a_robot_that_has_left_is_named():
    gone = MarkerArray(markers=[Marker(ns='left', action=Marker.DELETE)])
    assert robot_from_message(gone, 'map') == 'left'


def test_another_frame_and_what_is_no_robot_are_refused():
    with pytest.raises(InvalidMessage, match="give it in 'odom'"):
        robot_from_message(told(), 'odom')
    with pytest.raises(InvalidMessage, match='markers 0'):
        robot_from_message(MarkerArray(), 'map')
    for width in (float('nan'), 0.0, 1e9):
        message = told()
        message.markers[0].scale.x = width
        with pytest.raises(InvalidMessage, match='wide'):
            robot_from_message(message, 'map')
    message = told()
    message.markers[1].points[0].x = 1e6
    with pytest.raises(InvalidMessage, match='1000 m are most'):
        robot_from_message(message, 'map')
    message = told()
    message.markers[1].points[0].x = float('inf')
    with pytest.raises(InvalidPose, match='point of a path'):
        robot_from_message(message, 'map')
