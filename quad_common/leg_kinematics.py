"""
Closed-form kinematics of a yaw-pitch-pitch leg (S0 eqs. 11 to 15, corrected).

The leg hangs at a hip point on the body. Its first axis is vertical; behind it the
leg stays in one vertical plane: ``hip_offset`` outward and ``hip_drop`` down to the
pitch axis, then the thigh, then the calf. The paper's letters are e, a, d and b.

Joint angles are those of the serial chain, as in the URDF: yaw q1 counter-clockwise
from straight outward, pitch q2 from the horizontal, positive downward, and knee q3
from the thigh's direction, positive downward. Paper S0's drives turn with
theta1 = q1, theta2 = q2 and the **absolute** theta3 = q2 + q3:
:func:`drive_angles` is the only place that knows it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import FootTargetUnreachable

Array = NDArray[np.float64]


def drive_angles(joint_angles: Array, knee_is_absolute: bool) -> Array:
    """
    Convert joint angles of the serial chain to what the drives turn.

    Parameters
    ----------
    joint_angles : ndarray, shape (..., 3)
        Yaw, pitch and knee of the serial chain [rad].
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


@dataclass(frozen=True)
class YawPitchPitchLeg:
    """Geometry of one leg, and its kinematics in the body frame."""

    name: str
    """Which leg: lf, rf, lh or rh."""
    hip: tuple[float, float, float]
    """Hip point in the body frame [m]."""
    outward: float
    """Direction in which the leg points at q1 = 0, from the body's x axis [rad]."""
    hip_offset: float
    """Outward from the yaw axis to the pitch axis [m]; S0's e."""
    hip_drop: float
    """Downward from the hip point to the pitch axis [m]; S0's a."""
    thigh_length: float
    """[m]; S0's d."""
    calf_length: float
    """[m]; S0's b."""

    def reach(self) -> tuple[float, float]:
        """Least and largest distance between pitch axis and foot [m]."""
        return (
            abs(self.thigh_length - self.calf_length),
            self.thigh_length + self.calf_length,
        )

    def chain(self, joint_angles: Array) -> tuple[Array, Array, Array]:
        """
        Place the pitch axis, the knee and the foot.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            Yaw, pitch and knee [rad].

        Returns
        -------
        tuple of ndarray, each of shape (..., 3)
            Pitch axis, knee and foot in the body frame [m] (S0 eq. 11).
        """
        q1, q2, q3 = (joint_angles[..., k] for k in range(3))
        e, a, d, b = self.hip_offset, self.hip_drop, self.thigh_length, self.calf_length
        direction = self.outward + q1
        radial = np.stack([np.cos(direction), np.sin(direction), np.zeros_like(q1)], axis=-1)
        down = np.array([0.0, 0.0, -1.0])
        theta3 = q2 + q3
        pitch_axis = np.asarray(self.hip) + e * radial + a * down
        knee = (
            pitch_axis + (d * np.cos(q2))[..., None] * radial + (d * np.sin(q2))[..., None] * down
        )
        foot = (
            knee + (b * np.cos(theta3))[..., None] * radial + (b * np.sin(theta3))[..., None] * down
        )
        return pitch_axis, knee, foot

    def forward(self, joint_angles: Array) -> Array:
        """
        Place the foot.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            Yaw, pitch and knee [rad].

        Returns
        -------
        ndarray, shape (..., 3)
            Foot in the body frame [m].
        """
        return self.chain(joint_angles)[2]

    def inverse(self, foot: Array) -> Array:
        """
        Find the joint angles that put the foot where it is wanted, knee up.

        The paper's (15) mixes two conventions and lacks a division by 2bd; this is
        the law of cosines for the knee and two arc tangents for the rest.

        Parameters
        ----------
        foot : ndarray, shape (..., 3)
            Foot in the body frame [m].

        Returns
        -------
        ndarray, shape (..., 3)
            Yaw and pitch in [-pi, pi), and knee in [0, pi] [rad].

        Raises
        ------
        FootTargetUnreachable
            If a foot is nearer to, or farther from, its pitch axis than thigh and calf
            allow; or is not finite.
        """
        e, a, d, b = self.hip_offset, self.hip_drop, self.thigh_length, self.calf_length
        arm = foot - np.asarray(self.hip)
        out = np.hypot(arm[..., 0], arm[..., 1]) - e
        down = -arm[..., 2] - a
        squared = out * out + down * down
        cos_knee = (squared - d * d - b * b) / (2.0 * b * d)
        # Rounding at the very edge of the reach is not an error of the caller's.
        bad = ~(np.abs(cos_knee) <= 1.0 + 1e-12)
        if np.any(bad):
            distance = float(np.sqrt(np.ravel(squared)[np.argmax(np.ravel(bad))]))
            raise FootTargetUnreachable(self.name, distance, self.reach())
        q3 = np.arccos(np.clip(cos_knee, -1.0, 1.0))
        q2 = np.arctan2(down, out) - np.arctan2(b * np.sin(q3), d + b * np.cos(q3))
        q1 = np.arctan2(arm[..., 1], arm[..., 0]) - self.outward
        # The difference of two directions may be a whole turn too far.
        q1, q2 = ((q + np.pi) % (2.0 * np.pi) - np.pi for q in (q1, q2))
        return np.stack([q1, q2, q3], axis=-1)

    def jacobian(self, joint_angles: Array) -> Array:
        """
        Differentiate the foot's position by the joint angles.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            Yaw, pitch and knee [rad].

        Returns
        -------
        ndarray, shape (..., 3, 3)
            J with foot velocity = J @ joint velocity, in the body frame [m/rad].
        """
        q1, q2, q3 = (joint_angles[..., k] for k in range(3))
        e, d, b = self.hip_offset, self.thigh_length, self.calf_length
        theta3 = q2 + q3
        c1, s1 = np.cos(self.outward + q1), np.sin(self.outward + q1)
        length = e + d * np.cos(q2) + b * np.cos(theta3)
        out_by_q3, up_by_q3 = -b * np.sin(theta3), -b * np.cos(theta3)
        out_by_q2, up_by_q2 = out_by_q3 - d * np.sin(q2), up_by_q3 - d * np.cos(q2)
        zero = np.zeros_like(q1)
        return np.stack(
            [
                np.stack([-length * s1, out_by_q2 * c1, out_by_q3 * c1], axis=-1),
                np.stack([length * c1, out_by_q2 * s1, out_by_q3 * s1], axis=-1),
                np.stack([zero, up_by_q2, up_by_q3], axis=-1),
            ],
            axis=-2,
        )
