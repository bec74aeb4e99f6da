"""
Opening files that somebody names: never more than a stated size, and nothing that blocks.

A pipe, a device or a directory is refused before it is read or written: a pipe that no process
writes to would block forever.
"""

from __future__ import annotations

import os
import stat
from pathlib import Path

from quad_common.errors import FileUnusable
from quad_common.files.package_path import is_in_package, package_candidates
from quad_common.files.unblocked_file import open_unblocked

LARGEST_TEXT = 2**18
"""Bytes of the largest text file that is read: shipped ones have less than 10 000."""

LARGEST_IMAGE = 2**29
"""Bytes of the largest file of an image that is read."""


def user_path(path: str | Path, what: str = 'file') -> Path:
    """
    Return the path of a file as a person names it.

    Parameters
    ----------
    path : str or Path
        A path, in which ``~`` is the home directory, or ``package://PACKAGE/path``: that is
        looked for in the ROS packages that are installed.
    what : str
        What it is, for the error's sentence.

    Returns
    -------
    Path
        Of a package's file that is not there, as it was named.

    Raises
    ------
    FileUnusable
        If there is no such user.
    """
    if is_in_package(str(path)):
        candidates = package_candidates(str(path))
        return next((found for found in candidates if is_file(found)), Path(path))
    try:
        return Path(path).expanduser()
    except RuntimeError as error:
        raise FileUnusable(what, path, 'is in the home of a user who does not exist') from error


def is_file(path: str | Path) -> bool:
    """Return whether a path is a regular file; False too if it cannot be looked at."""
    try:
        return Path(path).is_file()
    except (OSError, ValueError):
        # Too long a name, a folder that may not be entered, a null byte.
        return False


def is_folder(path: str | Path) -> bool:
    """Return whether a path is a folder; False too if it cannot be looked at."""
    try:
        return Path(path).is_dir()
    except (OSError, ValueError):
        return False


def path_exists(path: str | Path) -> bool:
    """Return whether anything is at a path, be it a file or not; True if it cannot be known."""
    try:
        Path(path).stat()
    except (FileNotFoundError, NotADirectoryError):
        return False
    except (OSError, ValueError):
        return True
    return True


def read_bytes(path: Path, what: str = 'file', limit: int = LARGEST_TEXT) -> bytes:
    """
    Read a regular file whole.

    Parameters
    ----------
    path : Path
        The file.
    what : str
        What it is, for the error's sentence.
    limit : int
        Largest size [bytes].

    Returns
    -------
    bytes
        What the file holds.

    Raises
    ------
    FileUnusable
        If it cannot be read, is no regular file, or is larger.
    """
    # Sizes are not trusted: files of /proc say 0.
    content = read_head(path, what, limit + 1)
    if len(content) > limit:
        raise FileUnusable(
            what, path, f'cannot be read: it has more than {limit} bytes, which is the limit'
        )
    return content


def read_head(path: Path, what: str, count: int) -> bytes:
    """Read the beginning of a regular file, `count` bytes; raise FileUnusable."""
    try:
        with open_unblocked(path) as file:
            mode = os.fstat(file.fileno()).st_mode
            if not stat.S_ISREG(mode):
                raise FileUnusable(what, path, f'cannot be read: it is {_kind(mode)}, not a file')
            return file.read(count)
    except (OSError, ValueError) as error:
        raise FileUnusable(what, path, f'cannot be read: {reason_of(error)}') from error


def read_text(path: Path, what: str = 'file', limit: int = LARGEST_TEXT) -> str:
    """Read a regular file of UTF-8; parameters and errors as of :func:`read_bytes`."""
    try:
        return read_bytes(path, what, limit).decode('utf-8')
    except UnicodeDecodeError as error:
        raise FileUnusable(
            what, path, f'cannot be read: it is not UTF-8 from byte {error.start} on'
        ) from error


def make_folder(path: Path, what: str = 'folder') -> None:
    """Make a folder and those above it, where they are not there; raise FileUnusable."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        raise FileUnusable(what, path, f'cannot be made: {reason_of(error)}') from error


def check_target(path: Path, what: str = 'file') -> None:
    """
    Refuse to write where something else than a regular file is, or nothing may be written.

    Parameters
    ----------
    path : Path
        The file that is to be written; its folder may still have to be made.
    what : str
        What it is, for the error's sentence.

    Raises
    ------
    FileUnusable
        If it is a directory, a pipe or a device, or may not be written.
    """
    try:
        mode = Path(path).stat().st_mode
    except FileNotFoundError:
        _check_folder(path, path.parent, what)
        return
    except (OSError, ValueError) as error:
        raise FileUnusable(what, path, f'cannot be written: {reason_of(error)}') from error
    if not stat.S_ISREG(mode):
        raise FileUnusable(what, path, f'cannot be written: it is {_kind(mode)}, not a file')
    if not os.access(path, os.W_OK):
        raise FileUnusable(what, path, 'cannot be written: Permission denied')


def check_folder_target(path: Path, what: str = 'folder') -> None:
    """Refuse a folder for results that is none, or cannot be made or written; FileUnusable."""
    _check_folder(path, path, what)


def _check_folder(target: Path, folder: Path, what: str) -> None:
    """Check the nearest folder that is there."""
    try:
        while not folder.exists() and folder != folder.parent:
            folder = folder.parent
        is_folder = folder.is_dir()
    except (OSError, ValueError) as error:
        raise FileUnusable(what, target, f'cannot be written: {reason_of(error)}') from error
    if not is_folder:
        raise FileUnusable(what, target, f'cannot be written: {folder} is not a folder')
    if not os.access(folder, os.W_OK | os.X_OK):
        raise FileUnusable(
            what, target, f'cannot be written: nothing may be written to the folder {folder}'
        )


def _kind(mode: int) -> str:
    for is_of_kind, name in (
        (stat.S_ISDIR, 'a directory'),
        (stat.S_ISFIFO, 'a pipe'),
        (stat.S_ISSOCK, 'a socket'),
        (stat.S_ISCHR, 'a device'),
        (stat.S_ISBLK, 'a device'),
    ):
        if is_of_kind(mode):
            return name
    return 'something else'


def reason_of(error: OSError | ValueError) -> str:
    """Return why a file cannot be read or written, in the system's own words."""
    return str(getattr(error, 'strerror', None) or error)
