"""
What was seen on a stage that must never be seen.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from quad_lab.attacks.stage.stage import Stage


@dataclass
class Findings:
    """What nodes published or wrote into their logs, and must not."""

    counts: dict[str, int] = field(default_factory=dict)
    """Number of violations of each kind; see :mod:`quad_lab.attacks.stage.violations`."""
    examples: dict[str, list[str]] = field(default_factory=dict)
    """Some violations of each kind."""
    tracebacks: list[str] = field(default_factory=list)
    """Last line of each traceback in the logs."""

    @staticmethod
    def of(stage: Stage) -> Findings:
        """Return what was seen on a stage up to now."""
        listener = stage.listener
        examples = {kind: list(some) for kind, some in listener.examples.items()}
        return Findings(dict(listener.counts), examples, stage.tracebacks())

    def since(self, before: Findings) -> Findings:
        """Return what was seen after earlier findings on the same stage."""
        counts = {kind: n - before.counts.get(kind, 0) for kind, n in self.counts.items()}
        examples = {
            kind: some[len(before.examples.get(kind, [])) :] for kind, some in self.examples.items()
        }
        # By node, and those of one node in the order of its log.
        tracebacks = Counter(self.tracebacks) - Counter(before.tracebacks)
        return Findings(
            {kind: number for kind, number in counts.items() if number},
            {kind: some for kind, some in examples.items() if some},
            list(tracebacks.elements()),
        )

    def add(self, others: Findings) -> None:
        """Take in what was seen elsewhere."""
        for kind, number in others.counts.items():
            self.counts[kind] = self.counts.get(kind, 0) + number
        for kind, some in others.examples.items():
            self.examples.setdefault(kind, []).extend(some)
        self.tracebacks += others.tracebacks
