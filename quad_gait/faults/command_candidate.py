"""
A trajectory that the joints may follow, and what is known of when it began.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_gait.faults.joint_path import JointPath

Array = NDArray[np.float64]

_SPACING = 0.01
"""Time between two instants at which joints that are behind are looked for [s]."""


@dataclass
class Candidate:
    """A trajectory that may be followed."""

    path: JointPath
    """Where the joints should be, if it began as early as it could."""
    delay: float = 0.0
    """Time by which it began later than it could have, as far as is known [s]."""
    latest: float = np.inf
    """Largest delay by where the joints have been since [s]."""
    matched: float = -np.inf
    """Time at which all joints were on it last [s]."""
    matched_since: float = np.inf
    """Time from which on they have been at every measurement [s]."""
    is_outdated: bool = False
    """Whether a later one was never followed and has ended."""

    def rows(self, time: float, age: float) -> tuple[Array, Array, Array]:
        """
        List where the joints may be if they follow it.

        Parameters
        ----------
        time : float
            When they were measured [s].
        age : float
            Time by which they may be behind [s]; one that starts on arrival may have been
            delayed by any time.

        Returns
        -------
        tuple of ndarray, shapes (m, n), (m, n) and (m,)
            Postures and what joints may be off [rad], and the delays that they belong to [s].
        """
        path, latest = self.path, age
        if path.starts_on_arrival:
            # Before its first point it is not followed yet.
            latest = min(max(time - path.begin, 0.0), self.latest)
        first = 0.0
        if time > path.end and path.starts_on_arrival:
            # So far back all instants are alike.
            first = min(time - path.end, latest)
        delays: Array = np.linspace(
            first, latest, 1 + int(np.ceil((latest - first) / _SPACING)), dtype=np.float64
        )
        if not path.starts_on_arrival:
            delays = delays[time - delays >= path.begin]
        postures, allowed = path.over(time - delays)
        return postures, allowed, delays
