"""
How far a leg reaches, and what stride, turn and step follow from it (S0 sec. 4).

A leg that sprawls sideways swings a stride about its yaw axis; one that stands under
the body swings it in its own plane.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import LegTooShort, StretchTooShort
from quad_common.robot.leg_kinematics import Leg

Array = NDArray[np.float64]

_TRIED = 401
"""Number of places that are tried of legs without formulas for their reach."""


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
    Largest distance that a leg with a roll axis carries its foot, forward and backward alike.

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


def lowest_at_stretch(leg: Leg, hip_height: float, stretch: float) -> float:
    """
    How much lower the ground may be for a leg with a yaw axis to stretch so far.

    :func:`largest_stretch`, S0 eq. 16, solved for dh + dv:

        dh + dv = sqrt((b + d)^2 - (A - e)^2) + a - H0

    Parameters
    ----------
    leg : Leg
        Geometry of a leg whose first axis is vertical.
    hip_height : float
        Height of the hip above the foot, H0 [m].
    stretch : float
        Horizontal distance from the yaw axis to the foot, A [m].

    Returns
    -------
    float
        dh + dv [m]; negative if the ground has to be higher.

    Raises
    ------
    RobotModelError
        If the leg does not reach out that far at all.
    """
    down = _across(leg, stretch - float(leg.radial_offset), 'out')
    return down - float(leg.axial_offset) - hip_height


def lowest_at_step(leg: Leg, foot: Array, step: float) -> float:
    """
    How much lower the ground may be for a leg with a roll axis to step so far.

    :func:`largest_step` solved for the roughness.

    Parameters
    ----------
    leg : Leg
        Geometry of a leg whose first axis lies along the body.
    foot : ndarray, shape (3,)
        Where the foot stands, in the body frame [m].
    step : float
        Distance that the foot goes, forward and backward alike [m].

    Returns
    -------
    float
        [m]; negative if the ground has to be higher.

    Raises
    ------
    RobotModelError
        If the leg does not reach out that far at all.
    """
    arm = foot - leg.hip
    down, aside = float(arm @ leg.radial_direction), float(arm @ leg.lateral_direction)
    fore_aft = float(arm @ leg.first_axis) - float(leg.axial_offset)
    length = _across(leg, step + abs(fore_aft), 'out') + float(leg.radial_offset)
    squared = length**2 + float(leg.lateral_offset) ** 2 - aside**2
    return math.sqrt(max(0.0, squared)) - down


def farthest_step(leg: Leg, foot: Array, roughness: float) -> float:
    """
    Largest distance that any leg carries its foot, forward and backward alike, by trying.

    Parameters
    ----------
    leg : Leg
        The leg, of any build.
    foot : ndarray, shape (3,)
        Where the foot stands, in the body frame [m].
    roughness : float
        How much lower the ground may be than expected [m].

    Returns
    -------
    float
        S_max [m], to a four-hundredth of the leg's length.

    Raises
    ------
    RobotModelError
        If the leg does not reach down that far at all.
    """
    longest = float(leg.thigh_length + leg.calf_length)
    distances = np.linspace(0.0, longest, _TRIED)
    ahead = distances[:, None] * np.array([1.0, 0.0, 0.0])
    start = foot - np.array([0.0, 0.0, roughness])
    is_reached = leg.reaches(start + ahead) & leg.reaches(start - ahead)
    if not is_reached[0]:
        raise LegTooShort(str(leg.name), longest, float(leg.hip[2] - start[2]), 'down')
    return float(distances[_unbroken(is_reached)])


def deepest_step(leg: Leg, foot: Array, step: float) -> float:
    """
    How much lower the ground may be for any leg to step so far: :func:`farthest_step` solved.

    Parameters
    ----------
    leg : Leg
        The leg, of any build.
    foot : ndarray, shape (3,)
        Where the foot stands, in the body frame [m].
    step : float
        Distance that the foot goes, forward and backward alike [m].

    Returns
    -------
    float
        [m]; 0 if it does not get that far on level ground.
    """
    depths = np.linspace(0.0, float(leg.thigh_length + leg.calf_length), _TRIED)
    down = depths[:, None] * np.array([0.0, 0.0, -1.0])
    ahead = np.array([step, 0.0, 0.0])
    is_reached = leg.reaches(foot + ahead + down) & leg.reaches(foot - ahead + down)
    return float(depths[_unbroken(is_reached)]) if is_reached[0] else 0.0


def _unbroken(is_reached: NDArray[np.bool_]) -> int:
    """Return the index of the last place that is reached as all before it are."""
    return len(is_reached) - 1 if is_reached.all() else int(np.argmin(is_reached)) - 1


STEP_FRACTION = 1.0 / 3.0
"""Fraction of the largest stride that a leg must still reach down a step, and of the hip height."""


def largest_step_height(lower: float, hip_height: float) -> float:
    """
    Highest step that a robot climbs, up or down.

    Down a step a leg must reach ground that is lower than expected, with a third of the
    largest stride left. Up it the legs fold and the body tilts: a third of the hip height is as
    much as was measured. In physics TITAN-VIII climbs kerbs of up to 80 mm upright, a third of its
    243 mm, and tilts by 14 degrees at 100 mm.

    Parameters
    ----------
    lower : float
        How much lower the ground may be for a third of the largest stride
        (:func:`lowest_at_stretch`, :func:`lowest_at_step`) [m].
    hip_height : float
        H0 [m].

    Returns
    -------
    float
        The lesser of both, at least 0 [m].
    """
    return max(0.0, min(lower, STEP_FRACTION * hip_height))


def _across(leg: Leg, distance: float, direction: str = 'down') -> float:
    """Return how far the straight leg gets at a distance from its pitch axis, across that [m]."""
    longest = float(leg.thigh_length + leg.calf_length)
    if abs(distance) > longest:
        raise LegTooShort(str(leg.name), longest, distance, direction)
    return math.sqrt(longest**2 - distance**2)


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
        raise StretchTooShort(stretch, stance_reach)
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
