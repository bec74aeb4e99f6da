"""
Gives memory that is free in this process, but still held by it, back to the machine.
"""

from __future__ import annotations

import ctypes
import os
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path

_WORTHWHILE = 8.0
"""Growth of a process from which on it is asked to give back what is free [MB]."""


class SpareMemory:
    """
    Sees that a process that has grown gives back what it needs no longer.

    After a message that is far too large the C library may keep all of the message's memory: one
    small block above it in the heap is enough.
    """

    def __init__(self) -> None:
        self._held = resident_memory()

    def look(self) -> bool:
        """
        Give back what is free, if the process has grown since the last time.

        To look takes some 20 us, to give back about a millisecond.

        Returns
        -------
        bool
            Whether the C library was asked to.
        """
        held = resident_memory()
        if held is None or self._held is None:
            return False
        has_grown = held > self._held + _WORTHWHILE
        if has_grown:
            give_back_spare_memory()
            held = resident_memory()
        self._held = held if has_grown or held is None else min(held, self._held)
        return has_grown


def resident_memory() -> float | None:
    """Return how much memory of the machine this process holds [MB]; None if it is not told."""
    try:
        pages = int(Path('/proc/self/statm').read_text().split()[1])
    except (OSError, ValueError, IndexError):
        return None
    return pages * os.sysconf('SC_PAGE_SIZE') / 2**20


def give_back_spare_memory() -> bool:
    """
    Give back what the C library keeps for later.

    Returns
    -------
    bool
        Whether something was given back; False where the C library has no such function.
    """
    trim = _trim()
    return trim is not None and bool(trim(0))


@lru_cache
def _trim() -> Callable[[int], int] | None:
    """Return ``malloc_trim``, which glibc has; None elsewhere."""
    try:
        function = ctypes.CDLL(None).malloc_trim
    except (AttributeError, OSError, TypeError):
        return None
    function.argtypes, function.restype = [ctypes.c_size_t], ctypes.c_int
    return function
