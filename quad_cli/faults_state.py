"""
What can be seen of a process from outside: its memory, and what it wrote into its log.
"""

from __future__ import annotations

from pathlib import Path

_LONGEST_LINE = 300
"""Of a log that is quoted [letters]."""


def resident_memory(pid: int) -> float | None:
    """Return how much memory of the machine a process holds [MB]; None if it has ended."""
    try:
        text = Path(f'/proc/{pid}/status').read_text()
    except OSError:
        return None
    for line in text.splitlines():
        if line.startswith('VmRSS:'):
            return float(line.split()[1]) / 1024.0
    return None


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
