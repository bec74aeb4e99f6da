"""
Works on requests at once, in the thread that makes them: for walks without a node.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class ImmediateRequest:
    """Takes :class:`~quad_planner.session.latest_request.LatestRequest`'s place."""

    @property
    def is_busy(self) -> bool:
        """Whether a request waits for its answer: never."""
        return False

    def is_superseded(self) -> bool:
        """Return whether work may stop: nothing newer can come meanwhile."""
        return False

    def submit(self, work: Callable[[], Any], done: Callable[[Callable[[], Any]], None]) -> None:
        """Hand on the work, which is done where its result is wanted."""
        done(work)

    def close(self) -> None:
        """Do nothing: nothing runs, and nothing waits."""
