"""
Where a leg of any three axes may be without becoming singular: the aspect that it walks in.

The postures of such a leg fall apart into aspects, parts of the joint space in which the Jacobian
is regular (Borrel and Liegeois 1986). A leg that keeps to one can follow any path of its foot
there without a jump, and, but for a few special builds, has one posture for each place of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label
from scipy.spatial import cKDTree

Array = NDArray[np.float64]

_NODES = 15
"""Number of angles of each joint on the grid."""

_NEAREST = 4
"""Number of nodes near a place; iteration begins at that whose posture is nearest to the
nominal one, which tells two postures of one place apart."""


@dataclass(frozen=True, eq=False)
class Aspect:
    """Postures of a leg on a grid, joined to its nominal one by regular postures."""

    postures: Array
    """Joint angles, shape (n, 3) [rad]."""
    tree: Any
    """Places of the feet of these postures, for a search by distance."""
    strangeness: Array
    """Distances of the postures from the nominal one, shape (n,) [rad]."""
    sign: float
    """Sign of the Jacobian's determinant."""

    def seeds(self, feet: Array) -> Array:
        """Return postures (n, 3) [rad] whose feet are near places (n, 3) [m]."""
        count = min(_NEAREST, len(self.postures))
        found = np.reshape(self.tree.query(feet, k=count)[1], (len(feet), count))
        usual = np.argmin(self.strangeness[found], axis=1)
        seeds: Array = self.postures[found[np.arange(len(feet)), usual]]
        return seeds


def posture_grid(lower: Array, upper: Array, count: int = _NODES) -> Array:
    """Return postures over ranges (3,), shape (count, count, count, 3) [rad]."""
    angles = [np.linspace(low, high, count) for low, high in zip(lower, upper)]
    return np.stack(np.meshgrid(*angles, indexing='ij'), axis=-1)


def aspect_around(
    nominal: Array, postures: Array, feet: Array, determinants: Array, determinant: float
) -> Aspect:
    """
    Find the aspect of a posture.

    Parameters
    ----------
    nominal : ndarray, shape (3,)
        A regular posture [rad].
    postures, feet : ndarray, shape (m, m, m, 3)
        Grid of postures [rad], and their feet in the body frame [m].
    determinants : ndarray, shape (m, m, m)
        Determinants of their Jacobians.
    determinant : float
        That of the nominal posture.
    """
    sign = float(np.sign(determinant))
    parts, _ = label(np.sign(determinants) == sign)
    distances = np.linalg.norm(postures - nominal, axis=-1)
    nearest = np.unravel_index(int(np.argmin(np.where(parts > 0, distances, np.inf))), parts.shape)
    own = parts == parts[nearest] if parts[nearest] > 0 else distances == distances.min()
    return Aspect(postures[own], cKDTree(feet[own]), distances[own], sign)
