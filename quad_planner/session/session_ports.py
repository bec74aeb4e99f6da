"""
What a planning session needs of others: who works on searches, and who is told of decisions.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

from quad_common.plan import Plan
from quad_planner.grid.inflated_map import InflatedMap


class Requests(Protocol):
    """Whoever works on searches: :class:`quad_planner.session.latest_request.LatestRequest`."""

    @property
    def is_busy(self) -> bool:
        """Whether a request waits for its answer."""

    def is_superseded(self) -> bool:
        """Return, to work that asks, whether it may stop."""

    def submit(self, work: Callable[[], Any], done: Callable[[Callable[[], Any]], None]) -> None:
        """Take a request; those before it are given up."""

    def close(self) -> None:
        """Give up what runs and what waits."""


class Output(Protocol):
    """The receiver of a session's decisions."""

    def publish_plan(self, plan: Plan | None) -> int:
        """Publish a plan, or take the last one back; return its stamp, each another one [ns]."""

    def show_map(self, prepared: InflatedMap) -> None:
        """Show what is planned on now."""

    def say(self, sentence: str) -> None:
        """Log a sentence."""

    def warn(self, sentence: str) -> None:
        """Log what a user should know."""

    def update_status(self) -> None:
        """Say what goes on."""
