"""
How patient a navigator is.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class NavigatorOptions:
    """Conditions under which a task goes on."""

    patience: float = 10.0
    """Time for which a robot may do nothing for its goal before the task fails [s]."""
    retries: int = 3
    """Number of times that a robot which is stuck is planned for again."""
    passing_distance: float = 0.3
    """Distance at which a goal that is not the last counts as reached [m]."""
