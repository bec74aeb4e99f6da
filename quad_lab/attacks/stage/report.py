"""
What came of an attack by messages on one node, and what must hold of all of them.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from quad_lab.attacks.stage.violations import violation_bars
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure

LARGEST_GROWTH = 0.05
"""Memory that a node may gain in an attack, as a fraction."""


@dataclass
class Report:
    """What came of the attack on one node."""

    node: str
    state: str
    """Of the robot: ``standing`` or ``walking``."""
    messages: int = 0
    giants: int = 0
    """Number of messages, besides, that were far too long."""
    deaths: list[str] = field(default_factory=list)
    """Nodes that ended, with what was sent to them last."""
    slow: list[str] = field(default_factory=list)
    """Reactions slower than two seconds."""
    first_growth: dict[str, float] = field(default_factory=dict)
    """Growth of each node's memory in the first half of the attack, as a fraction."""
    memory_growth: dict[str, float] = field(default_factory=dict)
    """Growth of each node's memory in the second half, as a fraction."""
    has_reached_goal: bool = False
    """Whether the next good goal was reached without a restart."""
    problem: str = ''
    """Why it was not."""
    nonsense: int = 0
    """Messages that must be refused."""
    accepted: list[str] = field(default_factory=list)
    """Of these, what was not refused."""
    falls: int = 0
    """Of a robot to whose joints nothing was sent."""


def bars_of(
    reports: list[Report], counts: dict[str, int], tracebacks: list[str], quick: bool = False
) -> list[Criterion]:
    """
    Work out the bars of some attacks.

    Parameters
    ----------
    reports : list of Report
        What came of each.
    counts : dict of str to int
        How often each kind of violation was seen; see :mod:`quad_lab.attacks.stage.violations`.
    tracebacks : list of str
        Those in the nodes' logs.
    quick : bool
        Nodes that have just begun still load what they need: their growth is only to be known.

    Returns
    -------
    list of Criterion
        What must hold.
    """
    grown = [value for report in reports for value in report.memory_growth.values()]
    largest = max(grown, default=None)
    first = [value for report in reports for value in report.first_growth.values()]
    reached = sum(report.has_reached_goal for report in reports)
    return [
        figure('messages to each node', min((r.messages for r in reports), default=None), ''),
        at_most('node deaths', sum(len(r.deaths) for r in reports), '', 0),
        at_most('tracebacks', len(tracebacks), '', 0),
        at_most('reactions slower than 2 s', sum(len(r.slow) for r in reports), '', 0),
        *violation_bars(counts),
        figure('largest growth of memory, first half', max(first, default=None), 'fraction'),
        figure('largest growth of memory', largest, 'fraction')
        if quick
        else at_most('largest growth of memory', largest, 'fraction', LARGEST_GROWTH),
        figure('messages that must be refused', sum(r.nonsense for r in reports), ''),
        at_most('nonsense accepted', sum(len(r.accepted) for r in reports), '', 0),
        at_most('falls under attack', sum(r.falls for r in reports), '', 0),
        at_least('good goals reached after', reached, f'of {len(reports)}', len(reports)),
    ]
