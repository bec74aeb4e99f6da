"""
A leg's lengths, offsets, signs and zeros in the terms of closed-form kinematics.

The terms are those of :mod:`quad_common.robot.leg_kinematics`. They hold for any leg whose pitch
and knee axes are parallel and at right angles to its first axis: offsets along the pitch axis,
wherever they are in the leg, add up to one lateral offset.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_kinematics import Leg

Array = NDArray[np.float64]

_ASIDE = 0.5
"""Cosine below which a leg at 0 does not point where its kind does: its foot tells then."""

_TURN = 2.0 * math.pi


@dataclass(frozen=True, eq=False)
class LegAtZero:
    """A leg at the zero of its joints, in base_link's frame."""

    name: str
    """Name of the leg, one of ``LEGS``."""
    hip: Array
    """Point of the first axis that is level with the pitch axis, shape (3,) [m]."""
    axes: Array
    """Axes of the three joints, unit vectors, shape (3, 3)."""
    points: Array
    """Origins of the three joints, shape (3, 3) [m]."""
    foot: Array
    """Center of the foot, shape (3,) [m]."""


def leg_geometry(leg: LegAtZero, is_upright: bool) -> Leg:
    """
    Find a leg's geometry.

    Parameters
    ----------
    leg : LegAtZero
        The leg.
    is_upright : bool
        Whether its first axis is upright; along the body otherwise.

    Returns
    -------
    Leg
        Its knee's sign is +1 and its middles are 0: :mod:`~quad_common.importing.ranges` finds
        them.
    """
    zeta, rho0, rho, nu = _axes(leg, is_upright)

    def in_plane(arm: Array) -> tuple[float, float]:
        """Return length and angle of an arm in the leg's plane."""
        along, across = float(arm @ rho), float(arm @ zeta)
        return math.hypot(along, across), math.atan2(-across, along)

    pitch_axis, knee = leg.points[1], leg.points[2]
    thigh, pitch = in_plane(knee - pitch_axis)
    calf, calf_angle = in_plane(leg.foot - knee)
    bend = math.remainder(calf_angle - pitch, _TURN)
    yaw = math.atan2(float(rho @ np.cross(zeta, rho0)), float(rho @ rho0))
    return Leg(
        name=leg.name,
        hip=leg.hip,
        first_axis=zeta,
        radial_direction=rho0,
        axial_offset=float((pitch_axis - leg.hip) @ zeta),
        radial_offset=float((pitch_axis - leg.hip) @ rho),
        lateral_offset=float((leg.foot - leg.hip) @ nu),
        thigh_length=thigh,
        calf_length=calf,
        signs=(
            float(np.sign(leg.axes[0] @ zeta)),
            float(np.sign(leg.axes[1] @ nu)),
            float(np.sign(leg.axes[2] @ nu)),
        ),
        zeros=(yaw, pitch, bend),
    )


def _axes(leg: LegAtZero, is_upright: bool) -> tuple[Array, Array, Array, Array]:
    """
    Find the axes of a leg's plane.

    Returns
    -------
    zeta, rho0, rho, nu : ndarray, shape (3,)
        The first axis; the plane's direction where the first joint's angle is 0 in closed form;
        its direction at the zero of the robot's own joint; the pitch axis there.
    """
    side = 1.0 if leg.hip[1] > 0.0 else -1.0
    wanted = np.array([0.0, 0.0, 1.0]) if is_upright else np.array([1.0, 0.0, 0.0])
    outward = np.array([0.0, side, 0.0]) if is_upright else np.array([0.0, 0.0, -1.0])
    zeta = leg.axes[0] * np.sign(leg.axes[0] @ wanted)
    rho0 = outward - zeta * float(outward @ zeta)
    rho0 /= np.linalg.norm(rho0)
    # Rounded in the description, the pitch axis is made square to the first.
    nu = leg.axes[1] - zeta * float(leg.axes[1] @ zeta)
    nu /= np.linalg.norm(nu)
    rho = np.cross(nu, zeta)
    if abs(float(rho @ rho0)) < _ASIDE:
        is_away = float((leg.foot - leg.hip) @ rho) < 0.0
    else:
        is_away = float(rho @ rho0) < 0.0
    return (zeta, rho0, -rho, -nu) if is_away else (zeta, rho0, rho, nu)
