"""
Files that Fast DDS keeps in shared memory: which belong to a process, and which to none.

Each segment and each port has a lock file beside it, ``..._el``, which its process holds
locked as long as it lives; so does Fast DDS itself tell the living from the dead.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import time
from pathlib import Path

FOLDER = Path('/dev/shm')
"""Where Linux keeps shared memory; elsewhere nothing is found, and nothing is done."""

_LOCK = '_el'

_SETTLED = 10.0
"""Age from which a file without a lock belongs to no process, and is not just being made [s]."""


def files_of(pid: int) -> list[Path]:
    """
    List the lock files that a process holds.

    Parameters
    ----------
    pid : int
        Its id.

    Returns
    -------
    list of Path
        One for each segment and each port.
    """
    held: set[int] = set()
    with contextlib.suppress(OSError):
        # proc(5): "1: FLOCK  ADVISORY  WRITE 8487 00:1b:1731 0 EOF", the inode last in the triple.
        for line in Path('/proc/locks').read_text().splitlines():
            fields = line.split()
            if fields[1] == 'FLOCK' and fields[3] == 'WRITE' and int(fields[4]) == pid:
                held.add(int(fields[5].rsplit(':', 1)[1]))
    return [path for path in _lock_files() if _inode(path) in held] if held else []


def ownerless_files() -> list[Path]:
    """List the lock files whose processes have ended without removing them."""
    return [path for path in _lock_files() if _is_ownerless(path)]


def remove(lock_files: list[Path]) -> None:
    """Remove segments and ports with all that belongs to them, given their lock files."""
    for path in lock_files:
        name = path.name.removesuffix(_LOCK)
        # The lock file last: it is what tells the living from the dead.
        for part in (FOLDER / f'sem.{name}_mutex', FOLDER / name, path):
            with contextlib.suppress(OSError):
                part.unlink(missing_ok=True)


def release_own() -> None:
    """Remove what this process has in shared memory, when it cannot end in good order."""
    remove(files_of(os.getpid()))


def remove_ownerless() -> None:
    """Remove what processes left that were killed: half a megabyte to eight for each of them."""
    now = time.time()
    for path in ownerless_files():
        with contextlib.suppress(OSError):
            status = path.stat()
            if status.st_uid == os.getuid() and now - status.st_mtime > _SETTLED:
                remove([path])


def _lock_files() -> list[Path]:
    return sorted(FOLDER.glob(f'fastrtps_*{_LOCK}'))


def _inode(path: Path) -> int | None:
    try:
        return path.stat().st_ino
    except OSError:
        return None


def _is_ownerless(path: Path) -> bool:
    """Return whether a lock file is free: it may be locked for a moment to find out."""
    try:
        handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC)
    except OSError:
        return False
    try:
        # Shared, so that two who look at the same time do not take each other for the owner.
        fcntl.flock(handle, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except OSError:
        return False
    else:
        return True
    finally:
        os.close(handle)
