"""
Where a robot's mass is, link by link, as its description states it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_kinematics import Leg

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class ExactMasses:
    """
    Masses of the body and of the three moving parts of each leg, and their centers.

    A part is everything that moves with one joint: its link, and what is fixed to it. Centers of
    a leg's parts are given in axes that turn with them, named as in
    :mod:`quad_common.robot.leg_kinematics`: the hip's from the hip point along rho, nu and zeta;
    those of thigh and calf from the pitch axis and from the knee, along the link, along nu, and
    along their vector product.
    """

    body: float
    """Mass of the body [kg]."""
    body_center: Array
    """Center of the body's mass in the body frame, shape (3,) [m]."""
    parts: Array
    """Masses of hip, thigh and calf of each leg, the foot's in the calf's, shape (4, 3) [kg]."""
    centers: Array
    """Centers of these masses, each in its part's own axes, shape (4, 3, 3) [m]."""
    inertias: Array | None = None
    """Inertias about these centers, each in its part's own axes, shape (4, 3, 3, 3) [kg m^2]; None
    where they are not known."""

    @cached_property
    def total(self) -> float:
        """Mass of the whole robot [kg]."""
        return self.body + float(self.parts.sum())

    def center(self, legs: Leg, joint_angles: Array, chain: tuple[Array, Array, Array]) -> Array:
        """
        Find the center of mass.

        Parameters
        ----------
        legs : Leg
            The four stacked legs.
        joint_angles : ndarray, shape (..., 4, 3)
            [rad]
        chain : tuple of ndarray
            Pitch axes, knees and feet in the body frame, each of shape (..., 4, 3), where these
            angles place them [m].

        Returns
        -------
        ndarray, shape (..., 3)
            In the body frame [m].
        """
        moment: Array = np.zeros(())
        for part, (start, axes) in enumerate(legs.part_frames(joint_angles, chain)):
            place = self.places(part, start, axes)
            moment = moment + np.sum(self.parts[:, part, None] * place, axis=-2)
        center: Array = (moment + self.body * self.body_center) / self.total
        return center

    def places(self, part: int, start: Array, axes: tuple[Array, ...]) -> Array:
        """
        Place the centers of one part of all legs.

        Parameters
        ----------
        part : int
            Hip, thigh or calf: 0, 1 or 2.
        start : ndarray, shape (..., 4, 3)
            Where it begins, as :meth:`Leg.part_frames` gives it [m].
        axes : tuple of ndarray
            Its three axes, of shape (..., 4, 3) or (4, 3) each.

        Returns
        -------
        ndarray, shape (..., 4, 3)
            [m]
        """
        place = start
        for k, axis in enumerate(axes):
            place = place + self.centers[:, part, k, None] * axis
        return place
