"""
Mass, its center and its inertia, as links have them and as they add up.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_TRIANGLE = 1e-6
"""Fraction by which the largest principal moment may exceed the sum of the others."""


@dataclass(frozen=True, eq=False)
class Mass:
    """A rigid body's mass, in some frame."""

    amount: float
    """Mass [kg]."""
    center: Array
    """Center of mass, shape (3,) [m]."""
    inertia: Array
    """Inertia about the center of mass in the frame's axes, shape (3, 3) [kg m^2]."""

    def moved(self, pose: Array) -> Mass:
        """Return the same mass in the frame in which ``pose`` (4, 4) places this one."""
        rotation = pose[:3, :3]
        center = rotation @ self.center + pose[:3, 3]
        return Mass(self.amount, center, rotation @ self.inertia @ rotation.T)

    @property
    def radius_of_gyration(self) -> float:
        """Distance from the center at which the mass would have its largest moment [m]."""
        return float(np.sqrt(max(0.0, np.linalg.eigvalsh(self.inertia)[-1]) / self.amount))

    @property
    def is_possible(self) -> bool:
        """Whether a body can have such an inertia: no moment exceeds the sum of the others."""
        if not np.allclose(self.inertia, self.inertia.T, rtol=1e-6, atol=1e-12):
            return False
        moments = np.sort(np.linalg.eigvalsh(self.inertia))
        return bool(moments[0] > 0.0 and moments[2] <= (moments[0] + moments[1]) * (1 + _TRIANGLE))


def no_mass() -> Mass:
    """Return what a link without mass has."""
    return Mass(0.0, np.zeros(3), np.zeros((3, 3)))


def total(masses: Iterable[Mass]) -> Mass:
    """Add masses that are given in one frame (parallel axes)."""
    masses = list(masses)
    amount = sum(mass.amount for mass in masses)
    if amount == 0.0:
        return no_mass()
    center: Array = sum((mass.amount * mass.center for mass in masses), np.zeros(3)) / amount
    inertia = np.zeros((3, 3))
    for mass in masses:
        arm = mass.center - center
        inertia += mass.inertia + mass.amount * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return Mass(amount, center, inertia)


def box_inertia(mass: float, size: Array) -> Array:
    """Return the inertia of a homogeneous box of a size (3,) [m] about its center, (3, 3)."""
    squares = np.square(size)
    inertia: Array = np.diag(mass / 12.0 * (squares.sum() - squares))
    return inertia
