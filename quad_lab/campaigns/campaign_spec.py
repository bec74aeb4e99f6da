"""
What a campaign is: what stays, what varies and how, and what is tuned.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from quad_common.parameters import Value
from quad_lab.seeded_walks.walk_settings import Case

METHODS = ('grid', 'random')
"""Manners of varying: every combination, or each walk with values of its own."""


@dataclass(frozen=True)
class Span:
    """A range of numbers."""

    lower: float
    """Least value."""
    upper: float
    """Largest value."""
    steps: int = 0
    """Number of values in a grid, both ends included; 0 if it is drawn from or tuned."""

    @property
    def values(self) -> tuple[float, ...]:
        """The values in a grid."""
        width = (self.upper - self.lower) / (self.steps - 1)
        return tuple(self.lower + k * width for k in range(self.steps))


@dataclass(frozen=True)
class Tuning:
    """What is tuned, and for what."""

    spans: Mapping[str, Span]
    """Ranges of the numbers that are tuned, by their names."""
    objective: Mapping[str, float]
    """Weights of figures that are to be small, each over what it was before."""
    limits: Mapping[str, float]
    """Largest values that figures may have."""
    population: int = 8
    """Number of candidates of a generation."""
    generations: int = 12
    """Number of generations."""


@dataclass(frozen=True)
class CampaignSpec:
    """A campaign."""

    name: str
    """Name of the campaign."""
    description: str
    """What it is for, in a sentence."""
    seed: int
    """Seed of all seeds."""
    walks: int
    """Number of walks of each combination; all walks of a campaign at random."""
    method: str
    """One of :data:`METHODS`."""
    fixed: Case
    """What does not vary."""
    vary: Mapping[str, tuple[Value, ...] | Span]
    """What varies: choices, or ranges."""
    tuning: Tuning | None = None
    """What is tuned; None for nothing."""
