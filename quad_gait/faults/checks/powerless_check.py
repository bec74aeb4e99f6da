"""
Notices a joint without torque whose command is hidden by a trajectory that is followed no more.

After each trajectory that is given out it takes a while until the earlier ones are void. What a
joint without torque does by chance may fit one of them, or the transition into the latest, while
all other joints follow the latest closely. How much worse that fits is summed up over time, as in
Page's test (CUSUM; Biometrika 41, 1954): with the distance e of each joint from its command, in
units of what sound joints may be off,

    S <- max(0, S + dt * (sum of e^2 over all joints, of what would explain them
                          - sum of e^2 over all joints but one, of the latest trajectory - drift))

A sound joint whose motor gives no torque adds less than the drift: a drive that is farther off
would pull.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PowerlessOptions:
    """When a joint without torque has failed."""

    tight: float = 0.43
    """Largest distance of all other joints from the latest trajectory, as a fraction of what sound
    joints may be off."""
    drift: float = 0.13
    """Evidence per second that a sound joint without torque may give: the square of the
    fraction of its tolerance by which it may be off."""
    evidence: float = 0.04
    """Evidence from which on the joint has failed [s]."""
    patience: float = 0.12
    """Time for which it must have been gathered at least [s]."""


class PowerlessCheck:
    """
    Sums up what tells that one joint does not follow the latest trajectory, and all others do.

    Parameters
    ----------
    options : PowerlessOptions, optional
        When a joint has failed.
    """

    def __init__(self, options: PowerlessOptions | None = None) -> None:
        self._options = PowerlessOptions() if options is None else options
        self.forget()

    def forget(self) -> None:
        """Know nothing against any joint."""
        self._joint = -1
        self._evidence = self._gathered_for = 0.0
        self.since = 0.0
        """Position of the joint when it was first off [rad]."""

    def update(
        self,
        latest: tuple[Array, Array],
        explained: tuple[Array, Array],
        positions: Array,
        strictness: Array,
        step: float,
    ) -> int:
        """
        Take a measurement.

        Parameters
        ----------
        latest, explained : tuple of ndarray, shape (n,)
            Where the joints should be, and what they may be off [rad]: by the latest trajectory,
            and by what explains them best.
        positions : ndarray, shape (n,)
            Where they are [rad].
        strictness : ndarray, shape (n,)
            By so much less joints may be off whose motors give no torque; 0 for others [rad].
        step : float
            Time since the last measurement [s].

        Returns
        -------
        int
            The joint that has failed; -1 for none.
        """
        options = self._options
        off = np.abs(positions - latest[0])
        fraction = off / latest[1]
        joint = int(fraction.argmax())
        others = np.delete(fraction, joint)
        is_off = strictness[joint] > 0.0 and off[joint] > latest[1][joint] - strictness[joint]
        if not is_off or float(others.max()) > options.tight:
            self.forget()
            return -1
        if joint != self._joint:
            self.forget()
            self._joint, self.since = joint, float(positions[joint])
        explained_fraction = (positions - explained[0]) / explained[1]
        gain = float((explained_fraction**2).sum() - (others**2).sum())
        self._evidence = max(0.0, self._evidence + step * (gain - options.drift))
        self._gathered_for += step
        is_clear = self._evidence >= options.evidence
        return joint if is_clear and self._gathered_for >= options.patience - 1e-9 else -1
