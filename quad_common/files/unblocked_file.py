"""
Opening files for reading without waiting for whoever writes to them.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import BinaryIO


def open_unblocked(path: Path) -> BinaryIO:
    """
    Open a file for reading bytes; a pipe that no process writes to is opened at once.

    Parameters
    ----------
    path : Path
        Anything that has a name; the caller looks at what it is before reading.

    Returns
    -------
    BinaryIO
        The open file.

    Raises
    ------
    OSError, ValueError
        If it cannot be opened.
    """
    return open(path, 'rb', opener=_opener)


def _opener(path: str, flags: int) -> int:
    return os.open(path, flags | os.O_NONBLOCK | os.O_CLOEXEC)
