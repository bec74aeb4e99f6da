"""
What a node reports of itself on ``diagnostics``: a level, a sentence, and values beside it.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field


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
