"""
How a difference between two commands fades out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fading:
    """
    A difference to the trajectory that goes to zero with minimum jerk.

    It is the same fraction of the whole for all joints: so their posture is on the straight line
    from where they were commanded into the trajectory.
    """

    start: float
    """Time when it begins [s]."""
    duration: float
    """Time until nothing is left of it [s]."""
    offset: Array
    """Offsets of the joints at its start, shape (n,) [rad]."""

    @property
    def end(self) -> float:
        """Time when nothing is left of it [s]."""
        return self.start + self.duration

    def at(self, time: float) -> tuple[Array, Array]:
        """Return what is left, in position and in velocity."""
        s = (time - self.start) / self.duration
        left = 1.0 - s**3 * (10.0 - 15.0 * s + 6.0 * s * s)
        rate = -30.0 * s * s * (1.0 - s) ** 2 / self.duration
        return left * self.offset, rate * self.offset
