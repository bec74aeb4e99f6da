"""
Poses as homogeneous matrices, shape (4, 4).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def pose_of(origin: Any) -> Array:
    """Return an origin of a description as a matrix, shape (4, 4); it may be left out."""
    return np.eye(4) if origin is None else np.array(origin, dtype=float)


def inverse(pose: Array) -> Array:
    """Return the pose of the first frame in the second for one of the second in the first."""
    back: Array = np.eye(4)
    back[:3, :3] = pose[:3, :3].T
    back[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return back


def moved(pose: Array, points: Array) -> Array:
    """Take points (..., 3) from the frame that a pose places to the one it is placed in."""
    placed: Array = points @ pose[:3, :3].T + pose[:3, 3]
    return placed
