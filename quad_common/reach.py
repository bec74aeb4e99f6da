"""
How far a leg reaches, and what stride and turn follow from it (S0 sec. 4).

A leg that sprawls sideways swings a stride about its yaw axis; one that stands under
the body swings it in its own plane.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import RobotModelError
from quad_common.leg_kinematics import Leg

Array = NDArray[np.float64]


def largest_stretch(leg: Leg, hip_height: float, roughness: float) -> float:
    """
    Largest horizontal distance from a yaw axis to the foot (S0 eq. 16, corrected).

    The paper prints e under the root, which would not even give the initial posture;
    it stands outside: A_max = sqrt((b + d)^2 - (H0 + dh + dv - a)^2) + e.

    Parameters
    ----------
    leg : Leg
        Geometry of a leg whose first axis is vertical.
    hip_height : float
        Height of the hip above the foot, H0 [m].
    roughness : float
        How much lower the ground may be than expected, dh + dv [m].

    Returns
    -------
    float
        A_max [m].

    Raises
    ------
    RobotModelError
        If the leg does not reach down that far at all.
    """
    down = hip_height + roughness + float(leg.axial_offset)
    return _across(leg, down) + float(leg.radial_offset)


def largest_step(leg: Leg, foot: Array, roughness: float) -> float:
    """
    Longest way that a leg with a roll axis carries its foot fore-aft, either way.

    At a height ``down`` below the pitch axis, the foot gets
    sqrt((thigh + calf)^2 - down^2) forward and backward of that axis; where it stands
    is taken off.

    Parameters
    ----------
    leg : Leg
        Geometry of a leg whose first axis lies along the body.
    foot : ndarray, shape (3,)
        Where the foot stands, in the body frame [m].
    roughness : float
        How much lower the ground may be than expected, dh + dv [m].

    Returns
    -------
    float
        S_max [m].

    Raises
    ------
    RobotModelError
        If the leg does not reach down that far at all.
    """
    arm = foot - leg.hip - [0.0, 0.0, roughness]
    x, y = float(arm @ leg.radial_direction), float(arm @ leg.lateral_direction)
    # In the leg's plane, which its roll axis passes at the lateral offset.
    length = math.sqrt(max(0.0, x**2 + y**2 - float(leg.lateral_offset) ** 2))
    fore_aft = float(arm @ leg.first_axis) - float(leg.axial_offset)
    return max(0.0, _across(leg, length - float(leg.radial_offset)) - abs(fore_aft))


def _across(leg: Leg, down: float) -> float:
    """How far from the pitch axis the foot gets horizontally, ``down`` below it [m]."""
    longest = float(leg.thigh_length + leg.calf_length)
    if abs(down) > longest:
        raise RobotModelError(
            f'leg {leg.name} is {longest:.3f} m long and cannot reach {down:.3f} m down; '
            f'lower the body or the roughness'
        )
    return math.sqrt(longest**2 - down**2)


def largest_stride(stretch: float, stance_reach: float) -> float:
    """
    Longest footstep of a gait cycle: S_max = sqrt(A_max^2 - L0^2).

    Parameters
    ----------
    stretch : float
        A_max [m].
    stance_reach : float
        Horizontal distance from yaw axis to foot in the initial posture, L0 [m].

    Returns
    -------
    float
        S_max [m].
    """
    if stretch < stance_reach:
        raise RobotModelError(
            f'the largest stretch {stretch:.3f} m is less than the initial posture needs, '
            f'{stance_reach:.3f} m'
        )
    return math.sqrt(stretch**2 - stance_reach**2)


def largest_turn(stride: float, foot_distance: float) -> float:
    """
    Largest turn of one standstill-turning cycle, phi_max.

    The paper states 44 degrees without a derivation. It is the angle whose chord, at
    the feet's distance from the body's long axis (m + L0), is the largest stride:
    phi_max = 2 asin(S_max / (2 (m + L0))) = 44.1 degrees for TITAN-VIII. Legs under the
    body have to follow the whole circle: there it is the feet's distance from base_link.

    Parameters
    ----------
    stride : float
        S_max [m].
    foot_distance : float
        m + L0, or the feet's distance from base_link [m].

    Returns
    -------
    float
        phi_max [rad].
    """
    return 2.0 * math.asin(min(1.0, stride / (2.0 * foot_distance)))
