"""
Which feet bear load, and where one met the ground.
"""

from __future__ import annotations

import numpy as np

from quad_common.robot.leg_moments import GRAVITY
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.state.stance import Stance
from quad_gait.uneven.uneven_options import UnevenOptions

_SURE = 3.0
"""Multiple of the load that counts as contact that needs no second measurement."""

_LITTLE = 0.2
"""Fraction of the load that counts as contact, below which a foot bears next to nothing."""


def load_fraction(robot: Robot, now: Stance, leg: int) -> float:
    """Return what a foot bears, as a fraction of the robot's weight; 0 where motors do not tell."""
    if now.loads is None:
        return 0.0
    return float(now.loads[leg]) / (robot.mass * GRAVITY)


def loaded_legs(robot: Robot, now: Stance, options: UnevenOptions) -> list[int]:
    """Return the legs whose feet are in contact by their load; none where motors do not tell."""
    least = options.contact_fraction
    return [leg for leg in range(len(LEGS)) if load_fraction(robot, now, leg) > least]


def unloaded_legs(robot: Robot, now: Stance, options: UnevenOptions) -> list[int]:
    """Return the legs whose feet bear next to nothing; none where motors do not tell."""
    if now.loads is None:
        return []
    little = _LITTLE * options.contact_fraction * robot.mass * GRAVITY
    return [leg for leg in range(len(LEGS)) if now.loads[leg] < little]


def may_stand(robot: Robot, met: Stance, leg: int) -> bool:
    """Tell whether a foot can stand on what it has met: on what is higher than a step it cannot."""
    others = np.delete(met.feet[:, 2], leg)
    return float(met.feet[leg, 2] - others.max()) <= robot.step_height + robot.roughness


def as_touched(
    robot: Robot, leg: int, before: Stance | None, touched: Stance, now: Stance
) -> Stance:
    """
    Return the robot as it was when the foot met the ground, once the contact is sure.

    Until then the foot presses on, and tilts the body: the other feet are
    where they were before, and this one belongs where it was at the first touch.

    Parameters
    ----------
    robot : Robot
        The robot.
    leg : int
        Index of the leg whose foot it is.
    before : Stance or None
        The last measurement without load on it; None if there was none.
    touched : Stance
        The first with load.
    now : Stance
        The newest.

    Returns
    -------
    Stance
    """
    if before is None:
        return now
    joints = now.joint_positions.copy()
    joints[leg] = touched.joint_positions[leg]
    feet = before.body.transform(robot.foot_positions(joints))
    return Stance(now.time, before.body, feet, joints, lambda: now.loads)


class Touch:
    """
    Waits until it is sure that a foot has met the ground.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    """

    def __init__(self, robot: Robot, options: UnevenOptions) -> None:
        self._robot, self._options = robot, options
        self.forget()

    def forget(self) -> None:
        """Begin with another swing."""
        self._before: Stance | None = None
        self._first: Stance | None = None

    def look(self, now: Stance, leg: int) -> tuple[bool, Stance | None]:
        """Return whether a foot bears load, and the robot as it met the ground, once sure."""
        fraction, least = load_fraction(self._robot, now, leg), self._options.contact_fraction
        if fraction <= least:
            self._before, self._first = now, None
            return False, None
        if self._first is None:
            self._first = now
            if fraction <= _SURE * least:
                return True, None
        return True, as_touched(self._robot, leg, self._before, self._first, now)
