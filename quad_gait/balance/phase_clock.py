"""
The clock of a trot: which foot is where in its swing or stance at any time.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_part
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.gait import Gait

STANDS = -1.0
"""Instead of the fraction of its swing that is over, for a foot that stands."""


class PhaseClock(NamedTuple):
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

    def swing_phases(self, time: float) -> list[tuple[float, float]]:
        """Return what :func:`swing_phase` says of each foot at a time [s]."""
        return [swing_phase(self, leg, time) for leg in range(len(self.offsets))]

    def in_stance(self, time: float) -> NDArray[np.bool_]:
        """Return which feet are to stand at a time [s], shape (4,)."""
        return np.array([fraction == STANDS for fraction, _ in self.swing_phases(time)])

    def until_landing(self, leg: int, time: float) -> float:
        """Return after what time a foot that stands at a time has swung and landed [s]."""
        phase = ((time - self.start) / self.period - self.offsets[leg]) % 1.0
        return (1.0 - phase + self.swing_fractions[leg]) * self.period

    @property
    def stance_times(self) -> tuple[float, ...]:
        """Durations of the feet's stances [s]."""
        return tuple((1.0 - swing) * self.period for swing in self.swing_fractions)

    @property
    def longest_swing(self) -> float:
        """Duration of the longest swing [s]."""
        return max(self.swing_fractions) * self.period


@compiled_part
def swing_phase(clock: PhaseClock, leg: int, time: float) -> tuple[float, float]:
    """
    Return how far a foot's swing is at a time.

    Parameters
    ----------
    clock : PhaseClock
        When feet swing.
    leg : int
        Index of the foot.
    time : float
        [s]

    Returns
    -------
    tuple of float
        The fraction of its swing, :data:`STANDS` if it stands, and the time until it lands, 0 if
        it stands [s].
    """
    cycles = (time - clock.start) / clock.period
    last = (clock.end - clock.start) / clock.period
    offset, swing = clock.offsets[leg], clock.swing_fractions[leg]
    phase = (cycles - offset) % 1.0
    if phase < swing and offset <= cycles and cycles - phase < last:
        return phase / swing, (swing - phase) * clock.period
    return STANDS, 0.0


@compiled_part
def pendulum_factor(clock: PhaseClock, time: float, rate: float) -> float:
    """
    Return how fast a body moves at a time, over its mean speed.

    Over each pair of standing feet it is an inverted pendulum, x'' = rate^2 x: slower above
    them, faster between two supports. At an even pace it would rock from one to the other.

    Parameters
    ----------
    clock : PhaseClock
        When feet swing.
    time : float
        [s]
    rate : float
        Rate of the pendulum, sqrt(g / h) [1/s].

    Returns
    -------
    float
        1 while all feet stand.
    """
    cycles = (time - clock.start) / clock.period
    if cycles <= 0.0 or time >= clock.end:
        return 1.0
    phase, support = cycles % 1.0, 0
    while phase >= clock.edges[support + 1]:
        support += 1
    begin, end = clock.edges[support], clock.edges[support + 1]
    half = rate * (end - begin) * clock.period / 2.0
    since = rate * (phase - (begin + end) / 2.0) * clock.period
    return half / math.sinh(half) * math.cosh(since)
