"""
Transforms of a robot's links, for recordings of robots whose links nobody publishes.

RViz and Foxglove draw a robot by the transforms of its links. On a robot that is looked at live
they come from robot_state_publisher; a recording holds them itself, so that it plays by itself.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable
from typing import Any, NamedTuple

from nav_msgs.msg import Odometry
from rosbags.typesys import Stores, get_typestore
from sensor_msgs.msg import JointState
from std_msgs.msg import String

from quad_lab.recordings.subscription import message_of
from quad_view.scene.robot_model import RobotModel, model_from_urdf

_PERIOD = 0.04
"""Time between two transforms of a link [s]: as often as a film has pictures."""

_STAMP = struct.Struct('<iI')
"""Seconds and nanoseconds with which a message with a header begins."""

_HEADER = 4 + _STAMP.size

_TYPES = get_typestore(Stores.ROS2_JAZZY)
# They need no package of ROS: tf2_msgs is not there for everybody.
_Header: Any = _TYPES.types['std_msgs/msg/Header']
_Time: Any = _TYPES.types['builtin_interfaces/msg/Time']
_Vector3: Any = _TYPES.types['geometry_msgs/msg/Vector3']
_Quaternion: Any = _TYPES.types['geometry_msgs/msg/Quaternion']
_Transform: Any = _TYPES.types['geometry_msgs/msg/Transform']
_TransformStamped: Any = _TYPES.types['geometry_msgs/msg/TransformStamped']
_TFMessage: Any = _TYPES.types['tf2_msgs/msg/TFMessage']


class _Place(NamedTuple):
    """A frame in another one."""

    parent: str
    child: str
    position: Iterable[float]
    turn: Iterable[float]


class RobotTransforms:
    """
    Works out, from what a robot publishes, where its links are.

    Parameters
    ----------
    has_body : bool
        Whether somebody publishes where the body is.
    has_links : bool
        Whether somebody publishes where the links are.
    """

    def __init__(self, has_body: bool, has_links: bool) -> None:
        self._has_body = has_body
        self._has_links = has_links
        self._model: RobotModel | None = None
        self._moving: list[int] = []
        self._last = {'body': -math.inf, 'links': -math.inf}

    def of_description(self, data: bytes) -> bytes | None:
        """
        Take a robot's description.

        Parameters
        ----------
        data : bytes
            A std_msgs/String (CDR).

        Returns
        -------
        bytes or None
            A TFMessage (CDR) of the links that do not move; None if there is nothing to be said.

        Raises
        ------
        InvalidMessage
            If it is no URDF.
        """
        if self._has_links:
            return None
        self._model = model = model_from_urdf(message_of(data, String).data)
        self._moving = [k for k, name in enumerate(model.joint_names) if name]
        below = [k for k, link in enumerate(model.links) if link.parent >= 0]
        still = [k for k in below if k not in self._moving]
        return _message(_Time(sec=0, nanosec=0), self._links(still, {})) if still else None

    def of_joints(self, data: bytes) -> bytes | None:
        """
        Take a sensor_msgs/JointState (CDR).

        Returns
        -------
        bytes or None
            A TFMessage (CDR) of the links that move; None if there is nothing to be said.
        """
        if self._model is None or not self._is_due('links', data):
            return None
        message = message_of(data, JointState)
        positions = dict(zip(message.name, message.position))
        if not all(map(math.isfinite, positions.values())):
            return None
        return _message(_stamp(data), self._links(self._moving, positions))

    def of_body(self, data: bytes) -> bytes | None:
        """
        Take a nav_msgs/Odometry (CDR).

        Returns
        -------
        bytes or None
            A TFMessage (CDR) of the body; None if there is nothing to be said.
        """
        if self._has_body or not self._is_due('body', data):
            return None
        message = message_of(data, Odometry)
        p, q = message.pose.pose.position, message.pose.pose.orientation
        numbers = (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)
        if not all(math.isfinite(number) for part in numbers for number in part):
            return None
        place = _Place(message.header.frame_id, message.child_frame_id, *numbers)
        return _message(_stamp(data), [place])

    def _links(self, links: list[int], positions: dict[str, float]) -> list[_Place]:
        assert self._model is not None
        model = self._model
        places, turns = model.poses(positions)
        return [
            _Place(
                model.links[model.links[k].parent].name,
                model.links[k].name,
                places[k].tolist(),
                turns[k].tolist(),
            )
            for k in links
        ]

    def _is_due(self, what: str, data: bytes) -> bool:
        """Return whether the last transforms are some time ago, or the clock was set back."""
        if len(data) < _HEADER:
            return False
        seconds, nanoseconds = _STAMP.unpack_from(data, 4)
        time = seconds + 1e-9 * nanoseconds
        if 0.0 <= time - self._last[what] < _PERIOD - 1e-6:
            return False
        self._last[what] = time
        return True


def map_transform(map_frame: str, odometry: bytes) -> bytes:
    """Make a TFMessage (CDR) in which odometry's frame coincides with the map's."""
    frame = message_of(odometry, Odometry).header.frame_id
    at_origin = _Place(map_frame, frame, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
    return _message(_stamp(odometry), [at_origin])


def _stamp(data: bytes) -> Any:
    seconds, nanoseconds = _STAMP.unpack_from(data, 4)
    return _Time(sec=seconds, nanosec=nanoseconds)


def _message(stamp: Any, places: Iterable[_Place]) -> bytes:
    transforms = [
        _TransformStamped(
            header=_Header(stamp=stamp, frame_id=place.parent),
            child_frame_id=place.child,
            transform=_Transform(
                translation=_Vector3(*place.position), rotation=_Quaternion(*place.turn)
            ),
        )
        for place in places
    ]
    return bytes(_TYPES.serialize_cdr(_TFMessage(transforms), 'tf2_msgs/msg/TFMessage'))
