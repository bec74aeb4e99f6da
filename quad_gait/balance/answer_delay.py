"""
By how much later than they should answers to measurements take effect.
"""

from __future__ import annotations

import math
from collections import deque

import numpy as np
from numpy.typing import NDArray

from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.joint_motion import JointMotion

Array = NDArray[np.float64]

_REMEMBERED = 0.98
"""Part of what was seen at one measurement that counts at the next."""

_NOTHING = np.diag([1e-9, 2e-5, 2e-5])
"""Sums of squared differences between motions that tell nothing yet [rad^2]."""


class AnswerDelay:
    """
    Finds out by the joints which of the last answers they follow.

    A trajectory that replaces another one is followed once it has arrived, and in its own time:
    joints do not lag for it. But until then they do what was given out before, and where that is
    something else, they tell. Of the instant of a measurement the last n + 1 answers say the same,
    if what was given out before holds for n times the time between decisions. With q_k where joints
    would be by the k-th last one, from 0, joints at q that follow their motion by a time T late are
    at::

        q = q_n + a (q_(n+1) - q_n) + b (q_(n+2) - q_(n+1)) - T dq_n / dt

    with a = 0 if answers are in time and 1 if they take effect one decision later. a, b and T
    follow by recursive least squares that forget, over a second.

    Parameters
    ----------
    options : BalanceOptions
        The reaction time, and that between decisions.
    """

    def __init__(self, options: BalanceOptions) -> None:
        self._held = math.ceil(options.reaction_time / options.knot_time - 1e-6)
        self._motions: deque[JointMotion] = deque(maxlen=self._held + 3)
        self._seen: Array = np.zeros((3, 3))
        self._told: Array = np.zeros(3)

    def take(self, time: float, joints: Array, given: JointMotion) -> float:
        """
        Take notice of a measurement.

        Parameters
        ----------
        time : float
            When it was taken [s].
        joints : ndarray, shape (4, 3)
            Joint positions [rad].
        given : JointMotion
            What was given out last.

        Returns
        -------
        float
            Time after which answers take effect over that between two decisions, less 1: 0 if it is
            no longer, and 1 at most.
        """
        self._motions.append(given)
        last = self._motions
        is_full = len(last) == last.maxlen
        if is_full and all(m.times[0] <= time <= m.times[-1] for m in list(last)[:3]):
            third, second, first = (m.at(time) for m in list(last)[:3])
            rows = np.stack([0.01 * first[1], second[0] - first[0], third[0] - second[0]])
            rows = rows.reshape(3, -1)
            self._seen = _REMEMBERED * self._seen + rows @ rows.T
            self._told = _REMEMBERED * self._told + rows @ (joints - first[0]).reshape(-1)
        late = float(np.linalg.solve(self._seen + _NOTHING, self._told)[1])
        return min(max(self._held + late - 1.0, 0.0), 1.0)
