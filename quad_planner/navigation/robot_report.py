"""
What the robot says that it does, in the words of gait_node's diagnostics.
"""

from __future__ import annotations

from dataclasses import dataclass

MOVING = frozenset({'walking', 'turning', 'balancing', 'standing up', 'sitting down'})
"""The robot moves."""

STUCK = frozenset({'blocked', 'stopped', 'not executed'})
"""It has given up its plan, and may try again."""

DISABLED = frozenset({'fallen', 'lame', 'emergency stop'})
"""No plan moves it: somebody must help it first."""


@dataclass(frozen=True)
class RobotReport:
    """One report of the robot on itself."""

    activity: str
    """Activity, in one word or two."""
    reason: str = ''
    """The same as a sentence."""

    @property
    def is_moving(self) -> bool:
        """Whether the robot moves."""
        return self.activity in MOVING

    @property
    def is_stuck(self) -> bool:
        """Whether it has given up its plan, and may try again."""
        return self.activity in STUCK

    @property
    def is_disabled(self) -> bool:
        """Whether somebody must help it before a plan moves it."""
        return self.activity in DISABLED
