"""
Conversions between markers and the obstacles of a simulated world.
"""

from __future__ import annotations

from collections.abc import Mapping

from visualization_msgs.msg import Marker, MarkerArray

from quad_common.errors import InvalidMessage, InvalidPose, ParameterError
from quad_common.errors.quoting import quoted
from quad_common.frames.frame_names import check_frame
from quad_common.ros.pose_conversions import checked_name, pose_from_message, pose_message
from quad_common.vision.markers import Color
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.world import Obstacle

_SIZES = (1e-3, 100.0)
"""Least and largest side of an obstacle [m]."""

_MOST_MARKERS = 1000
"""Largest number of markers in one message."""

MOST_OBSTACLE_BYTES = 1_000_000
"""Largest size of a message with obstacles; a marker has some three hundred [bytes]."""


def obstacle_changes_from_message(
    message: MarkerArray, frames: tuple[str, ...]
) -> list[ObstacleChange]:
    """
    Read which obstacles come and go.

    Parameters
    ----------
    message : visualization_msgs/MarkerArray
        Cubes and cylinders that are added, moved or deleted. They stand on the floor: heights
        of their poses, and roll and pitch, are not used.
    frames : tuple of str
        In which poses may be given.

    Returns
    -------
    list of ObstacleChange
        In order; names are namespace and id.

    Raises
    ------
    InvalidMessage
        If there are too many, or a marker is something else.
    """
    if len(message.markers) > _MOST_MARKERS:
        raise InvalidMessage(
            "message on 'obstacles'",
            f'it has {len(message.markers)} markers; {_MOST_MARKERS} are the most',
        )
    return [_obstacle_change(marker, frames) for marker in message.markers]


def _obstacle_change(marker: Marker, frames: tuple[str, ...]) -> ObstacleChange:
    name = (marker.ns, marker.id)
    what = f"marker {quoted(marker.ns)} {marker.id} on 'obstacles'"
    checked_name(marker.ns, what)
    if marker.action == Marker.DELETEALL:
        return ObstacleChange(None, None)
    if marker.action == Marker.DELETE:
        return ObstacleChange(name, None)
    if marker.action != Marker.ADD:
        raise InvalidMessage(
            what, f'its action is {marker.action}; known are ADD 0, DELETE 2 and DELETEALL 3'
        )
    kinds = {Marker.CUBE: 'box', Marker.CYLINDER: 'cylinder'}
    if marker.type not in kinds:
        raise InvalidMessage(what, f'its type is {marker.type}; known are CUBE 1 and CYLINDER 3')
    check_frame(what, marker.header.frame_id, *frames)
    color = marker.color
    parts = (color.r, color.g, color.b, color.a)
    if not all(0.0 <= part <= 1.0 for part in parts):
        raise InvalidMessage(what, f'its color r, g, b, a is {parts}; each must be from 0 to 1')
    red, green, blue = (round(255.0 * part) for part in parts[:3])
    size = marker.scale
    low, high = _SIZES
    if not all(low <= side <= high for side in (size.x, size.y, size.z)):
        raise InvalidMessage(
            what,
            f'it is ({size.x}, {size.y}, {size.z}) m large; each side must be from {low:g} '
            f'to {high:g} m',
        )
    try:
        pose = pose_from_message(marker.pose)
        obstacle = Obstacle(
            kinds[marker.type],
            pose,
            size.x,
            size.y,
            size.z,
            # A color that is not set is black and transparent.
            (red, green, blue) if any(parts) else None,
        )
    except (InvalidPose, ParameterError) as error:
        raise InvalidMessage(what, str(error)) from error
    return ObstacleChange(name, obstacle)


def obstacles_message(
    obstacles: Mapping[tuple[str, int], Obstacle], frame: str, color: Color
) -> MarkerArray:
    """
    Write which obstacles stand.

    Parameters
    ----------
    obstacles : mapping of tuple to Obstacle
        Obstacles by namespace and id.
    frame : str
        Frame of their poses.
    color : tuple of int
        Color of those without one: red, green and blue, 0 to 255.

    Returns
    -------
    visualization_msgs/MarkerArray
        Their markers, after one that takes away whatever was shown before.
    """
    markers = [Marker(action=Marker.DELETEALL)]
    kinds = {'box': Marker.CUBE, 'cylinder': Marker.CYLINDER}
    for (space, number), obstacle in obstacles.items():
        marker = Marker(ns=space, id=number, type=kinds[obstacle.kind], action=Marker.ADD)
        marker.header.frame_id = frame
        marker.pose = pose_message(obstacle.pose)
        marker.pose.position.z = 0.5 * obstacle.height
        size = marker.scale
        size.x, size.y = float(obstacle.length), float(obstacle.width)
        size.z = float(obstacle.height)
        red, green, blue = (part / 255.0 for part in obstacle.color or color)
        marker.color.r, marker.color.g, marker.color.b, marker.color.a = red, green, blue, 1.0
        markers.append(marker)
    return MarkerArray(markers=markers)
