"""
What a check of the machine has found.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass


class State(enum.Enum):
    """How something stands."""

    GOOD = 'good'
    OPTIONAL = 'optional'
    """It is absent, and something that not everybody needs does not work."""
    WRONG = 'wrong'
    """What everybody needs does not work."""


@dataclass(frozen=True)
class Finding:
    """What one check has found."""

    subject: str
    """What was looked at."""
    state: State
    """How it stands."""
    said: str
    """What was found, in a phrase."""
    mend: str = ''
    """Command or step that mends it; empty where there is nothing to mend."""


def good(subject: str, said: str) -> Finding:
    """Return that something works."""
    return Finding(subject, State.GOOD, said)


def missing(subject: str, said: str, mend: str) -> Finding:
    """Return that something which not everybody needs is absent."""
    return Finding(subject, State.OPTIONAL, said, mend)


def wrong(subject: str, said: str, mend: str) -> Finding:
    """Return that something which everybody needs does not work."""
    return Finding(subject, State.WRONG, said, mend)
