"""
Where a stride over uneven ground leads: footholds, the order of legs, and the body's place.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StrideGoal:
    """Where a stride leads."""

    order: tuple[int, ...]
    """Legs in the order in which they swing."""
    footholds: Array
    """Where their feet are to stand, in the plan's frame, shape (4, 2) [m]."""
    place: Pose2D
    """Pose of the body at the end, in the plan's frame."""
    is_exact: bool = False
    """Whether the footholds were chosen, and feet go there in this order or not at all."""

    @classmethod
    def of(cls, robot: Robot, gait: Gait, motion: BodyMotion, pose: Pose2D) -> StrideGoal:
        """Bring all feet on by a motion of the body from a pose, in the order of a gait."""
        place = pose @ motion.end
        order = tuple(LEGS.index(swing.leg) for swing in gait.swings)
        return cls(order, place.transform(robot.neutral_feet)[:, :2], place)
