"""
What whoever moves the robot knows of its feet and its body, beside what its sensors say.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class Support(NamedTuple):
    """What bears the robot, and how it moves over that."""

    in_contact: NDArray[np.bool_] | None = None
    """Which feet stand, shape (4,); None for those that are the lowest."""
    velocity: tuple[float, float] | None = None
    """Velocity of the body along its heading and to the left, by a filter of legs and imu [m/s];
    None for what the feet say."""


BY_FEET = Support()
"""What is known of a robot of which only its sensors tell."""

Supports = Callable[[float], Support]
"""What is known at a time [s]."""
