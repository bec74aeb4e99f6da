"""
Works on one request at a time, beside the thread that takes them: a newer one ends an older.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Generic, TypeVar

from quad_common.errors import PlanSuperseded

Result = TypeVar('Result')

_NAME = 'latest_request'


_WORKING_ON = threading.local()
"""Worker of a thread, and number of its request: one planner serves several workers."""


class LatestRequest(Generic[Result]):
    """
    A worker that cares for the latest request only.

    Parameters
    ----------
    deliver : callable
        Has a callable called in the thread that owns the worker.
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], object]) -> None:
        self._deliver = deliver
        self._pool = ThreadPoolExecutor(1, thread_name_prefix=_NAME)
        self._latest = 0
        self._is_busy = False

    @property
    def is_busy(self) -> bool:
        """Whether a request waits for its answer."""
        return self._is_busy

    def submit(
        self, work: Callable[[], Result], done: Callable[[Callable[[], Result]], None]
    ) -> None:
        """
        Take a request; those before it are given up.

        Parameters
        ----------
        work : callable
            Called in the worker's thread. It should ask `is_superseded` again and again,
            and raise if that is so.
        done : callable
            Called in the owner's thread, with a callable that returns the result or
            raises what `work` raised; not called if a newer request came meanwhile.
        """
        self._latest += 1
        self._is_busy = True
        number = self._latest
        future = self._pool.submit(self._work, number, work)
        future.add_done_callback(
            lambda future: self._deliver(partial(self._answer, number, done, future))
        )

    def is_superseded(self) -> bool:
        """Return, to work that runs in a worker's thread, whichever it is, whether it may stop."""
        worker, number = getattr(_WORKING_ON, 'request', (self, self._latest))
        return bool(number != worker._latest)

    def close(self) -> None:
        """Give up what runs and what waits."""
        self._latest += 1
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _work(self, number: int, work: Callable[[], Result]) -> Result:
        if number != self._latest:
            raise PlanSuperseded
        _WORKING_ON.request = self, number
        return work()

    def _answer(
        self, number: int, done: Callable[[Callable[[], Result]], None], future: Future[Result]
    ) -> None:
        if number == self._latest:
            self._is_busy = False
            done(future.result)
