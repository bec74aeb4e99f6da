"""
Ends the process in time even where no Python can run any more.

The middleware sometimes hangs in the call that destroys its entities, and rclpy holds Python's lock
meanwhile: no thread of Python's can notice. A timer of the C library needs no lock.
"""

from __future__ import annotations

import contextlib
import ctypes
import sys
from collections.abc import Iterator

_MONOTONIC = 1
_SIGEV_THREAD = 2


class _Sigevent(ctypes.Structure):
    _fields_ = (
        ('value', ctypes.c_void_p),
        ('signo', ctypes.c_int),
        ('notify', ctypes.c_int),
        ('function', ctypes.c_void_p),
        ('attributes', ctypes.c_void_p),
        ('padding', ctypes.c_char * 64),
    )


class _Itimerspec(ctypes.Structure):
    _fields_ = (
        ('interval_s', ctypes.c_long),
        ('interval_ns', ctypes.c_long),
        ('value_s', ctypes.c_long),
        ('value_ns', ctypes.c_long),
    )


@contextlib.contextmanager
def ended_natively_after(seconds: float, code: int = 0) -> Iterator[bool]:
    """
    End this process if a block takes longer than a time.

    Parameters
    ----------
    seconds : float
        Time that the block has, more than 0 [s].
    code : int
        Exit code.

    Yields
    ------
    bool
        Whether there is such a timer: on Linux.
    """
    timer = _started_timer(seconds, code)
    try:
        yield timer is not None
    finally:
        if timer is not None:
            ctypes.CDLL(None).timer_delete(timer)


def _started_timer(seconds: float, code: int) -> ctypes.c_void_p | None:
    if sys.platform != 'linux':
        return None
    try:
        libc = ctypes.CDLL(None)
        event = _Sigevent(value=code or None, notify=_SIGEV_THREAD)
        event.function = ctypes.cast(libc._exit, ctypes.c_void_p).value
        timer = ctypes.c_void_p()
        if libc.timer_create(_MONOTONIC, ctypes.byref(event), ctypes.byref(timer)):
            return None
        whole = int(seconds)
        span = _Itimerspec(0, 0, whole, int((seconds - whole) * 1e9) + 1)
        libc.timer_settime(timer, 0, ctypes.byref(span), None)
    except (AttributeError, OSError):
        # A C library without timers.
        return None
    return timer
