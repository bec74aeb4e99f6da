"""
Where the body goes so that its center of mass is inside the feet that stand.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import GaitError, SupportTooNarrow
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS
from quad_gait.state.body_placement import BodyPose, inner_radius
from quad_gait.state.stance import CenterOfMass, Stance

Array = NDArray[np.float64]

Inside = Callable[[Array], Array]
"""Moves a point (2,) to where it is inside feet, or leaves it [m]."""

_FAR = 0.1
"""Distance of the body's motion from which on it counts that its legs do not go with it [m, of
TITAN-VIII]."""

_MOST_CORRECTIONS = 3
"""Number of times that the posture is found anew: each halves what is left at least."""


class BodyBalance:
    """
    Balances a body over feet.

    Parameters
    ----------
    robot : Robot
        The robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._center = CenterOfMass(robot)

    def check_support(self, now: Stance, leg: int, least: float) -> None:
        """
        Refuse to have a foot lifted while the others are nearly in line.

        Parameters
        ----------
        now : Stance
            The robot as it stands.
        leg : int
            Index of the leg that is to swing.
        least : float
            Distance of the center of mass inside the edges between the others, at least [m].

        Raises
        ------
        SupportTooNarrow
            If no point is so far inside.
        """
        room = inner_radius(np.delete(now.feet[:, :2], leg, axis=0))
        if room < least:
            raise SupportTooNarrow(LEGS[leg], room)

    def balanced(self, body: BodyPose, now: Stance, inside: Inside) -> BodyPose:
        """
        Move the body so that its center of mass is inside feet.

        Where it goes far that is found for the posture there: legs, half of the weight of some
        robots, stay behind.

        Parameters
        ----------
        body : BodyPose
            Where it would go.
        now : Stance
            The robot as it stands.
        inside : callable
            Where the center of mass may be.

        Returns
        -------
        BodyPose
        """
        body = centered(body, self._center.in_body(now), inside)
        far = self._robot.relative_size * _FAR
        if math.dist(body.position[:2], now.body.position[:2]) <= far:
            return body
        for _ in range(_MOST_CORRECTIONS):
            try:
                joints = self._robot.stacked_legs.inverse(
                    (now.feet - body.position) @ body.rotation
                )
            except GaitError:
                # Whoever plans the motion finds out that legs do not reach, and says so.
                break
            body = centered(body, self._robot.center_of_mass(joints), inside)
        return body


def centered(body: BodyPose, center: Array, inside: Inside) -> BodyPose:
    """
    Move a body so that its center of mass is inside feet.

    Parameters
    ----------
    body : BodyPose
        Where it would go.
    center : ndarray, shape (3,)
        Its center of mass, in its frame [m].
    inside : callable
        Where that may be.

    Returns
    -------
    BodyPose
    """
    offset = (body.rotation @ center)[:2]
    place = inside(body.position[:2] + offset) - offset
    return BodyPose(np.array([*place, body.position[2]]), body.roll, body.pitch, body.yaw)
