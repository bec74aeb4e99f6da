"""
Notices a joint that does not turn although it is commanded to, and stays within its tolerance.

A joint that is jammed in the middle of a small swing is never far from its command. But it
rests while its command turns to and fro about it, and while the joints around it turn.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop

Array = NDArray[np.float64]


@dataclass(frozen=True)
class TurningOptions:
    """When a joint does not turn that should."""

    still: float = 0.0075
    """Angle; a joint that has turned by less has not moved [rad]."""
    distance: float = 0.03
    """Angle that its command has turned since, from which on it should have moved, besides what
    its load has bent it [rad]."""
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
        self._largest = np.ascontiguousarray(largest, np.float64).copy()
        options = TurningOptions() if options is None else options
        self._others = options.others
        self._laws = np.array(
            [
                options.still,
                options.distance,
                options.compliance,
                options.patience,
                options.recent,
            ]
        )
        # Compiled, or read, before the first measurement has to be answered in time.
        self.forget()
        self.update(largest, largest, largest, 0.0)
        self.forget()

    def forget(self) -> None:
        """Know nothing of where the joints were."""
        count = len(self._largest)
        self._now: Array = np.zeros((3, count))
        # Positions, commands and torques when a joint was seen to move last.
        self._anchors: Array = np.full((3, count), np.nan)
        # For how long each has been asked to turn, and has rested.
        self._times: Array = np.zeros((2, count))
        self._times[1] = np.inf

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
        self._now[0], self._now[1], self._now[2] = positions, commanded, efforts
        return _unturned(
            self._now, self._anchors, self._times, self._largest, self._laws, step, self._others
        )


@compiled_loop
def _unturned(
    now: Array,
    anchors: Array,
    times: Array,
    largest: Array,
    laws: Array,
    step: float,
    others: int,
) -> int:
    """
    Bring up to date what is known of joints; return the one that does not turn, -1 for none.

    Parameters
    ----------
    now, anchors : ndarray, shape (3, n)
        Positions, commands [rad] and torques [N m]: now, and when each was seen to move last.
    times : ndarray, shape (2, n)
        For how long each has been asked to turn, and has rested [s].
    largest : ndarray, shape (n,)
        Largest torques [N m].
    laws : ndarray, shape (5,)
        Fields of :class:`TurningOptions` in their order, but for the number of others.
    step : float
        Time since the last measurement [s].
    others : int
        Number of joints that must have moved lately.
    """
    still, distance, compliance, patience, recent = laws[0], laws[1], laws[2], laws[3], laws[4]
    asked, moving, joint = 0, 0, -1
    for k in range(now.shape[1]):
        # What was never seen counts as moved.
        if not abs(now[0, k] - anchors[0, k]) <= still:
            for row in range(3):
                anchors[row, k] = now[row, k]
            times[0, k] = times[1, k] = 0.0
        else:
            times[1, k] += step
            moved = now[0, k] - anchors[0, k]
            behind = now[1, k] - anchors[1, k] - moved
            # A load that has come on bends a drive back; one that jams pulls as well.
            loaded = now[2, k] - anchors[2, k]
            pull = loaded if behind > 0.0 else -loaded
            bent = compliance * max(pull, 0.0) / largest[k]
            if abs(behind) > distance + bent:
                asked += 1
                joint = k
        if times[1, k] < recent:
            moving += 1
    # Joints that rest together wait for their trajectory.
    if asked != 1 or moving < others:
        return -1
    times[0, joint] += step
    return joint if times[0, joint] >= patience - 1e-9 else -1
