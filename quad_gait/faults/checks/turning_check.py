"""
Notices a joint that does not turn although it is commanded to, and stays within its tolerance.

A joint that is jammed in the middle of a small swing is never far from its command. But it
rests while its command turns to and fro about it, and while the joints around it turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TurningOptions:
    """When a joint does not turn that should."""

    still: float = 0.0075
    """Angle; a joint that has turned by less has not moved [rad]."""
    distance: float = 0.03
    """Angle that its command has turned since, from which on it should have moved, besides what
    its load has bent it [rad]."""
    least_off: float = 0.025
    """Distance from its command from which on it may be a joint that does not turn: a sound one
    that comes to rest from high speed, and is bent back by its load, may seem to have missed as
    much as ``distance`` and be nearer [rad]."""
    compliance: float = 0.35
    """Distance from its command at which a position drive gives all its torque [rad]."""
    patience: float = 0.12
    """Time that its command must have been so far away [s]."""
    recent: float = 0.06
    """Time within which others must have moved [s]."""
    others: int = 4
    """Number of them."""


class TurningCheck:
    """
    Counts for how long joints rest that should turn.

    Parameters
    ----------
    largest : ndarray, shape (n,)
        Largest torques of the motors [N m].
    options : TurningOptions, optional
        When a joint does not turn.
    """

    def __init__(self, largest: Array, options: TurningOptions | None = None) -> None:
        self._largest = largest
        self._options = TurningOptions() if options is None else options
        self.forget()

    def forget(self) -> None:
        """Know nothing of where the joints were."""
        count = len(self._largest)
        self._now: Array = np.zeros((3, count))
        # Positions, commands and torques when a joint was seen to move last.
        self._anchors: Array = np.full((3, count), np.nan)
        self._asked_for: Array = np.zeros(count)
        self._rested_for: Array = np.full(count, np.inf)

    def update(self, commanded: Array, positions: Array, efforts: Array, step: float) -> int:
        """
        Take a measurement of joints that all follow their commands within their tolerances.

        Parameters
        ----------
        commanded, positions : ndarray, shape (n,)
            Where the joints should be, and are [rad].
        efforts : ndarray, shape (n,)
            Torques of their motors [N m].
        step : float
            Time since the last measurement [s].

        Returns
        -------
        int
            The joint that does not turn; -1 for none.
        """
        options = self._options
        now, anchors = self._now, self._anchors
        now[0], now[1], now[2] = positions, commanded, efforts
        # What was never seen counts as moved.
        has_moved = ~(np.abs(now[0] - anchors[0]) <= options.still)
        np.copyto(anchors, now, where=has_moved)
        self._rested_for += step
        self._rested_for[has_moved] = self._asked_for[has_moved] = 0.0
        moved, turned, loaded = now - anchors
        behind = turned - moved
        far = np.abs(behind)
        # Nearly always no joint is so far behind.
        if far.max() <= options.distance:
            return -1
        # A load that has come on bends a drive back; one that jams pulls as well.
        bent = options.compliance * np.maximum(loaded * np.sign(behind), 0.0) / self._largest
        off = np.abs(positions - commanded)
        is_asked = (far > options.distance + bent) & (off > options.least_off)
        if np.count_nonzero(is_asked) != 1:
            # Joints that rest together wait for their trajectory.
            return -1
        joint = int(is_asked.argmax())
        if np.count_nonzero(self._rested_for < options.recent) < options.others:
            return -1
        self._asked_for[joint] += step
        return joint if self._asked_for[joint] >= options.patience - 1e-9 else -1
