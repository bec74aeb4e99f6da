"""
Closed-form kinematics of legs with one turning and two pitching joints.

The leg hangs at a hip point on the body. Its first axis, zeta, is fixed in the body:
vertical for a yaw-pitch-pitch leg (S0 eqs. 11 to 15, corrected), and fore-aft for a
roll-pitch-pitch leg (S2 eqs. 8 to 15, corrected). Behind it thigh and calf stay in one
plane, which turns with q1 about zeta::

    rho = cos q1 rho0 + sin q1 nu0      radial: away from zeta, in the plane
    nu  = zeta x rho                    normal to the plane, along both pitch axes

The pitch axis is off the hip point by an axial offset along zeta, a radial one along
rho and a lateral one along nu. A link at the angle q has the direction
``cos q rho - sin q zeta``; q is q2 for the thigh and q2 + q3 for the calf.

For a yaw-pitch-pitch leg rho0 is outward and zeta up: yaw q1 is counter-clockwise from
straight outward, pitch q2 from the horizontal, positive downward, and knee q3 from the
thigh's direction, positive downward. For a roll-pitch-pitch leg rho0 is down, zeta
forward and nu0 left: all three angles are right-handed about the body's x and y axes,
from the leg that hangs straight down.

Several legs may be stacked into one :class:`Leg`, which places them all at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_arrays import (
    EDGE,
    LegArrays,
    arrays_of,
    is_in_reach,
    part_frames,
)

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Leg:
    """
    Geometry of one leg, or of several stacked, and its kinematics in the body frame.

    For n stacked legs every field has a leading axis of length n, and so have joint
    angles and feet before their last: shapes (3,) below become (n, 3), and (..., 3)
    become (..., n, 3). :func:`stack_legs` makes such a leg.
    """

    name: str | tuple[str, ...]
    """Name of the leg: lf, rf, lh or rh."""
    hip: Array
    """Hip point in the body frame, shape (3,) [m]."""
    first_axis: Array
    """Axis of the first joint, zeta, in the body frame, a unit vector, shape (3,)."""
    radial_direction: Array
    """rho at q1 = 0, in the body frame, a unit vector normal to zeta, shape (3,)."""
    axial_offset: float | Array
    """Offset from the hip point to the pitch axis along zeta [m]."""
    radial_offset: float | Array
    """Offset from the hip point to the pitch axis along rho [m]."""
    lateral_offset: float | Array
    """Offset from the hip point to the leg's plane along nu [m]."""
    thigh_length: float | Array
    """Length from the pitch axis to the knee [m]."""
    calf_length: float | Array
    """Length from the knee to the center of the foot [m]."""
    knee_sign: float | Array = 1.0
    """Sign, +1 or -1, of q3 among inverse kinematics' two solutions, before ``signs``."""
    signs: Array | tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Signs, +1 or -1: joint angle = sign * (angle in the formulas - zero), shape (3,)."""
    zeros: Array | tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Angles in the formulas at which the joint angles are 0, shape (3,) [rad]."""
    middles: Array | tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Middles of the joints' ranges; inverse kinematics of a leg with zeros or middles gives
    joint angles within half a turn of them, shape (3,) [rad]."""

    @cached_property
    def lateral_direction(self) -> Array:
        """The leg's nu at q1 = 0, in the body frame: zeta x rho0, shape (3,)."""
        return np.asarray(np.cross(self.first_axis, self.radial_direction), dtype=np.float64)

    def reach(self) -> tuple[float | Array, float | Array]:
        """Least and largest distance between pitch axis and foot [m]."""
        return (
            np.abs(self.thigh_length - self.calf_length),
            self.thigh_length + self.calf_length,
        )

    def chain(self, joint_angles: Array) -> tuple[Array, Array, Array]:
        """
        Place the pitch axis, the knee and the foot.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            First joint, pitch and knee [rad].

        Returns
        -------
        tuple of ndarray, each of shape (..., 3)
            Pitch axis, knee and foot in the body frame [m] (S0 eq. 11).
        """
        k = self._arrays
        q1, q2, q3 = k.angles(joint_angles)
        c1, s1 = np.cos(q1), np.sin(q1)
        theta3 = q2 + q3
        length, height = k.radial, k.axial
        points = [k.points(joint_angles.shape, c1, s1, length, height)]
        for link, angle in ((k.thigh, q2), (k.calf, theta3)):
            length = length + link * np.cos(angle)
            height = height - link * np.sin(angle)
            points.append(k.points(joint_angles.shape, c1, s1, length, height))
        return points[0], points[1], points[2]

    def part_frames(
        self, joint_angles: Array, chain: tuple[Array, Array, Array]
    ) -> list[tuple[Array, tuple[Array, ...]]]:
        """
        Place the frames of hip, thigh and calf, in which their masses are given.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            [rad]
        chain : tuple of ndarray
            As :meth:`chain` gives it for these angles [m].

        Returns
        -------
        list of tuple
            Where each begins, (..., 3) [m], and its three axes in the body frame, (..., 3) each.
        """
        return part_frames(self, joint_angles, chain)

    def bends(self, joint_angles: Array) -> Array:
        """Return how far knees are bent, 0 if straight, (...) of joint angles (..., 3) [rad]."""
        zeros, signs = np.asarray(self.zeros)[..., 2], np.asarray(self.signs)[..., 2]
        bends: Array = np.abs(zeros + signs * joint_angles[..., 2])
        return bends

    def forward(self, joint_angles: Array) -> Array:
        """
        Place the foot.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            First joint, pitch and knee [rad].

        Returns
        -------
        ndarray, shape (..., 3)
            Foot in the body frame [m].
        """
        k = self._arrays
        q1, q2, q3 = k.angles(joint_angles)
        theta3 = q2 + q3
        length = k.radial + k.thigh * np.cos(q2) + k.calf * np.cos(theta3)
        height = k.axial - k.thigh * np.sin(q2) - k.calf * np.sin(theta3)
        return k.points(joint_angles.shape, np.cos(q1), np.sin(q1), length, height)

    def inverse(self, foot: Array) -> Array:
        """
        Find the joint angles that put the foot where it is wanted.

        With x, y, z the foot from the hip point along rho0, nu0 and zeta, the foot is
        B = sqrt(x^2 + y^2 - lateral^2) along rho and A = z - axial along zeta, which
        is a problem of two links: the law of cosines gives the knee, and arc tangents
        give the rest. S0's (15) mixes two conventions and lacks a division by 2bd.

        Parameters
        ----------
        foot : ndarray, shape (..., 3)
            Foot in the body frame [m].

        Returns
        -------
        ndarray, shape (..., 3)
            First joint and pitch in [-pi, pi), and knee in [0, pi] on the side that
            ``knee_sign`` says, in the formulas' angles where ``zeros`` are 0 [rad].

        Raises
        ------
        FootTargetUnreachable
            If a foot is nearer to, or farther from, its pitch axis than thigh and calf
            allow; or nearer to its first axis than the leg's plane is; or not finite.
        """
        k = self._arrays
        d, b = k.thigh, k.calf
        # What is not finite is found below, by what does not compare.
        with np.errstate(invalid='ignore', over='ignore'):
            x, y, z = k.locals(foot, k.hips_local)
            squared_length = x * x + y * y
            if k.has_lateral:
                squared_length -= k.lateral * k.lateral
                B = np.sqrt(np.maximum(squared_length, 0.0))
            else:
                B = np.sqrt(squared_length)
            out, down = B - k.radial, k.axial - z
            squared = out * out + down * down
            cos_knee = (squared - (d * d + b * b)) / (2.0 * b * d)
        if k.has_lateral and np.any(squared_length < -EDGE * k.lateral * k.lateral):
            raise k.too_near(squared_length)
        if not (np.abs(cos_knee) <= 1.0 + EDGE).all():
            raise k.unreachable(foot, cos_knee, squared)
        np.clip(cos_knee, -1.0, 1.0, out=cos_knee)
        sin_knee = k.knee_sign * np.sqrt((1.0 - cos_knee) * (1.0 + cos_knee))
        along, across = d + b * cos_knee, b * sin_knee
        angles = np.empty((3, *x.shape))
        # One arc tangent for each difference of two directions.
        if k.has_lateral:
            np.arctan2(y * B - k.lateral * x, x * B + k.lateral * y, out=angles[0])
        else:
            np.arctan2(y, x, out=angles[0])
        np.arctan2(down * along - out * across, out * along + down * across, out=angles[1])
        np.multiply(k.knee_sign, np.arccos(cos_knee), out=angles[2])
        k.to_joints(angles)
        result = np.empty((x.shape[1], k.legs, 3))
        result[...] = angles.transpose(2, 1, 0)
        return result.reshape(foot.shape)

    def reaches(self, feet: Array) -> NDArray[np.bool_]:
        """Return which feet (..., 3) in the body frame [m] :meth:`inverse` of one leg solves."""
        return is_in_reach(self, feet)

    def jacobian(self, joint_angles: Array) -> Array:
        """
        Differentiate the foot's position by the joint angles.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            First joint, pitch and knee [rad].

        Returns
        -------
        ndarray, shape (..., 3, 3)
            J with foot velocity = J @ joint velocity, in the body frame [m/rad].
        """
        k = self._arrays
        q1, q2, q3 = k.angles(joint_angles)
        c1, s1 = np.cos(q1), np.sin(q1)
        theta3 = q2 + q3
        length_by_q3, height_by_q3 = -k.calf * np.sin(theta3), -k.calf * np.cos(theta3)
        length_by_q2 = length_by_q3 - k.thigh * np.sin(q2)
        height_by_q2 = height_by_q3 - k.thigh * np.cos(q2)
        B = k.radial + k.thigh * np.cos(q2) + k.calf * np.cos(theta3)
        # One row per joint: what it moves the foot along rho0, nu0 and zeta.
        columns = np.zeros((3, 3, *q1.shape))
        columns[0, 0] = -s1 * B - c1 * k.lateral
        columns[0, 1] = c1 * B - s1 * k.lateral
        for joint, length, height in (
            (1, length_by_q2, height_by_q2),
            (2, length_by_q3, height_by_q3),
        ):
            columns[joint, 0] = c1 * length
            columns[joint, 1] = s1 * length
            columns[joint, 2] = height
        columns *= k.signs[:, None]
        rows = columns.reshape(3, 3 * k.legs, -1).transpose(0, 2, 1) @ k.to_body
        matrices = rows.reshape(3, -1, k.legs, 3).transpose(1, 2, 3, 0)
        return np.ascontiguousarray(matrices).reshape(*joint_angles.shape, 3)

    def joint_velocities(self, joint_angles: Array, foot_velocity: Array) -> Array:
        """
        Find the joint speeds that give the foot its velocity.

        This is the inverse of :meth:`jacobian`, in closed form: q1' = v_nu / B, then
        B' = v_rho + lateral q1' and A' = v_zeta, which the two links solve.

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            First joint, pitch and knee [rad].
        foot_velocity : ndarray, shape (..., 3)
            In the body frame [m/s].

        Returns
        -------
        ndarray, shape (..., 3)
            [rad/s].

        Raises
        ------
        SingularPosture
            If a knee is straight or folded, or a foot in the plane of its first axis.
        """
        k = self._arrays
        q1, q2, q3 = k.angles(joint_angles)
        x, y, A_dot = k.locals(foot_velocity)
        c1, s1, c2, s2 = np.cos(q1), np.sin(q1), np.cos(q2), np.sin(q2)
        q2 += q3
        c3, s3 = np.cos(q2), np.sin(q2)
        sin_knee = s3 * c2 - c3 * s2
        B = k.radial + k.thigh * c2 + k.calf * c3
        k.check_regular(sin_knee, B)
        speeds = np.empty((3, *q1.shape))
        np.divide(c1 * y - s1 * x, B, out=speeds[0])
        B_dot = c1 * x + s1 * y
        if k.has_lateral:
            B_dot += k.lateral * speeds[0]
        np.divide(B_dot * c3 - A_dot * s3, k.thigh * sin_knee, out=speeds[1])
        np.divide(A_dot * s2 - B_dot * c2, k.calf * sin_knee, out=speeds[2])
        speeds[2] -= speeds[1]
        speeds *= k.signs
        result = np.empty((q1.shape[1], k.legs, 3))
        result[...] = speeds.transpose(2, 1, 0)
        return result.reshape(joint_angles.shape)

    def angular_velocity(self, joint_angles: Array, joint_velocities: Array) -> Array:
        """
        Find how fast the calf turns relative to the body: zeta q1' + nu (q2' + q3').

        Parameters
        ----------
        joint_angles : ndarray, shape (..., 3)
            First joint, pitch and knee [rad].
        joint_velocities : ndarray, shape (..., 3)
            [rad/s].

        Returns
        -------
        ndarray, shape (..., 3)
            Angular velocity in the body's axes [rad/s].
        """
        k = self._arrays
        q1 = k.angles(joint_angles)[0]
        turn, *pitches = k.rates(joint_velocities)
        pitch = pitches[0] + pitches[1]
        turning = np.stack([-np.sin(q1) * pitch, np.cos(q1) * pitch, turn])
        return k.in_body(turning, joint_angles.shape)

    @cached_property
    def _arrays(self) -> LegArrays:
        return arrays_of(self)


def stack_legs(legs: Sequence[Leg]) -> Leg:
    """
    Stack single legs into one that places them all at once.

    Parameters
    ----------
    legs : sequence of Leg
        Single legs, in the order of the arrays' leg axis.

    Returns
    -------
    Leg
        With a leading axis in every field.
    """
    own = [field.name for field in fields(legs[0]) if field.name != 'name']
    values = {name: np.array([getattr(leg, name) for leg in legs]) for name in own}
    return type(legs[0])(name=tuple(str(leg.name) for leg in legs), **values)
