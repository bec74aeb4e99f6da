"""
Whether the planner whose plan is followed still lives.
"""

from __future__ import annotations

from collections.abc import Callable


class PlannerWatch:
    """
    Misses a planner that had a heartbeat; those that never have one are not watched.

    Parameters
    ----------
    timeout : float
        Time without a heartbeat after which the planner is gone [s]; 0: it is not watched.
    clock : callable
        Returns the time [s].
    """

    def __init__(self, timeout: float, clock: Callable[[], float]) -> None:
        self._timeout = timeout
        self._clock = clock
        self._alive_at: float | None = None

    @property
    def problem(self) -> str:
        """That the planner is gone, as a sentence; empty if it lives, or is not watched."""
        timeout, alive_at = self._timeout, self._alive_at
        if not timeout or alive_at is None or self._clock() - alive_at <= timeout:
            return ''
        return f'no heartbeat of the planner for {timeout:g} s: the plan waits for it'

    def take_heartbeat(self, _: object = None) -> None:
        """Note that the planner lives."""
        self._alive_at = self._clock()

    def take_plan(self) -> None:
        """Expect no heartbeat if a plan comes while the planner is gone: another has made it."""
        if self.problem:
            self._alive_at = None
