"""
The clock of a trot: which foot is where in its swing or stance at any time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.gait import Gait


@dataclass(frozen=True)
class PhaseClock:
    """
    A gait's order of swings, repeated until no foot is to lift any more.

    The phase of a foot rises from 0 at its liftoff to 1 at the next one; it swings while its phase
    is below its swing fraction.
    """

    period: float
    """Duration of a cycle [s]."""
    offsets: tuple[float, ...]
    """Liftoffs in the cycle, as fractions of the period, one for each foot."""
    swing_fractions: tuple[float, ...]
    """Fractions of the cycle for which the feet swing."""
    start: float = 0.0
    """Time at which the first cycle begins; all feet stand before it [s]."""
    end: float = math.inf
    """Time from which on no foot lifts any more [s]."""
    edges: tuple[float, ...] = (0.0, 1.0)
    """When one group of standing feet takes over from another, as fractions of the period."""

    @classmethod
    def of(cls, gait: Gait, start: float = 0.0) -> PhaseClock:
        """Return the clock of a gait whose first cycle begins at a time [s]."""
        swings = [gait.swing(leg) for leg in LEGS]
        period = gait.cycle_period
        return cls(
            period,
            tuple(swing.liftoff / period for swing in swings),
            tuple((swing.touchdown - swing.liftoff) / period for swing in swings),
            start,
            edges=tuple(edge / period for edge in gait.support_edges),
        )

    def pendulum_factor(self, time: float, rate: float) -> float:
        """
        Return how fast a body moves at a time, over its mean speed.

        Over each pair of standing feet it is an inverted pendulum, x'' = rate^2 x: slower above
        them, faster between two supports. At an even pace it would rock from one to the other.

        Parameters
        ----------
        time : float
            [s]
        rate : float
            Rate of the pendulum, sqrt(g / h) [1/s].

        Returns
        -------
        float
            1 while all feet stand.
        """
        cycles = (time - self.start) / self.period
        if cycles <= 0.0 or time >= self.end:
            return 1.0
        phase = cycles % 1.0
        begin, end = next(edge for edge in pairwise(self.edges) if phase < edge[1])
        half = rate * (end - begin) * self.period / 2.0
        since = rate * (phase - (begin + end) / 2.0) * self.period
        return half / math.sinh(half) * math.cosh(since)

    def swing_phases(self, time: float) -> list[tuple[float | None, float]]:
        """
        Return how far each foot's swing is at a time [s].

        Returns
        -------
        list of tuple
            For each foot the fraction of its swing, None if it stands, and the time until it
            lands, 0 if it stands [s].
        """
        cycles = (time - self.start) / self.period
        last = (self.end - self.start) / self.period
        result: list[tuple[float | None, float]] = []
        for offset, swing in zip(self.offsets, self.swing_fractions):
            phase = (cycles - offset) % 1.0
            if phase < swing and offset <= cycles and cycles - phase < last:
                result.append((phase / swing, (swing - phase) * self.period))
            else:
                result.append((None, 0.0))
        return result

    def in_stance(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are to stand at a time [s], shape (4,)."""
        return np.array([fraction is None for fraction, _ in self.swing_phases(time)])

    @cached_property
    def stance_times(self) -> tuple[float, ...]:
        """Durations of the feet's stances [s]."""
        return tuple((1.0 - swing) * self.period for swing in self.swing_fractions)

    @cached_property
    def swing_times(self) -> tuple[float, ...]:
        """Durations of the feet's swings [s]."""
        return tuple(swing * self.period for swing in self.swing_fractions)

    @cached_property
    def longest_swing(self) -> float:
        """Duration of the longest swing [s]."""
        return max(self.swing_fractions) * self.period
