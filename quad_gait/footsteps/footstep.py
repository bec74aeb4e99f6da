"""
Footsteps, and plans of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Footstep:
    """One foot goes somewhere."""

    leg: int
    """Index of the leg."""
    foothold: Array
    """Center of the foot where it is to stand, shape (3,) [m]."""
    feet: Array
    """Centers of all feet then, shape (4, 3) [m]."""


@dataclass(frozen=True)
class FootstepPlan:
    """Steps one after the other, and what they cost."""

    steps: tuple[Footstep, ...]
    """The steps; none where the robot is there."""
    cost: float
    """Number of steps, and some more for legs far from their initial posture and for turns."""
    expansions: int
    """Number of stances from which steps were looked for."""
    is_best: bool
    """Whether no path over this lattice costs less."""
