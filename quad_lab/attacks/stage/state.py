"""
What can be seen of a process from outside: its memory, and what it wrote into its log.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

SLOWEST = 2.0
"""A node that takes longer to react hangs [s]."""

_LONGEST_LINE = 300
"""Of a log that is quoted [letters]."""


def resident_memory(pid: int) -> float | None:
    """
    Return how much memory of the machine a process holds [MB]; None if it has ended.

    Without what it shares with others: the middleware's shared memory belongs to whoever sends,
    and is as large as its profile says (``config/fastdds.xml``).
    """
    try:
        text = Path(f'/proc/{pid}/status').read_text()
    except OSError:
        return None
    held = {line.split(':')[0]: line.split()[1:2] for line in text.splitlines()}
    if 'RssAnon' not in held:
        # It has ended, and its parent has not asked how.
        return None
    return sum(float(held[kind][0]) for kind in ('RssAnon', 'RssFile')) / 1024.0


def processor_time(pid: int) -> float:
    """Return how long a process has computed [s]; 0 if it has ended."""
    try:
        text = Path(f'/proc/{pid}/stat').read_text()
    except OSError:
        return 0.0
    # The name in parentheses may hold spaces; user and system time follow it.
    fields = text.rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


@dataclass(frozen=True)
class Reaction:
    """How long a node took to answer."""

    elapsed: float
    """On the wall clock [s]."""
    computed: float
    """Time that the node computed meanwhile [s]: on a busy machine it waits for others."""
    is_answered: bool

    @property
    def is_hang(self) -> bool:
        """Whether the node itself was slow."""
        return not self.is_answered or min(self.elapsed, self.computed) > SLOWEST

    def __str__(self) -> str:
        answered = 'answered' if self.is_answered else 'no answer'
        return f'{answered} after {self.elapsed:.1f} s, {self.computed:.1f} s of computing'


def growth(before: dict[str, float], after: dict[str, float]) -> dict[str, float]:
    """Return by how much memory has grown, as a fraction, of each node that is in both."""
    return {name: after[name] / before[name] - 1.0 for name in after if name in before}


def traceback_ends(log: str) -> list[str]:
    """Return the line that ends each traceback in a log: which error it was."""
    ends = []
    for part in log.split('Traceback (most recent call last)')[1:]:
        lines = part.splitlines()[1:]
        end = next((line for line in lines if line and not line.startswith(' ')), 'unknown')
        ends.append(end[:_LONGEST_LINE])
    return ends
