"""
The two builds of legs, those that sprawl sideways and those that stand under the body.

Their drives turn the joints of the serial chain, but for S0's pantograph: its knee drive
works from the horizontal, so that theta3 is the **absolute** angle q2 + q3.
:func:`drive_angles` and its inverse are the only place that knows it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.robot.leg_kinematics import Leg

Array = NDArray[np.float64]
Signs = tuple[float, float, float]

_AS_IN_FORMULAS: Signs = (1.0, 1.0, 1.0)


@dataclass(frozen=True, eq=False)
class LegPlace:
    """Place of a leg on the body."""

    name: str
    """Name of the leg, for example ``lf``."""
    hip: ArrayLike
    """Hip point in the body frame, shape (3,) [m]."""
    side: int
    """Side of the body: +1 for a left leg, -1 for a right one."""


@dataclass(frozen=True)
class LegLengths:
    """Lengths of a leg."""

    hip_offset: float
    """Offset outward from the hip point to the pitch axis [m]; S0's e."""
    hip_drop: float
    """Offset downward from the hip point to the pitch axis [m]; S0's a and S2's l1."""
    thigh: float
    """Length from the pitch axis to the knee [m]; S0's d and S2's l2."""
    calf: float
    """Length from the knee to the center of the foot [m]; S0's b and S2's l3."""


def yaw_pitch_pitch_leg(
    place: LegPlace,
    lengths: LegLengths,
    lateral_offset: float = 0.0,
    signs: Signs = _AS_IN_FORMULAS,
) -> Leg:
    """
    Make a leg that sprawls sideways: yaw, then two pitches in a vertical plane.

    Parameters
    ----------
    place : LegPlace
        Where the leg is; its side is where it points at yaw 0.
    lengths : LegLengths
        Lengths of the leg.
    lateral_offset : float
        From the hip point forward to the leg's plane, at yaw 0 [m].
    signs : tuple of float
        See :class:`Leg`.

    Returns
    -------
    Leg
        Its inverse kinematics keeps the knee up.
    """
    return Leg(
        name=place.name,
        hip=np.asarray(place.hip, dtype=float),
        first_axis=np.array([0.0, 0.0, 1.0]),
        radial_direction=np.array([0.0, float(place.side), 0.0]),
        axial_offset=-lengths.hip_drop,
        radial_offset=lengths.hip_offset,
        # nu at yaw 0 is backward on the left and forward on the right.
        lateral_offset=-place.side * lateral_offset,
        thigh_length=lengths.thigh,
        calf_length=lengths.calf,
        signs=signs,
    )


def roll_pitch_pitch_leg(
    place: LegPlace,
    lengths: LegLengths,
    knee_sign: float = 1.0,
    forward_offset: float = 0.0,
    signs: Signs = _AS_IN_FORMULAS,
) -> Leg:
    """
    Make a leg that stands under the body: roll, then two pitches in a fore-aft plane.

    Parameters
    ----------
    place : LegPlace
        Where the leg is.
    lengths : LegLengths
        Lengths of the leg; its offsets are those at roll 0.
    knee_sign : float
        +1 for a knee that points forward, -1 for one that points backward.
    forward_offset : float
        Forward from the hip point to the pitch axis [m].
    signs : tuple of float
        See :class:`Leg`.

    Returns
    -------
    Leg
        It hangs straight down at 0, and pitch carries it backward.
    """
    return Leg(
        name=place.name,
        hip=np.asarray(place.hip, dtype=float),
        first_axis=np.array([1.0, 0.0, 0.0]),
        radial_direction=np.array([0.0, 0.0, -1.0]),
        axial_offset=forward_offset,
        radial_offset=lengths.hip_drop,
        lateral_offset=place.side * lengths.hip_offset,
        thigh_length=lengths.thigh,
        calf_length=lengths.calf,
        knee_sign=knee_sign,
        signs=signs,
    )


def drive_angles(joint_angles: Array, knee_is_absolute: bool) -> Array:
    """
    Convert joint angles of the serial chain to what the drives turn.

    Parameters
    ----------
    joint_angles : ndarray, shape (..., 3)
        First joint, pitch and knee of the serial chain [rad].
    knee_is_absolute : bool
        Whether the knee drive works from the horizontal (a pantograph, S0 fig. 12).

    Returns
    -------
    ndarray, shape (..., 3)
        The paper's theta1, theta2, theta3 [rad].
    """
    angles = np.array(joint_angles, dtype=float)
    if knee_is_absolute:
        angles[..., 2] += angles[..., 1]
    return angles


def joint_angles_from_drives(drives: Array, knee_is_absolute: bool) -> Array:
    """Undo :func:`drive_angles`: shape (..., 3), [rad]."""
    angles = np.array(drives, dtype=float)
    if knee_is_absolute:
        angles[..., 2] -= angles[..., 1]
    return angles
