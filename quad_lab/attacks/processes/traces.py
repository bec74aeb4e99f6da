"""
What processes leave behind: other processes, shared memory, temporary files.
"""

from __future__ import annotations

import contextlib
from pathlib import Path

FOLDER = Path('/dev/shm')
"""Where Linux keeps shared memory; elsewhere nothing is found."""


class Traces:
    """
    Keeps what belongs to a process, so that others on this machine do not count.

    Parameters
    ----------
    pid : int
        The process. What it starts, and what these start, belongs to it.
    """

    def __init__(self, pid: int) -> None:
        self._processes: dict[int, str] = {}
        self._files: dict[Path, int] = {}
        self._pid = pid

    def look(self) -> None:
        """Note what there is now; to be called again and again."""
        for pid in (self._pid, *_below(self._pid), *self._processes):
            began = _began(pid)
            if began and self._processes.setdefault(pid, began) == began:
                for path in files_of(pid):
                    with contextlib.suppress(OSError):
                        self._files[path] = path.stat().st_ino

    def running(self) -> list[int]:
        """List the processes that still run."""
        return [pid for pid, began in self._processes.items() if _began(pid) == began]

    def shared_memory(self) -> list[str]:
        """List the names in shared memory that are still there."""
        left = []
        for path, inode in self._files.items():
            with contextlib.suppress(OSError):
                if path.stat().st_ino == inode:
                    left.append(path.name)
        return left


def files_of(pid: int) -> list[Path]:
    """
    List what a process holds in shared memory.

    Parameters
    ----------
    pid : int
        Its id.

    Returns
    -------
    list of Path
        One file for each segment and each port of Fast DDS: beside it there is a lock file,
        ``..._el``, that its process holds locked as long as it lives.
    """
    held: set[int] = set()
    with contextlib.suppress(OSError):
        # proc(5): "1: FLOCK  ADVISORY  WRITE 8487 00:1b:1731 0 EOF", the inode last in the triple.
        for line in Path('/proc/locks').read_text().splitlines():
            fields = line.split()
            if fields[1] == 'FLOCK' and fields[3] == 'WRITE' and int(fields[4]) == pid:
                held.add(int(fields[5].rsplit(':', 1)[1]))
    return [path for path in FOLDER.glob('fastrtps_*_el') if _inode(path) in held] if held else []


def _inode(path: Path) -> int | None:
    try:
        return path.stat().st_ino
    except OSError:
        return None


def _below(pid: int) -> list[int]:
    """List the children of a process, and theirs."""
    children: list[int] = []
    with contextlib.suppress(OSError):
        for thread in Path(f'/proc/{pid}/task').iterdir():
            children += map(int, (thread / 'children').read_text().split())
    return children + [each for child in children for each in _below(child)]


def _began(pid: int) -> str:
    """Return when a process began, which tells it from a later one with its id; '' if it ended."""
    try:
        # proc(5): the name may hold anything; behind it come the state and, 20th, the start.
        fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    except OSError:
        return ''
    # A zombie has ended, and waits for somebody to ask for its code.
    return '' if fields[0] in 'ZX' else fields[19]
