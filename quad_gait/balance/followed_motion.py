"""
Which of the joint motions that were given out the joints follow.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.joint_motion import JointMotion

Array = NDArray[np.float64]

_REMEMBERED = 40
"""Number of motions that are remembered, besides one that was found to be followed."""

_OFF = 0.03
"""Distance of the joints from the last motion up to which they follow it, rms [rad]; times the
reaction time over that between decisions, if it is longer: drives that are given what begins later
are on their way there, and off what they were given before."""

_NEARER = 0.5
"""Fraction of that distance at which they must be from another one, at most."""

_IN_TRANSIT = 6
"""Number of the last motions that may still arrive, besides those within the reaction time."""


class FollowedMotion:
    """
    Remembers the joint motions that were given out.

    Parameters
    ----------
    options : BalanceOptions
        The reaction time, and that between decisions.
    """

    def __init__(self, options: BalanceOptions) -> None:
        held = options.reaction_time / options.knot_time
        self._in_transit = _IN_TRANSIT + math.ceil(held - 1e-6)
        self._off = _OFF * max(held, 1.0)
        self._given: deque[JointMotion] = deque(maxlen=_REMEMBERED)
        self._found: JointMotion | None = None

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
        # What was given out holds for the reaction time: the last ones have not begun yet.
        begun = [motion for motion in self._given if motion.times[0] <= time]
        known = begun[: -self._in_transit]
        if not known:
            return None
        off = _distance(begun[-1], time, joints)
        if off <= self._off:
            return None
        if self._found is not None:
            known.append(self._found)
        distances = [_distance(motion, time, joints) for motion in known]
        nearest = int(np.argmin(distances))
        if distances[nearest] > _NEARER * off:
            return None
        self._found = known[nearest]
        return self._found


def _distance(motion: JointMotion, time: float, joints: Array) -> float:
    """Return how far joints are from a motion at a time, rms [rad]."""
    apart = (motion.at_or_after(time)[0] - joints).reshape(-1)
    return math.sqrt(float(apart @ apart) / apart.size)
