"""
Works on requests one after the other, beside the thread that takes them: each has its answer.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import partial
from typing import Generic, TypeVar

from quad_common.errors import TooManyRequests

Result = TypeVar('Result')

_NAME = 'request_queue'

_MOST = 100
"""Number of requests that may wait: they take memory, and who asked has long given up."""


class RequestQueue(Generic[Result]):
    """
    A worker that cares for every request, in the order in which they come.

    Parameters
    ----------
    deliver : callable
        Has a callable called in the thread that owns the worker.
    """

    def __init__(self, deliver: Callable[[Callable[[], None]], object]) -> None:
        self._deliver = deliver
        self._pool = ThreadPoolExecutor(1, thread_name_prefix=_NAME)
        self._waiting = 0
        self._is_closed = False

    @property
    def is_busy(self) -> bool:
        """Whether a request waits for its answer."""
        return self._waiting > 0

    def is_superseded(self) -> bool:
        """Return whether work may stop: only when the worker is closed."""
        return self._is_closed

    def submit(
        self, work: Callable[[], Result], done: Callable[[Callable[[], Result]], None]
    ) -> None:
        """
        Take a request.

        Parameters
        ----------
        work : callable
            Called in the worker's thread.
        done : callable
            Called in the owner's thread, with a callable that returns the result or
            raises what `work` raised.

        Raises
        ------
        TooManyRequests
            If as many as can be wait already.
        """
        if self._waiting >= _MOST:
            raise TooManyRequests(_MOST)
        self._waiting += 1
        future = self._pool.submit(work)
        future.add_done_callback(lambda future: self._deliver(partial(self._answer, done, future)))

    def close(self) -> None:
        """Give up what waits."""
        self._is_closed = True
        self._pool.shutdown(wait=False, cancel_futures=True)

    def _answer(self, done: Callable[[Callable[[], Result]], None], future: Future[Result]) -> None:
        self._waiting -= 1
        if not self._is_closed:
            done(future.result)
