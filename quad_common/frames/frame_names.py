"""
Frames in which something may be given.
"""

from __future__ import annotations

from quad_common.errors import InvalidMessage
from quad_common.errors.quoting import quoted


def check_frame(what: str, frame: str, *frames: str) -> None:
    """
    Check that something is given in a frame that is known.

    Parameters
    ----------
    what : str
        Name of what is given, for the error.
    frame : str
        Frame in which it is.
    *frames : str
        Frames in which it may be; the error recommends the first one.

    Raises
    ------
    InvalidMessage
        If it is in another one.
    """
    if frame not in frames:
        raise InvalidMessage(
            what, f'it is in frame {quoted(frame)}; give it in {quoted(frames[0])}'
        )
