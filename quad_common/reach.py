"""
How far a sprawling leg reaches, and what stride and turn follow from it (S0 sec. 4).
"""

from __future__ import annotations

import math

from quad_common.errors import RobotModelError
from quad_common.leg_kinematics import YawPitchPitchLeg


def largest_stretch(leg: YawPitchPitchLeg, hip_height: float, roughness: float) -> float:
    """
    Largest horizontal distance from the yaw axis to the foot (S0 eq. 16, corrected).

    The paper prints e under the root, which would not even give the initial posture;
    it stands outside: A_max = sqrt((b + d)^2 - (H0 + dh + dv - a)^2) + e.

    Parameters
    ----------
    leg : YawPitchPitchLeg
        Geometry of the leg.
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
    down = hip_height + roughness - leg.hip_drop
    longest = leg.thigh_length + leg.calf_length
    if abs(down) > longest:
        raise RobotModelError(
            f'leg {leg.name} is {longest:.3f} m long and cannot reach {down:.3f} m down; '
            f'lower the body or the roughness'
        )
    return math.sqrt(longest**2 - down**2) + leg.hip_offset


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


def largest_turn(stride: float, foot_half_width: float) -> float:
    """
    Largest turn of one standstill-turning cycle, phi_max.

    The paper states 44 degrees without a derivation. It is the angle whose chord, at
    the feet's distance from the body's long axis (m + L0), is the largest stride:
    phi_max = 2 asin(S_max / (2 (m + L0))) = 44.1 degrees for TITAN-VIII.

    Parameters
    ----------
    stride : float
        S_max [m].
    foot_half_width : float
        m + L0 [m].

    Returns
    -------
    float
        phi_max [rad].
    """
    return 2.0 * math.asin(min(1.0, stride / (2.0 * foot_half_width)))
