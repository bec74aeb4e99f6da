"""
What a node reports of itself on ``diagnostics``: a level, a sentence, and values beside it.
"""

from __future__ import annotations

import enum
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

_FIGURES = re.compile(r'-?\d+(\.\d+)?')


class Level(enum.IntEnum):
    """Levels of ``diagnostic_msgs/DiagnosticStatus``."""

    OK = 0
    WARN = 1
    ERROR = 2
    STALE = 3


@dataclass(frozen=True)
class Status:
    """What goes on, or why nothing does."""

    level: Level
    """Level of concern."""
    message: str
    """Sentence for a reader."""
    values: Mapping[str, object] = field(default_factory=dict)
    """Values by their names on ``diagnostics``."""
    is_waiting: bool = False
    """Whether it waits for what other nodes publish: those that start together soon do."""

    def with_notes(self, *notes: str) -> Status:
        """Return the status with sentences that a user should know, those that are not empty."""
        said = [note for note in notes if note]
        level = max(self.level, Level.WARN) if said else self.level
        message = '; '.join([self.message, *said])
        return replace(self, level=level, message=message, is_waiting=self.is_waiting and not said)

    @property
    def subject(self) -> str:
        """What it is about: statuses that differ in figures alone are about the same."""
        return self.message if self.level is Level.ERROR else without_figures(self.message)


def without_figures(sentence: str) -> str:
    """Return a sentence with a sign in place of each figure."""
    return _FIGURES.sub('#', sentence)
