"""
Transforms of a robot's links, for recordings of robots whose links nobody publishes.

RViz and Foxglove draw a robot by the transforms of its links. On a robot that is looked at live
they come from robot_state_publisher; a recording holds them itself, so that it plays by itself.
"""

from __future__ import annotations

import math
import struct
from typing import Any

from nav_msgs.msg import Odometry
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import String

from quad_common.errors import InvalidMessage
from quad_lab.recordings.subscription import message_of
from quad_lab.recordings.transform_pattern import TransformPattern
from quad_view.scene.robot_model import RobotModel, model_from_urdf

_PERIOD = 0.04
"""Time between two transforms of a link [s]: as often as a film has pictures."""

_TYPES = get_typestore(Stores.ROS2_JAZZY)

_STAMP = struct.Struct('<iI')
"""Seconds and nanoseconds with which a message with a header begins."""

_HEADER = 4 + _STAMP.size


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
        self._moved: TransformPattern | None = None
        self._body: tuple[tuple[str, str], TransformPattern] | None = None
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
        self._moved = TransformPattern(self._frames(self._moving)) if self._moving else None
        if not still:
            return None
        positions, turns = model.poses({})
        pattern = TransformPattern(self._frames(still))
        return pattern.fill((0, 0), positions[still].tolist(), turns[still].tolist())

    def of_joints(self, data: bytes) -> bytes | None:
        """
        Take a sensor_msgs/JointState (CDR).

        Returns
        -------
        bytes or None
            A TFMessage (CDR) of the links that move; None if there is nothing to be said.
        """
        if self._model is None or self._moved is None or not self._is_due('links', data):
            return None
        message = _read(data, 'sensor_msgs/msg/JointState')
        joints = dict(zip(message.name, message.position))
        if not all(map(math.isfinite, joints.values())):
            return None
        positions, turns = self._model.poses(joints)
        return self._moved.fill(
            _stamp(data), positions[self._moving].tolist(), turns[self._moving].tolist()
        )

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
        message = _read(data, 'nav_msgs/msg/Odometry')
        p, q = message.pose.pose.position, message.pose.pose.orientation
        numbers = (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)
        if not all(math.isfinite(number) for part in numbers for number in part):
            return None
        frames = message.header.frame_id, message.child_frame_id
        if self._body is None or self._body[0] != frames:
            self._body = frames, TransformPattern([frames])
        return self._body[1].fill(_stamp(data), numbers[:1], numbers[1:])

    def _frames(self, links: list[int]) -> list[tuple[str, str]]:
        """Return parent and child of the transforms of some links."""
        assert self._model is not None
        names = [link.name for link in self._model.links]
        return [(names[self._model.links[k].parent], names[k]) for k in links]

    def _is_due(self, what: str, data: bytes) -> bool:
        """Return whether the last transforms are some time ago, or the clock was set back."""
        if len(data) < _HEADER:
            return False
        seconds, nanoseconds = _stamp(data)
        time = seconds + 1e-9 * nanoseconds
        if 0.0 <= time - self._last[what] < _PERIOD - 1e-6:
            return False
        self._last[what] = time
        return True


def map_transform(map_frame: str, odometry: bytes) -> bytes:
    """Make a TFMessage (CDR) in which odometry's frame coincides with the map's."""
    frame = message_of(odometry, Odometry).header.frame_id
    pattern = TransformPattern([(map_frame, frame)])
    return pattern.fill(_stamp(odometry), [(0.0, 0.0, 0.0)], [(0.0, 0.0, 0.0, 1.0)])


def _read(data: bytes, kind: str) -> Any:
    """Read a message a few times as fast as rclpy does, which makes objects of all its parts."""
    try:
        return _TYPES.deserialize_cdr(data, kind)
    except Exception as error:
        # Made for the kind of message, the reader fails in any of many ways.
        raise InvalidMessage('message', f'its bytes are no {kind}') from error


def _stamp(data: bytes) -> tuple[int, int]:
    """Return seconds and nanoseconds of a message with a header."""
    seconds, nanoseconds = _STAMP.unpack_from(data, 4)
    return seconds, nanoseconds
