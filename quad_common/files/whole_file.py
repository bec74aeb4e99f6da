"""
Files that are whole or not there: written beside their place, and put there at once.

A disk that is full, a signal or a closed network share leaves what was there before, and nothing
half written.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import stat
from collections.abc import Iterator
from pathlib import Path

from quad_common.errors import FileUnusable
from quad_common.files.bounded_file import check_target, reason_of


@contextlib.contextmanager
def whole_file(path: Path, what: str = 'file') -> Iterator[Path]:
    """
    Give a path to write to; what is written there takes the place of the file in the end.

    Parameters
    ----------
    path : Path
        The file; one that is there is replaced if the block ends without an error, and stays as
        it is otherwise.
    what : str
        What it is, for the error's sentence.

    Yields
    ------
    Path
        In the same folder, with the same suffix. It is the file itself where only that may be
        written, not its folder.

    Raises
    ------
    FileUnusable
        If it cannot be written, or something else than a regular file is there.
    """
    check_target(path, what)
    try:
        # What a link leads to is replaced, not the link.
        target = path.resolve()
        if target.exists() and not os.access(target.parent, os.W_OK | os.X_OK):
            yield target
            return
        beside = target.with_name(f'.{secrets.token_hex(6)}{target.suffix}')
        try:
            yield beside
            if target.exists():
                beside.chmod(stat.S_IMODE(target.stat().st_mode))
            beside.replace(target)
        except BaseException:
            with contextlib.suppress(OSError):
                beside.unlink(missing_ok=True)
            raise
    except (OSError, ValueError) as error:
        raise FileUnusable(what, path, f'cannot be written: {reason_of(error)}') from error


def write_text(path: Path, text: str, what: str = 'file') -> None:
    """
    Write a regular file of UTF-8.

    Parameters
    ----------
    path : Path
        The file; one that is there is replaced.
    text : str
        What it is to hold.
    what : str
        What it is, for the error's sentence.

    Raises
    ------
    FileUnusable
        If it cannot be written, or something else than a regular file is there.
    """
    with whole_file(path, what) as beside:
        beside.write_text(text, encoding='utf-8')


def write_bytes(path: Path, content: bytes, what: str = 'file') -> None:
    """Write a regular file; parameters and errors as of :func:`write_text`."""
    with whole_file(path, what) as beside:
        beside.write_bytes(content)
