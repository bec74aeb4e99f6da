"""
What planners tell one another of their robots, on a topic that all of them have in common.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage
from quad_common.frames.frame_names import check_frame
from quad_common.plan import LONGEST_PLAN
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import (
    checked_name,
    pose_from_message,
    pose_message,
    position_from_message,
)
from quad_common.ros.ros_node import QuadNode
from quad_planner.parameters import PlannerParameters
from quad_planner.session.latest_request import LatestRequest
from quad_planner.session.planning_session import PlanningSession
from quad_planner.session.session_ports import Requests
from quad_planner.traffic.namesake import Namesake
from quad_planner.traffic.robot_on_map import RobotOnMap
from quad_planner.traffic.traffic import Traffic

_MOST_BYTES = 200_000
"""Largest size of a message about a robot [bytes]."""

_PERIOD = 0.2
"""Time of odometry between two messages [s]."""

_LARGEST = 10.0
"""Largest radius of a robot [m]."""

_LONGEST = 1000.0
"""Largest length of a robot's path [m]."""

_GOES_FIRST = 'goes first'
"""Text of the marker of a robot that can give way to nobody."""

_FALLEN = 'fallen'
"""Text of the marker of a robot that lies on the ground."""

_BODY, _PATH = 0, 1
"""Numbers of a robot's two markers."""


class TrafficTopics:
    """
    Tells other planners of this robot, and its session of other robots.

    A robot alone publishes nothing: there is nobody to tell.

    Parameters
    ----------
    node : QuadNode
        The node; its namespace, or without one its robot's name, is the name of the robot.
    session : PlanningSession
        Its planning session.
    requests : Requests, optional
        The part that works on searches which are not for the robot; one of their own if not given.
    """

    def __init__(
        self,
        node: QuadNode[PlannerParameters],
        session: PlanningSession,
        requests: Requests | None = None,
    ) -> None:
        self._node, self._session = node, session
        self._requests = requests or LatestRequest[Any](node.call_soon)
        robot = load_robot(node.parameters.robot)
        self._name = node.get_namespace().strip('/') or robot.name
        self._traffic = Traffic(session, self._name, robot.standing_radius, self._requests)
        self._namesake = Namesake(self._name)
        self._time = self._told_at = -np.inf
        self._words: Any = None
        if node.parameters.gives_way:
            self._words = node.create_publisher(MarkerArray, '/fleet/robots', 10)
            node.create_subscription(
                MarkerArray, '/fleet/robots', self._on_robots, 10, most_bytes=_MOST_BYTES
            )

    def update(self, time: float, tilt: float = 0.0) -> None:
        """Tell others, and look at the traffic, at a time of odometry [s], tilted so far [rad]."""
        self._time = time
        self._traffic.take_tilt(tilt)
        if self._words is None:
            return
        if abs(time - self._told_at) >= _PERIOD:
            self._told_at = time
            word = self._traffic.own_word()
            # This node's own subscription is one.
            if word is not None and self._words.get_subscription_count() > 1:
                stamp = self._node.get_clock().now().to_msg()
                self._namesake.say(word.pose)
                self._words.publish(robot_markers(word, self._session.map.frame.name, stamp))
        self._traffic.update(time)

    def problem(self) -> str:
        """Return what is wrong with what robots say of themselves; empty if nothing is."""
        return self._namesake.problem(self._time)

    def close(self) -> None:
        """Tell the others that this robot is no longer spoken for; give up what is searched."""
        self._requests.close()
        if self._words is not None and self._words.get_subscription_count() > 1:
            gone = Marker(ns=self._name, id=_BODY, action=Marker.DELETE)
            self._words.publish(MarkerArray(markers=[gone]))

    def _on_robots(self, message: MarkerArray) -> None:
        robot = robot_from_message(message, self._session.map.frame.name)
        if isinstance(robot, str):
            self._traffic.forget_robot(robot)
        elif robot.name == self._name:
            self._namesake.hear(self._time, robot.pose)
        else:
            self._traffic.take_robot(self._time, robot)


def robot_markers(robot: RobotOnMap, frame: str, stamp: Time) -> MarkerArray:
    """Write a robot as a disc, and the path that it wants to walk as a line."""
    body = Marker(ns=robot.name, id=_BODY, type=Marker.CYLINDER, action=Marker.ADD)
    body.pose = pose_message(robot.pose)
    body.scale.x = body.scale.y = 2.0 * robot.radius
    body.scale.z = 0.05
    body.text = _FALLEN if robot.has_fallen else _GOES_FIRST if robot.goes_first else ''
    path = Marker(ns=robot.name, id=_PATH, type=Marker.LINE_STRIP, action=Marker.ADD)
    path.pose.orientation.w = 1.0
    path.scale.x = 0.03
    path.points = [Point(x=float(x), y=float(y)) for x, y in robot.path]
    for marker in (body, path):
        marker.header.frame_id, marker.header.stamp = frame, stamp
        marker.color = ColorRGBA(r=0.1, g=0.6, b=0.6, a=0.6)
    return MarkerArray(markers=[body, path])


def robot_from_message(message: MarkerArray, frame: str) -> RobotOnMap | str:
    """
    Read what another planner says of its robot.

    Parameters
    ----------
    message : visualization_msgs/MarkerArray
        A disc and a line, of :func:`robot_markers`; or one marker that is deleted.
    frame : str
        Frame of the map.

    Returns
    -------
    RobotOnMap or str
        The robot, or the name of one that has left.

    Raises
    ------
    InvalidMessage
        If it is something else, or in another frame.
    InvalidPose
        If a position is not valid.
    """
    what = "message on '/fleet/robots'"
    markers = {marker.id: marker for marker in message.markers}
    if _BODY not in markers or len(markers) > 2:
        raise InvalidMessage(what, 'it must have the markers 0, a disc, and 1, its path')
    body, path = markers[_BODY], markers.get(_PATH)
    name = checked_name(body.ns, what)
    if body.action == Marker.DELETE:
        return name
    check_frame(what, body.header.frame_id, frame)
    if not 0.0 < body.scale.x <= 2.0 * _LARGEST:
        raise InvalidMessage(what, f'the disc is {body.scale.x} m wide; 0 to 20 m are valid')
    points = [] if path is None else path.points
    if len(points) > LONGEST_PLAN:
        raise InvalidMessage(what, f'its path has {len(points)} points; {LONGEST_PLAN} are most')
    line = [position_from_message(point, 'point of a path')[:2] for point in points]
    pose = pose_from_message(body.pose, 'pose of a robot')
    corners = np.array(line, dtype=float).reshape(-1, 2)
    from_here = np.vstack([[pose.x, pose.y], corners])
    length = float(np.linalg.norm(np.diff(from_here, axis=0), axis=1).sum())
    if length > _LONGEST:
        raise InvalidMessage(what, f'its path is {length:.4g} m long; {_LONGEST:.0f} m are most')
    radius, has_fallen = body.scale.x / 2.0, body.text == _FALLEN
    if has_fallen:
        corners = np.empty((0, 2))
    return RobotOnMap(name, pose, radius, corners, body.text == _GOES_FIRST, has_fallen)
