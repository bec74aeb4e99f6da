"""
What the time of a walk is counted by: the robot's pace, its headings, and a bound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot_files.walking_time import WalkingTimeModel


@dataclass(frozen=True)
class WalkTerms:
    """Times and bounds by which the gait cycles of a walk to a goal are counted."""

    pace: WalkingTimeModel
    """Distances and turns of a cycle."""
    resolution: float
    """Side of a cell [m]."""
    start_yaw: float
    """Heading at the start, in the frame of the cells [rad]."""
    goal_yaw: float
    """Heading at the goal, in the frame of the cells [rad]."""
    bound: int
    """Number of cycles: a path must take less."""
    weights: NDArray[np.int32] | None = None
    """
    Factors by which walking through cells takes longer, in sixteenths, shape (height, width); at
    least 16.
    """
