"""
Transforms of a robot's links, for recordings of robots whose links nobody publishes.

RViz and Foxglove draw a robot by the transforms of its links. On a robot that is looked at live
they come from robot_state_publisher; a recording holds them itself, so that it plays by itself.
"""

from __future__ import annotations

import math
import struct
from dataclasses import dataclass
from typing import Any

from nav_msgs.msg import Odometry
from rosbags.typesys import Stores, get_typestore
from std_msgs.msg import String

from quad_common.errors import InvalidMessage
from quad_lab.recordings.recorded_topics import (
    FIXED_TRANSFORMS,
    SHARED_FIXED_TRANSFORMS,
    SHARED_TRANSFORMS,
    TRANSFORMS,
    RecordedTopic,
)
from quad_lab.recordings.shared_transforms import transforms_in
from quad_lab.recordings.subscription import message_of
from quad_lab.recordings.transform_pattern import TransformPattern
from quad_view.scene.robot_model import RobotModel, model_from_urdf

_PERIOD = 0.04
"""Time between two transforms of a link [s]: as often as a film has pictures."""

_PATIENCE = 1.0
"""Time of odometry in which others' transforms of the body come, if they do [s]."""

_MOST_FRAMES = 2000
"""Names of others' frames that are remembered."""

_TYPES = get_typestore(Stores.ROS2_JAZZY)

_STAMP = struct.Struct('<iI')
"""Seconds and nanoseconds with which a message with a header begins."""

_HEADER = 4 + _STAMP.size

Made = tuple[RecordedTopic, bytes]
"""Topic of transforms, and a TFMessage (CDR) for it."""


@dataclass(frozen=True)
class Others:
    """What others publish, as it was discovered: the rest is to be worked out."""

    has_body: bool = TRANSFORMS.message_type() is not None
    """Whether somebody publishes transforms of bodies; whether of this one, is seen by them."""
    has_links: bool = False
    """Whether somebody publishes where the robot's links are."""
    has_odometry: bool = True
    """Whether there will be odometry, which tells how the robot's frames are called."""


class RobotTransforms:
    """
    Works out, from what a robot publishes, where its links are.

    Frames of links begin as those of odometry do: robots in one world have ``robot1/base_link``
    where their descriptions have ``base_link``.

    Parameters
    ----------
    others : Others
        What others publish.
    """

    def __init__(self, others: Others) -> None:
        self._others = others
        self._model: RobotModel | None = None
        self._moving: list[int] = []
        self._moved: TransformPattern | None = None
        self._frames: tuple[str, str] | None = None
        self._body: TransformPattern | None = None
        self._published: set[str] = set()
        self._first: float | None = None
        self._last = {'body': -math.inf, 'links': -math.inf}

    @property
    def prefix(self) -> str | None:
        """What the names of the robot's frames begin with; None as long as it is not known."""
        if self._frames is None:
            return None if self._others.has_odometry else ''
        frame = self._frames[1]
        if self._model is not None:
            root = next(link.name for link in self._model.links if link.parent < 0)
            if frame.endswith(root):
                return frame.removesuffix(root)
        name, slash, _ = frame.rpartition('/')
        return name + slash

    @property
    def has_own_body(self) -> bool:
        """Whether the body's transforms are made here, as nobody else's have come."""
        return self._body is not None

    def of_description(self, data: bytes) -> list[Made]:
        """
        Take a robot's description.

        Parameters
        ----------
        data : bytes
            A std_msgs/String (CDR).

        Returns
        -------
        list of Made
            Transforms of the links that do not move, if their frames' names are known already.

        Raises
        ------
        InvalidMessage
            If it is no URDF.
        """
        if self._others.has_links:
            return []
        self._model = model_from_urdf(message_of(data, String).data)
        self._moved = None
        return self._of_still_links()

    def of_joints(self, data: bytes) -> list[Made]:
        """Take a sensor_msgs/JointState (CDR); return transforms of the links that move."""
        if self._model is None or self._moved is None or not self._is_due('links', data):
            return []
        message = _read(data, 'sensor_msgs/msg/JointState')
        joints = dict(zip(message.name, message.position))
        if not all(map(math.isfinite, joints.values())):
            return []
        positions, turns = self._model.poses(joints)
        made = self._moved.fill(
            _stamp(data), positions[self._moving].tolist(), turns[self._moving].tolist()
        )
        return [(self._topics[0], made)]

    def of_odometry(self, data: bytes) -> list[Made]:
        """Take a nav_msgs/Odometry (CDR); return transforms of the body, unless others do."""
        if self._frames is not None and self._is_published:
            return []
        if not self._is_due('body', data):
            return []
        message = _read(data, 'nav_msgs/msg/Odometry')
        made: list[Made] = []
        frames = message.header.frame_id, message.child_frame_id
        if self._frames != frames:
            self._frames, self._body = frames, None
            made = self._of_still_links()
        time = self._last['body']
        self._first = time if self._first is None else self._first
        is_waiting = self._others.has_body and 0.0 <= time - self._first < _PATIENCE
        if self._is_published or is_waiting:
            return made
        p, q = message.pose.pose.position, message.pose.pose.orientation
        numbers = (p.x, p.y, p.z), (q.x, q.y, q.z, q.w)
        if not all(math.isfinite(number) for part in numbers for number in part):
            return made
        self._body = self._body or TransformPattern([frames])
        return [*made, (self._topics[0], self._body.fill(_stamp(data), numbers[:1], numbers[1:]))]

    def of_others(self, data: bytes) -> None:
        """Take a TFMessage (CDR) by others: what they publish is not made here."""
        if not self._is_published and len(self._published) < _MOST_FRAMES:
            self._published.update(part.child_frame_id for part in transforms_in(data))

    def of_map(self, odometry: bytes) -> list[Made]:
        """Have odometry's frame coincide with the map's, if nobody else says where it is."""
        if not self.has_own_body or self._frames is None or self._frames[0] in self._published:
            return []
        return [(self._topics[1], map_transform('map', odometry))]

    @property
    def _is_published(self) -> bool:
        """Whether somebody else has published where the body is."""
        return self._frames is not None and self._frames[1] in self._published

    @property
    def _topics(self) -> tuple[RecordedTopic, RecordedTopic]:
        """Where its transforms go that change, and the others."""
        # Names with a prefix do not collide with other robots'.
        if self.prefix:
            return SHARED_TRANSFORMS, SHARED_FIXED_TRANSFORMS
        return TRANSFORMS, FIXED_TRANSFORMS

    def _of_still_links(self) -> list[Made]:
        """Make the transforms of links that do not move, and prepare those of the others."""
        model = self._model
        if model is None or self.prefix is None:
            return []
        self._moving = [k for k, name in enumerate(model.joint_names) if name]
        below = [k for k, link in enumerate(model.links) if link.parent >= 0]
        still = [k for k in below if k not in self._moving]
        self._moved = TransformPattern(self._frames_of(self._moving)) if self._moving else None
        if not still:
            return []
        positions, turns = model.poses({})
        pattern = TransformPattern(self._frames_of(still))
        made = pattern.fill((0, 0), positions[still].tolist(), turns[still].tolist())
        return [(self._topics[1], made)]

    def _frames_of(self, links: list[int]) -> list[tuple[str, str]]:
        """Return parent and child of the transforms of some links."""
        assert self._model is not None
        names = [f'{self.prefix}{link.name}' for link in self._model.links]
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
