"""
By how much later than they should answers to measurements take effect.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from quad_gait.balance.joint_motion import JointMotion

Array = NDArray[np.float64]

_REMEMBERED = 0.98
"""Part of what was seen at one measurement that counts at the next."""

_NOTHING = np.diag([1e-9, 2e-5, 2e-5])
"""Sums of squared differences between motions that tell nothing yet [rad^2]."""

_LAST = 4
"""Number of motions that joints may be following."""


class AnswerDelay:
    """
    Finds out by the joints which of the last answers they follow.

    A trajectory that replaces another one is followed once it has arrived, and in its own time:
    joints do not lag for it. But until then they do what was given out before, and where that is
    something else, they tell. With q_k where they would be by the k-th last answer, from 0, at the
    instant of a measurement, of which answers 0 and 1 say the same if the reaction time is that
    between decisions, joints at q that follow their motion by a time T late are at::

        q = q_1 + a (q_2 - q_1) + b (q_3 - q_2) - T dq_1 / dt

    with a = 0 if the last answer is in time and 1 if it takes effect one decision later. a, b and T
    follow by recursive least squares that forget, over a second.
    """

    def __init__(self) -> None:
        self._motions: deque[JointMotion] = deque(maxlen=_LAST)
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
            Delay of answers beyond the reaction time, in the time between two decisions, from 0 to
            1.
        """
        self._motions.append(given)
        last = self._motions
        if len(last) == _LAST and all(m.times[0] <= time <= m.times[-1] for m in last):
            third, second, first = (m.at(time) for m in list(last)[:3])
            rows = np.stack([0.01 * first[1], second[0] - first[0], third[0] - second[0]])
            rows = rows.reshape(3, -1)
            self._seen = _REMEMBERED * self._seen + rows @ rows.T
            self._told = _REMEMBERED * self._told + rows @ (joints - first[0]).reshape(-1)
        late = float(np.linalg.solve(self._seen + _NOTHING, self._told)[1])
        return min(max(late, 0.0), 1.0)
