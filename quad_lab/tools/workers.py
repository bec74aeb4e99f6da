"""
Worker processes of benchmarks, which end with the command that started them.
"""

from __future__ import annotations

import contextlib
import ctypes
import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from types import FrameType
from typing import Any

from quad_common.process.end_signals import end_process, released_at_last, shielded

_PRCTL: Any = getattr(ctypes.CDLL(None), 'prctl', None) if sys.platform == 'linux' else None

_PR_SET_PDEATHSIG = 1

_LAST_WAIT = 2.5
"""For workers to give back what they have, before they are killed [s]."""


@contextlib.contextmanager
def worker_pool(processes: int | None = None) -> Iterator[ProcessPoolExecutor]:
    """
    Start worker processes.

    Parameters
    ----------
    processes : int, optional
        How many; one for each processor if not given.

    Yields
    ------
    ProcessPoolExecutor
        It waits for its work if the block ends well; otherwise its processes are ended,
        whatever they work on.
    """
    pool = ProcessPoolExecutor(
        processes or os.cpu_count(), initializer=_begin_worker, initargs=(os.getpid(),)
    )
    with released_at_last(_end_workers):
        try:
            yield pool
        except BaseException:
            with shielded():
                pool.shutdown(wait=False, cancel_futures=True)
                _end_workers()
            raise
        pool.shutdown()


def end_with_parent() -> None:
    """Have Linux end this process when its parent ends; to be called in the child."""
    if _PRCTL is not None:
        _PRCTL(_PR_SET_PDEATHSIG, signal.SIGTERM)


def _begin_worker(parent: int) -> None:
    """Let the parent alone decide when this process ends."""
    # Ctrl-C goes to all processes of a terminal. What a worker starts would inherit that a signal
    # is ignored; a handler ends with exec.
    signal.signal(signal.SIGINT, lambda number, frame: None)
    signal.signal(signal.SIGTERM, _end_worker)
    end_with_parent()
    if os.getppid() != parent:
        end_process(128 + signal.SIGTERM)


def _end_worker(number: int, frame: FrameType | None) -> None:
    # An exception would be taken for the result of what it works on.
    end_process(128 + number)


def _end_workers() -> None:
    """End all worker processes, gently at first."""
    workers = multiprocessing.active_children()
    for worker in workers:
        worker.terminate()
    deadline = time.monotonic() + _LAST_WAIT
    for worker in workers:
        worker.join(max(0.0, deadline - time.monotonic()))
        if worker.is_alive():
            worker.kill()
