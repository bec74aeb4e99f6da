"""
The transforms of one robot among those that many robots publish on the same topic.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

from rosbags.typesys import Stores, get_typestore

from quad_common.errors import InvalidMessage

_TYPES = get_typestore(Stores.ROS2_JAZZY)

_KIND = 'tf2_msgs/msg/TFMessage'


def transforms_in(data: bytes) -> Sequence[Any]:
    """
    Read the transforms of a TFMessage (CDR), without a package of ROS.

    Raises
    ------
    InvalidMessage
        If it is none.
    """
    try:
        return _TYPES.deserialize_cdr(data, _KIND).transforms  # type: ignore[attr-defined, no-any-return]
    except Exception as error:
        # Made for the kind of message, the reader fails in any of many ways.
        raise InvalidMessage('message', f'its bytes are no {_KIND}') from error


def with_prefix(data: bytes, prefix: str) -> bytes | None:
    """
    Leave the transforms whose child's name begins with a robot's prefix.

    Parameters
    ----------
    data : bytes
        A TFMessage (CDR).
    prefix : str
        What the names of the robot's frames begin with; not empty.

    Returns
    -------
    bytes or None
        As it is, if all of them are the robot's; None if none is.

    Raises
    ------
    InvalidMessage
        If it is no such message.
    """
    # Most are of one robot: those of others need not be taken apart.
    if prefix.encode() not in data:
        return None
    transforms = transforms_in(data)
    own = [part for part in transforms if part.child_frame_id.startswith(prefix)]
    if not own:
        return None
    return data if len(own) == len(transforms) else _message(own)


def _message(transforms: Iterable[Any]) -> bytes:
    message = _TYPES.types[_KIND](list(transforms))
    return bytes(_TYPES.serialize_cdr(message, _KIND))
