"""
What no node may ever publish, by the name of each kind.
"""

from __future__ import annotations

from collections.abc import Mapping

from quad_lab.tools.criterion import Criterion, at_most

NOT_FINITE = 'numbers that are not finite'
OUTSIDE_LIMITS = 'commands outside limits'
JOINTS_OUTSIDE = 'joints outside limits'
TOO_LONG = 'texts too long'
UNREADABLE = 'messages that cannot be read'

KINDS = (NOT_FINITE, OUTSIDE_LIMITS, JOINTS_OUTSIDE, TOO_LONG, UNREADABLE)


def violation_bars(counts: Mapping[str, int], kinds: tuple[str, ...] = KINDS) -> list[Criterion]:
    """Work out the bars of violations from how often each kind was seen: none ever."""
    return [at_most(kind, counts.get(kind, 0), '', 0) for kind in kinds]
