"""
Temporary folders that do not stay behind: not at a signal, and not for good at a kill.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path

from quad_common.process.end_signals import released_at_last, shielded

PREFIX = 'quadwalk_'

_OWNER = 'owner.pid'
"""A file in each folder: its process holds it locked, and has written its id into it."""


@contextlib.contextmanager
def temporary_folder() -> Iterator[Path]:
    """
    Make a temporary folder, which is removed when the block or the process ends.

    What processes left that were killed is removed first.

    Yields
    ------
    Path
        The folder.
    """
    remove_ownerless()
    with contextlib.ExitStack() as stack:
        with shielded():
            folder = Path(tempfile.mkdtemp(prefix=PREFIX))
            owner = os.open(folder / _OWNER, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
            stack.callback(os.close, owner)
            stack.callback(shutil.rmtree, folder, ignore_errors=True)
            fcntl.flock(owner, fcntl.LOCK_EX)
            os.write(owner, str(os.getpid()).encode())
            stack.enter_context(released_at_last(lambda: shutil.rmtree(folder, ignore_errors=True)))
        try:
            yield folder
        finally:
            # A signal that came while the folder is removed would leave a part of it.
            with shielded():
                stack.close()


def ownerless_folders() -> list[Path]:
    """List the folders whose processes have ended without removing them."""
    return [
        folder
        for folder in sorted(Path(tempfile.gettempdir()).glob(f'{PREFIX}*'))
        if _is_ownerless(folder / _OWNER)
    ]


def remove_ownerless() -> None:
    """Remove the folders of processes that were killed."""
    for folder in ownerless_folders():
        shutil.rmtree(folder, ignore_errors=True)


def _is_ownerless(owner: Path) -> bool:
    """Return whether a folder is one of ours, and is not held."""
    try:
        handle = os.open(owner, os.O_RDONLY | os.O_CLOEXEC | os.O_NOFOLLOW)
    except OSError:
        return False
    try:
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
        # Without an id it is just being made.
        status = os.fstat(handle)
        return status.st_size > 0 and status.st_uid == os.getuid()
    except OSError:
        return False
    finally:
        os.close(handle)
