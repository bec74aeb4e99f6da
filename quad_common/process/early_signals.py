"""
Signals in the first moments of a process, while even small modules are not yet imported.

This module imports what Python has loaded anyway, so that nothing comes before it.
"""

from __future__ import annotations

import _thread
import os
import signal
from collections.abc import Callable

SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
"""An interrupt, a request to end, and a terminal that was closed."""

_wakeups: list[int] = []
"""Where the thread that waits for signals is told of them, as long as it waits."""


def end_node_at_once() -> None:
    """End this process with code 0 at a signal: there is nothing yet to be given back."""
    _end_at_once(0, 0)


def end_command_at_once() -> None:
    """End this process with 128 and a signal's number: there is nothing yet to be given back."""
    _end_at_once(128, 1)


def _end_at_once(base: int, factor: int) -> None:
    def end(number: int, frame: object = None) -> None:
        os._exit(base + factor * number)

    # Python looks for signals between its own instructions. One that comes just before the main
    # thread begins to wait in the kernel, for a slow disk perhaps, is seen by another thread.
    received, wakeup = os.pipe()
    os.set_blocking(wakeup, False)
    signal.set_wakeup_fd(wakeup, warn_on_full_buffer=False)
    _wakeups.append(wakeup)
    _thread.start_new_thread(_watch, (received, end))
    for number in SIGNALS:
        # What nohup started is not to react to its terminal. Interrupts are ignored by
        # whatever a shell starts in the background, and yet meant for whom they are sent to.
        if number != signal.SIGHUP or signal.getsignal(number) != signal.SIG_IGN:
            signal.signal(number, end)


def _watch(received: int, end: Callable[[int], None]) -> None:
    """Wait for the first signal, until others do."""
    while number := os.read(received, 1):
        if number[0] in SIGNALS:
            end(number[0])
    os.close(received)


def hand_over() -> None:
    """Wait for signals no longer: others do, and have said where they are told of them."""
    while _wakeups:
        os.close(_wakeups.pop())
