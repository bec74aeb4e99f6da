"""
How a foot feels for the ground: straight down, gently at first.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def ramp(duration: float) -> float:
    """Return how much longer a search takes because it begins gently [s]."""
    return 0.0 if duration <= 0.0 else 0.03


def searched(times: Array, speed: float, depth: float) -> Array:
    """Return how far down a foot has felt: it gathers speed, then keeps it [m]."""
    begun = 2.0 * ramp(1.0)
    gathered = np.where(times < begun, times**2 / (2.0 * begun), times - begun / 2.0)
    distances: Array = np.clip(speed * np.where(times > 0.0, gathered, 0.0), 0.0, depth)
    return distances
