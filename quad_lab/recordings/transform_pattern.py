"""
Messages of transforms (tf2_msgs/TFMessage) between the same frames, again and again.

To make one out of objects takes ten times as long as to fill in the numbers of the last one.
"""

from __future__ import annotations

import struct
from collections.abc import Sequence

from rosbags.typesys import Stores, get_typestore

_TYPES = get_typestore(Stores.ROS2_JAZZY)

_START = 4
"""Bytes that say how numbers are written; places of numbers are counted from behind them."""

_STAMP = struct.Struct('<iI')
"""Seconds and nanoseconds."""

Rows = Sequence[Sequence[float]]

_NUMBERS = struct.Struct('<7d')
"""Position and orientation."""


class TransformPattern:
    """
    A message whose frames stay, and whose time and numbers are filled in.

    Parameters
    ----------
    frames : sequence of (str, str)
        Parent and child of each transform.
    """

    def __init__(self, frames: Sequence[tuple[str, str]]) -> None:
        # They need no package of ROS: tf2_msgs is not there for everybody.
        kinds = _TYPES.types
        stamp = kinds['builtin_interfaces/msg/Time'](sec=0, nanosec=0)
        unit = kinds['geometry_msgs/msg/Transform'](
            translation=kinds['geometry_msgs/msg/Vector3'](0.0, 0.0, 0.0),
            rotation=kinds['geometry_msgs/msg/Quaternion'](0.0, 0.0, 0.0, 1.0),
        )
        transforms = [
            kinds['geometry_msgs/msg/TransformStamped'](
                header=kinds['std_msgs/msg/Header'](stamp=stamp, frame_id=parent),
                child_frame_id=child,
                transform=unit,
            )
            for parent, child in frames
        ]
        message = kinds['tf2_msgs/msg/TFMessage'](transforms)
        self._data = bytearray(_TYPES.serialize_cdr(message, 'tf2_msgs/msg/TFMessage'))
        self._places = _places(frames)

    def fill(self, stamp: tuple[int, int], positions: Rows, turns: Rows) -> bytes:
        """
        Make a message.

        Parameters
        ----------
        stamp : tuple of int
            Seconds and nanoseconds of every transform.
        positions : sequence of sequences
            Position of each child in its parent's frame, shape (n, 3) [m].
        turns : sequence of sequences
            Orientation of each, quaternions xyzw, shape (n, 4).

        Returns
        -------
        bytes
            The message (CDR).
        """
        data = self._data
        for (at_stamp, at_numbers), position, turn in zip(
            self._places, positions, turns, strict=True
        ):
            _STAMP.pack_into(data, at_stamp, *stamp)
            _NUMBERS.pack_into(data, at_numbers, *position, *turn)
        return bytes(data)


def _places(frames: Sequence[tuple[str, str]]) -> list[tuple[int, int]]:
    """Return where in a message the stamp and the numbers of each transform begin."""
    places = []
    # The number of transforms comes first.
    end = _START + 4
    for parent, child in frames:
        at_stamp = _aligned(end, 4)
        at_child = _aligned(_behind_text(at_stamp + _STAMP.size, parent), 4)
        at_numbers = _aligned(_behind_text(at_child, child), 8)
        places.append((at_stamp, at_numbers))
        end = at_numbers + _NUMBERS.size
    return places


def _behind_text(begin: int, text: str) -> int:
    """Return where a text ends: its length stands before it, and a zero behind it."""
    return begin + 4 + len(text.encode()) + 1


def _aligned(place: int, size: int) -> int:
    """Return the next place where a number of some bytes can stand."""
    return place + (_START - place) % size
