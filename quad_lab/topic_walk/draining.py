"""
Runs callbacks until none is left.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

_QUIET = 2
"""Rounds in a row in which nothing was called: what a round begins may come while it ends."""


def drain(executor: Any, calls: Callable[[], int]) -> None:
    """
    Run callbacks until none is left, those included that come of others.

    An executor does much that calls nothing: the more nodes, the more of it for each clock. So it
    is not done when a few turns of it called nothing, but when something that was put at the end
    of its queue has had its turn, and nothing was called before.

    Parameters
    ----------
    executor : rclpy.executors.Executor
        What runs them.
    calls : callable
        Returns the number of callbacks that were called.
    """
    quiet = 0
    while quiet < _QUIET:
        before = calls()
        last = executor.create_task(_nothing)
        while not last.done():
            executor.spin_once(timeout_sec=0.0)
        quiet = quiet + 1 if calls() == before else 0


def _nothing() -> None:
    """Mark the end of a queue."""
