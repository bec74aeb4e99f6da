"""
Which of the joint motions that were given out the joints follow.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from quad_gait.balance.joint_motion import JointMotion

Array = NDArray[np.float64]

_REMEMBERED = 40
"""Number of motions that are remembered: for 0.8 s, by when a robot that receives none stands."""

_OFF = 0.03
"""Distance of the joints from the last motion up to which they follow it, rms [rad]."""

_NEARER = 0.5
"""Fraction of that distance at which they must be from another one, at most."""

_IN_TRANSIT = 4
"""Number of the last motions that may still arrive."""


class FollowedMotion:
    """Remembers the joint motions that were given out."""

    def __init__(self) -> None:
        self._given: deque[JointMotion] = deque(maxlen=_REMEMBERED)

    def note(self, motion: JointMotion) -> None:
        """Take notice of a motion that is given out."""
        self._given.append(motion)

    def earlier(self, time: float, joints: Array) -> JointMotion | None:
        """
        Return an earlier motion that the joints follow, where later ones have not arrived.

        Parameters
        ----------
        time : float
            When they were measured [s].
        joints : ndarray, shape (4, 3)
            Their positions [rad].

        Returns
        -------
        JointMotion or None
            None if they follow the last ones, or none.
        """
        if not self._given:
            return None
        off = _distance(self._given[-1], time, joints)
        if off <= _OFF:
            return None
        known = list(self._given)[:-_IN_TRANSIT]
        distances = [_distance(motion, time, joints) for motion in known]
        if not distances or min(distances) > _NEARER * off:
            return None
        return known[int(np.argmin(distances))]


def _distance(motion: JointMotion, time: float, joints: Array) -> float:
    """Return how far joints are from a motion at a time, rms [rad]."""
    if time < motion.times[0]:
        return np.inf
    apart = motion.at_or_after(time)[0] - joints
    return float(np.sqrt(np.mean(apart * apart)))
