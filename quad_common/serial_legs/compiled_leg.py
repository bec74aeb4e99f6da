"""
The compiled loops of a serial leg, behind functions of arrays.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class CompiledLeg:
    """
    A leg with its first joint at the origin.

    Its compiled loops take time to load, and most robots have none of these legs, hence the
    imports within.
    """

    axes: Array
    """Axes of the joints at 0 in the body frame, unit vectors, shape (3, 3)."""
    arms: Array
    """From each joint to the next, or to the foot, at 0, shape (3, 3) [m]."""

    def feet(self, postures: Array) -> Array:
        """Place the feet of postures (n, 3) [rad], (n, 3) from the first joint [m]."""
        from quad_common.serial_legs.iteration import place_feet

        feet = np.empty((len(postures), 3))
        place_feet(self.axes, self.arms, np.ascontiguousarray(postures), feet)
        return feet

    def solve(self, feet: Array, begin: Array, near: float) -> tuple[Array, Array]:
        """
        Iterate from postures (n, 3) [rad] to feet (n, 3) from the first joint [m].

        Returns the postures, and how far their feet are from those that are wanted, (n,) [m].
        """
        from quad_common.serial_legs.iteration import iterate

        postures, left = np.array(begin), np.empty(len(feet))
        iterate(self.axes, self.arms, np.ascontiguousarray(feet), postures, left, near)
        return postures, left

    def stays_regular(self, nominal: Array, postures: Array) -> NDArray[np.bool_]:
        """Return which postures (n, 3) a straight line joins to the nominal one, all regular."""
        from quad_common.serial_legs.iteration import stays_regular

        is_regular = np.empty(len(postures), dtype=np.bool_)
        stays_regular(
            self.axes, self.arms, np.asarray(nominal), np.ascontiguousarray(postures), is_regular
        )
        return is_regular
