"""
Notices a joint whose motor does not pull it back, however little it is off its command.

A joint without torque may follow its leg for more than a cycle and never be far from its command,
as a roll joint of a leg that swings straight ahead. But the drive of a sound one pulls as soon as
it is off: it gives no torque at all only where it is on its command.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PullOptions:
    """When a joint is off, and its motor should pull."""

    none: float = 0.005
    """Fraction of its torque below which a motor gives none at all."""
    distance: float = 0.0075
    """Distance from its command from which on a drive pulls a joint at rest [rad]."""
    lag: float = 0.03
    """Time by which a joint that turns may be behind without a pull [s]."""
    patience: float = 0.4
    """Time that a joint must have been off without a pull, with breaks [s]."""
    longest_break: float = 0.5
    """Time after which a joint that was off is not any more [s]."""
    others: int = 4
    """Number of other joints that must have turned meanwhile: their trajectory is executed."""
    turned: float = 0.02
    """Angle by which they must have turned [rad]."""


class PullCheck:
    """
    Counts for how long a joint is off its command though its motor gives no torque.

    Parameters
    ----------
    largest : ndarray, shape (n,)
        Largest torques of the motors [N m].
    options : PullOptions, optional
        When a motor should pull.
    """

    def __init__(self, largest: Array, options: PullOptions | None = None) -> None:
        self._options = PullOptions() if options is None else options
        self._least = self._options.none * largest
        self.forget()

    def forget(self) -> None:
        """Know nothing against any joint."""
        self._suspect = -1
        self._off_for = self._break = 0.0
        self._anchors: Array | None = None

    def update(
        self, commanded: Array, speeds: Array, positions: Array, efforts: Array, step: float
    ) -> int:
        """
        Take a measurement of joints that all follow their commands within their tolerances.

        Parameters
        ----------
        commanded, speeds : ndarray, shape (n,)
            Where the joints should be [rad], and the most that they are commanded to turn at about
            that time [rad/s].
        positions : ndarray, shape (n,)
            Where they are [rad].
        efforts : ndarray, shape (n,)
            Torques of their motors [N m].
        step : float
            Time since the last measurement [s].

        Returns
        -------
        int
            The joint whose motor does not pull; -1 for none.
        """
        options = self._options
        gives_none = np.abs(efforts) < self._least
        if self._suspect >= 0 and not gives_none[self._suspect]:
            self.forget()
        off = np.abs(positions - commanded) > options.distance + options.lag * speeds
        idle = np.flatnonzero(off & gives_none)
        self._break += step
        if len(idle) != 1:
            # Joints that rest together wait for their trajectory.
            if len(idle) > 1 or self._break > options.longest_break:
                self.forget()
            return -1
        joint = int(idle[0])
        if joint != self._suspect or self._anchors is None:
            self._suspect, self._off_for, self._anchors = joint, 0.0, positions
        self._break = 0.0
        self._off_for += step
        if self._off_for < options.patience - 1e-9:
            return -1
        turned = np.abs(positions - self._anchors) > options.turned
        turned[joint] = False
        return joint if np.count_nonzero(turned) >= options.others else -1
