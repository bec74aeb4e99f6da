"""
Tells whether no joint moves though joints are commanded to: then none of them has failed.

When a controller is stopped in mid-motion, or a switch stops all drives, the joint that is
commanded to turn farthest is the first to be too far from its command, while the others are near
theirs.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_gait.faults.command_tracker import CommandTracker

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StandstillOptions:
    """When joints rest that should turn."""

    turning: float = 0.3
    """Speed that joints are commanded from which on they must be seen to turn [rad/s]."""
    resting: float = 0.15
    """Fraction of that speed, or of the angle they were commanded, below which they rest."""
    distance: float = 0.015
    """Angle that joints are commanded from which on they must be seen to have turned [rad]."""
    response: float = 0.1
    """Time in which a drive answers to that [s]."""
    slow_response: float = 0.4
    """The same while a trajectory starts on arrival: it is not known when that was [s]."""
    window: float = 1.0
    """Time for which it is remembered where the joints were [s]."""
    spacing: float = 0.02
    """Time between two moments that are remembered, at least [s]."""


class StandstillCheck:
    """
    Remembers where the joints were, and compares how far they turned with what was commanded.

    Parameters
    ----------
    options : StandstillOptions, optional
        When joints rest.
    """

    def __init__(self, options: StandstillOptions | None = None) -> None:
        self._options = StandstillOptions() if options is None else options
        self.forget()

    def forget(self) -> None:
        """Know nothing of where the joints were."""
        self._past: deque[tuple[float, Array]] = deque()
        self._now: tuple[float, Array, Array] | None = None

    def update(self, time: float, positions: Array, velocities: Array) -> None:
        """
        Take a measurement.

        Parameters
        ----------
        time : float
            When it was taken, later than the last one [s].
        positions, velocities : ndarray, shape (n,)
            Of the joints [rad, rad/s].
        """
        past, options = self._past, self._options
        self._now = (time, positions, velocities)
        if not past or time - past[-1][0] >= options.spacing:
            past.append((time, positions))
        while time - past[0][0] > options.window:
            past.popleft()

    def has_stopped(self, joint: int, tracker: CommandTracker) -> bool:
        """
        Return whether all joints but one rest though some of them are commanded to turn.

        Parameters
        ----------
        joint : int
            The one that is suspected to have failed.
        tracker : CommandTracker
            What the joints are commanded to do.
        """
        if self._now is None or not tracker:
            return False
        time, positions, velocities = self._now
        options, others = self._options, np.arange(len(positions)) != joint
        asked = float(tracker.speeds(time)[others].max())
        if asked >= options.turning and np.abs(velocities[others]).max() < options.resting * asked:
            return True
        followed = tracker.followed
        assert followed is not None
        # Before it began the joints did something else.
        began = followed.path.begin + followed.delay
        answered = time - (options.response if tracker.is_exact else options.slow_response)
        past = [(t, there) for t, there in self._past if began <= t <= answered]
        if not past:
            return False
        times = np.array([*(t for t, _ in past), time])
        commands = followed.path.over(times - followed.delay)[0][:, others]
        places = np.array([there for _, there in past])[:, others]
        # How far they should have turned, and did, since each moment that is remembered.
        wanted = np.abs(commands[-1] - commands[:-1]).max(axis=1)
        turned = np.abs(positions[others] - places).max(axis=1)
        is_at_rest = (wanted >= options.distance) & (turned < options.resting * wanted)
        # Those that are where they should be have got there.
        behind = float(np.abs(commands[-1] - positions[others]).max())
        return bool((is_at_rest & (behind > 0.5 * wanted)).any())
