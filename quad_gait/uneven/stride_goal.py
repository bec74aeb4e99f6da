"""
Where a stride over uneven ground leads: footholds, the order of legs, and the body's place.

Down steps some legs need shorter strides. A hind foot that swings first comes down nearly below the
middle of the body, which has not followed yet. Where its knee is behind it, the shin lies nearly
level then, and down a step the edge behind the foot is in its way. A shorter stride leaves it
upright.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError
from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.uneven.candidates import first_possible

Array = NDArray[np.float64]
Planned = TypeVar('Planned')

_SHORTER = 0.5
"""Fraction of a stride that is walked down steps."""

_STEP = 0.2
"""Fraction of the robot's step height by which ground ahead that is lower is a step down."""

_HIND = (2, 3)
"""Legs that come down below the body."""


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

    def footholds_on(self, height_map: HeightMap | None) -> Array:
        """Return the footholds on a map of the ground, or even ground, shape (4, 3) [m]."""
        height: Array = np.zeros(len(LEGS))
        if height_map is not None:
            height = height_map.height_at(self.footholds, beyond=0.0)
        return np.column_stack([self.footholds, height])


class LegOrder:
    """
    The order in which legs swing in a stride, and how far it has come.

    Parameters
    ----------
    legs : tuple of int
        Their indices.
    """

    def __init__(self, legs: tuple[int, ...]) -> None:
        self._legs, self._next = list(legs), 0
        self.hangs = False
        """Whether the foot of the leg that is next hangs in the air, so that no other may swing."""

    @property
    def leg(self) -> int:
        """The leg that swings, or is next; when all have swung, the last."""
        return self._legs[self._next]

    @property
    def ahead(self) -> list[int]:
        """That leg and those after it."""
        return self._legs[self._next :]

    @property
    def has_begun(self) -> bool:
        """Whether a leg has swung."""
        return self._next > 0

    def choose(
        self, plan: Callable[[int], Planned], is_fixed: bool
    ) -> tuple[Planned, GaitError | None]:
        """
        Plan for the leg that is next, or for one after it, which is next then.

        Parameters
        ----------
        plan : callable
            Plans for a leg, or raises GaitError.
        is_fixed : bool
            Whether no other leg may be next.

        Returns
        -------
        planned
            What was planned.
        problem : GaitError or None
            What was wrong with the leg that was next before.

        Raises
        ------
        GaitError
            The same, if there is no other.
        """
        legs = [self.leg] if is_fixed or self.hangs else self.ahead
        (leg, planned), problem = first_possible(
            lambda leg: (leg, plan(leg)), [(leg,) for leg in legs]
        )
        if problem is not None:
            self.bring_forward([leg])
        return planned, problem

    def bring_forward(self, legs: list[int]) -> None:
        """Let legs swing before the others that have not swung."""
        ahead = self.ahead
        first = [leg for leg in ahead if leg in legs]
        self._legs[self._next :] = first + [leg for leg in ahead if leg not in legs]

    def bring_hanging(self, legs: list[int]) -> bool:
        """Let a leg swing next whose foot hangs, if it is the only one, and has not swung yet."""
        if len(legs) != 1 or legs[0] not in self.ahead:
            return False
        self.bring_forward(legs)
        self.hangs = True
        return True

    def advance(self) -> bool:
        """Go on to the next leg; return whether there is one."""
        self.hangs = False
        is_last = self._next == len(self._legs) - 1
        self._next += not is_last
        return not is_last

    def end(self) -> None:
        """Let no other leg swing."""
        self._next = len(self._legs) - 1


class Descent:
    """
    Says how long strides are down steps.

    Parameters
    ----------
    robot : Robot
        The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._has_flat_shins = all(_knee_ahead(robot, leg) < 0.0 for leg in _HIND)

    def shortened(
        self, motion: BodyMotion, pose: Pose2D, height_map: HeightMap | None
    ) -> BodyMotion:
        """
        Return a stride that leaves shins room, where it leads down a step.

        Parameters
        ----------
        motion : BodyMotion
            What is wanted.
        pose : Pose2D
            Pose of the body where it begins.
        height_map : HeightMap or None
            Of the ground, as it was published: for this it need not be right to the centimeter.

        Returns
        -------
        BodyMotion
            A part of it where a foot comes down on lower ground than before within this stride or
            the next, and the same elsewhere.
        """
        if not self._has_flat_shins or motion.forward <= 0.0 or height_map is None:
            return motion
        place, feet = pose, self._robot.neutral_feet
        before = height_map.height_at(place.transform(feet)[:, :2])
        for _ in range(2):
            place = place @ motion.end
            after = height_map.height_at(place.transform(feet)[:, :2])
            # Where nothing is known, a comparison is false.
            if np.any(before - after > _STEP * self._robot.step_height):
                return motion.scaled(_SHORTER)
        return motion


def _knee_ahead(robot: Robot, leg: int) -> float:
    """Return how far a knee is ahead of its foot in the initial posture [m]."""
    foot = robot.neutral_feet[leg]
    knee = robot.legs[leg].chain(robot.legs[leg].inverse(foot))[1]
    return float(knee[0] - foot[0])
