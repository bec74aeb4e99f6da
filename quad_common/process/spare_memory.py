"""
Gives memory that is free in this process, but still held by it, back to the machine.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import lru_cache


def give_back_spare_memory() -> bool:
    """
    Give back what the C library keeps for later.

    After a message that is far too large it may keep all of the message's memory: one small
    block above it in the heap is enough. It takes about a millisecond.

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
