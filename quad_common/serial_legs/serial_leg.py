"""
Kinematics of legs of three turning joints whose axes lie in any manner.

Where :class:`~quad_common.robot.leg_kinematics.Leg` has closed formulas, which want parallel axes
of pitch and knee at right angles to the first, this one takes what it is given: joints turn about
axes through points, both in the body frame with all joint angles at 0 (a product of
exponentials). Its inverse is found by iteration, in the aspect of a nominal posture.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import FootOutsideWorkspace, SingularPosture
from quad_common.robot.leg_kinematics import Leg
from quad_common.serial_legs.aspect import FOUND, Aspect, Window, aspect_around
from quad_common.serial_legs.compiled_leg import CompiledLeg

Array = NDArray[np.float64]

_BEYOND = 0.3
"""Angle beyond the joints' limits up to which postures are looked for, so that a joint that would
have to pass its limit is named [rad]."""

_SINGULAR = 1e-7
"""Determinant of the Jacobian, of a leg of length 1, that counts as zero."""


_UPRIGHT = 0.9
"""Cosine between an axis and the vertical above which it counts as upright."""


@dataclass(frozen=True, eq=False)
class AxesAtZero:
    """Axes and foot of a leg in the body frame, with all joints at 0."""

    axes: Array
    """Unit vectors along the axes, shape (3, 3)."""
    points: Array
    """Points on the axes; the first is the hip, shape (3, 3) [m]."""
    foot: Array
    """Center of the foot, shape (3,) [m]."""


def _no_vector() -> Array:
    return np.zeros(3)


def _no_matrix() -> Array:
    return np.zeros((3, 3))


@dataclass(frozen=True, eq=False)
class SerialLeg(Leg):
    """
    A leg of any three axes, or several stacked, with the interface of a leg in closed form.

    Of the fields of :class:`Leg`, hip, name, lengths and ``middles`` mean what they do there;
    offsets, signs and zeros are not used. :func:`serial_leg` makes one.
    """

    axes: Array = field(default_factory=_no_matrix)
    """Axes of the joints at 0 in the body frame, unit vectors, shape (3, 3)."""
    points: Array = field(default_factory=_no_matrix)
    """Points on these axes in the body frame; the first is the hip, shape (3, 3) [m]."""
    foot: Array = field(default_factory=_no_vector)
    """Center of the foot at 0 in the body frame, shape (3,) [m]."""
    lower: Array = field(default_factory=_no_vector)
    """Lower limits of the joints, shape (3,) [rad]."""
    upper: Array = field(default_factory=_no_vector)
    """Upper limits of the joints, shape (3,) [rad]."""
    nominal: Array = field(default_factory=_no_vector)
    """Posture in whose aspect the leg stays, shape (3,) [rad]."""

    def window(self) -> tuple[Array, Array]:
        """
        Return the ranges of a single leg in which it has one posture for each place.

        Returns
        -------
        tuple of ndarray, shapes (3,) and (3,)
            Lower and upper angles, within the joints' limits [rad].
        """
        window = self._aspect.window
        return np.maximum(window.lower, self.lower), np.minimum(window.upper, self.upper)

    def reach(self) -> tuple[float | Array, float | Array]:
        """Least and largest distance between hip and foot in the leg's aspect [m]."""
        ends = []
        for leg in self._single:
            distances = np.linalg.norm(leg._aspect.tree.data, axis=-1)
            ends.append((float(distances.min()), float(distances.max())))
        least, largest = np.array(ends).T
        return (least, largest) if self._is_stacked else (float(least[0]), float(largest[0]))

    def chain(self, joint_angles: Array) -> tuple[Array, Array, Array]:
        """Place the second joint, the third and the foot: (..., 3) of angles (..., 3) [m]."""
        _, places = self._placed(joint_angles)
        return places[1], places[2], places[3]

    def part_frames(
        self, joint_angles: Array, chain: tuple[Array, Array, Array]
    ) -> list[tuple[Array, tuple[Array, ...]]]:
        """Place the links' frames, whose axes are the body's at 0; see :class:`Leg`."""
        rotations, _ = self._placed(joint_angles)
        starts = (np.broadcast_to(self.hip, chain[0].shape), *chain[:2])
        return [
            (start, tuple(turned[..., :, k] for k in range(3)))
            for start, turned in zip(starts, rotations[1:])
        ]

    def bends(self, joint_angles: Array) -> Array:
        """Return the angles between thighs and calves, (...) of joint angles (..., 3) [rad]."""
        second, third, foot = self.chain(joint_angles)
        thigh, calf = third - second, foot - third
        across = np.linalg.norm(np.cross(thigh, calf), axis=-1)
        return np.asarray(np.arctan2(across, np.sum(thigh * calf, axis=-1)), dtype=np.float64)

    def forward(self, joint_angles: Array) -> Array:
        """Place the foot: (..., 3) in the body frame [m] of joint angles (..., 3) [rad]."""
        return self._placed(joint_angles)[1][3]

    def inverse(self, foot: Array) -> Array:
        """
        Find the joint angles that put the foot where it is wanted, in the aspect of ``nominal``.

        Parameters
        ----------
        foot : ndarray, shape (..., 3)
            Foot in the body frame [m].

        Returns
        -------
        ndarray, shape (..., 3)
            Joint angles; they may be beyond the joints' limits [rad].

        Raises
        ------
        FootOutsideWorkspace
            If the leg does not take its foot there, or the place is no number.
        """
        feet = np.reshape(np.asarray(foot, dtype=float), (-1, len(self._single), 3))
        angles = np.empty_like(feet)
        for k, leg in enumerate(self._single):
            angles[:, k], left = leg._solved(feet[:, k])
            if not (left <= leg._found).all():
                worst = int(np.argmax(np.where(np.isfinite(left), left, np.inf)))
                distance = float(np.linalg.norm(feet[worst, k] - leg.hip))
                least, largest = leg.reach()
                reach = (float(least), float(largest))
                raise FootOutsideWorkspace(
                    str(leg.name), distance, reach, 'hip', float(left[worst])
                )
        return angles.reshape(np.shape(foot))

    def reaches(self, feet: Array) -> NDArray[np.bool_]:
        """Return which feet (..., 3) in the body frame [m] :meth:`inverse` of one leg solves."""
        _, left = self._solved(np.reshape(feet, (-1, 3)))
        found: NDArray[np.bool_] = left <= self._found
        return found.reshape(np.shape(feet)[:-1])

    def jacobian(self, joint_angles: Array) -> Array:
        """Differentiate the foot's position by the angles: (..., 3, 3) of (..., 3) [m/rad]."""
        rotations, places = self._placed(joint_angles)
        columns = [
            np.cross((turned @ self.axes[..., k, :, None])[..., 0], places[3] - places[k])
            for k, turned in enumerate(rotations[:3])
        ]
        return np.stack(columns, axis=-1)

    def joint_velocities(self, joint_angles: Array, foot_velocity: Array) -> Array:
        """
        Find the joint speeds that give the foot its velocity; see :class:`Leg`.

        Raises
        ------
        SingularPosture
            If the joints cannot move the foot in every direction.
        """
        matrices = self.jacobian(joint_angles)
        singular = np.asarray(np.abs(np.linalg.det(matrices)) <= _SINGULAR * self._length**3)
        if singular.any():
            leg = int(np.argmax(singular.reshape(-1, len(self._single)).any(axis=0)))
            raise SingularPosture(str(self._single[leg].name), 'its joints work in one plane')
        speeds = np.linalg.solve(matrices, foot_velocity[..., None])[..., 0]
        return np.asarray(speeds, dtype=np.float64)

    def angular_velocity(self, joint_angles: Array, joint_velocities: Array) -> Array:
        """Find how fast the calf turns relative to the body, (..., 3) [rad/s]."""
        rotations, _ = self._placed(joint_angles)
        total: Array = np.zeros(())
        for k, turned in enumerate(rotations[:3]):
            axis = (turned @ self.axes[..., k, :, None])[..., 0]
            total = total + axis * joint_velocities[..., k, None]
        return total

    @property
    def _is_stacked(self) -> bool:
        return not isinstance(self.name, str)

    @cached_property
    def _single(self) -> tuple[SerialLeg, ...]:
        """The legs one by one, each with its aspect."""
        if not self._is_stacked:
            return (self,)
        return tuple(
            serial_leg(
                str(name),
                AxesAtZero(self.axes[k], self.points[k], self.foot[k]),
                self.lower[k],
                self.upper[k],
                self.nominal[k],
            )
            for k, name in enumerate(self.name)
        )

    @cached_property
    def _length(self) -> float:
        """Length of the longest leg [m]."""
        return float(np.max(np.asarray(self.thigh_length) + np.asarray(self.calf_length)))

    @property
    def _found(self) -> float:
        return FOUND * self._length

    @cached_property
    def _arms(self) -> Array:
        """From each joint to the next and to the foot at 0, shape (3, 3), stacked (n, 3, 3) [m]."""
        ends = np.concatenate([self.points[..., 1:, :], self.foot[..., None, :]], axis=-2)
        arms: Array = ends - self.points
        return arms

    def _placed(self, joint_angles: Array) -> tuple[list[Array], list[Array]]:
        """Return rotations of body and links, (..., 3, 3), and hip, joints and foot, (..., 3)."""
        shape = np.shape(joint_angles)
        rotations = [np.broadcast_to(np.eye(3), (*shape, 3))]
        places = [np.broadcast_to(self.hip, shape)]
        for k in range(3):
            angle = np.asarray(joint_angles)[..., k, None, None]
            K, KK = self._skew[..., k, :, :], self._squared_skew[..., k, :, :]
            turn = np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * KK
            rotations.append(rotations[-1] @ turn)
            places.append(places[-1] + (rotations[-1] @ self._arms[..., k, :, None])[..., 0])
        return rotations, places

    @cached_property
    def _skew(self) -> Array:
        """Matrices of the cross products with the axes, shape (3, 3, 3), stacked (n, 3, 3, 3)."""
        crossed = np.cross(self.axes[..., None, :], np.eye(3))
        return np.asarray(crossed.swapaxes(-1, -2), dtype=np.float64)

    @cached_property
    def _squared_skew(self) -> Array:
        squared: Array = self._skew @ self._skew
        return squared

    @cached_property
    def _aspect(self) -> Aspect:
        """The postures that a single leg may take."""
        own = float(np.linalg.det(self.jacobian(self.nominal)))
        if abs(own) <= _SINGULAR * self._length**3:
            raise SingularPosture(str(self.name), 'its joints work in one plane')
        ranges = Window(self.lower - _BEYOND, self.upper + _BEYOND, self.nominal)
        return aspect_around(CompiledLeg(self.axes, self._arms), ranges, self._length)

    def _solved(self, feet: Array) -> tuple[Array, Array]:
        """Return angles of a single leg (n, 3) [rad], and how far its feet are from (n, 3) [m]."""
        is_finite = np.asarray(np.isfinite(feet).all(axis=-1))
        safe = np.where(is_finite[:, None], feet, self.hip)
        angles, left = self._aspect.solve(safe - self.hip, self._length)
        return angles, np.where(is_finite, left, np.inf)


def serial_leg(
    name: str, at_zero: AxesAtZero, lower: Array, upper: Array, nominal: Array
) -> SerialLeg:
    """
    Make a leg of any three axes.

    Parameters
    ----------
    name : str
        Name of the leg, one of ``LEGS``.
    at_zero : AxesAtZero
        Axes and foot with all joints at 0.
    lower, upper, nominal : ndarray, shape (3,)
        Limits of the joints, and a regular posture between them [rad].
    """
    axes, points = np.ascontiguousarray(at_zero.axes), np.ascontiguousarray(at_zero.points)
    # At right angles to the first axis, and as near to downward as that goes.
    other = np.eye(3)[2 if abs(float(axes[0, 2])) < _UPRIGHT else 0]
    radial = other - axes[0] * float(axes[0] @ other)
    return SerialLeg(
        name=name,
        hip=points[0],
        first_axis=axes[0],
        radial_direction=-radial / np.linalg.norm(radial),
        axial_offset=0.0,
        radial_offset=0.0,
        lateral_offset=0.0,
        thigh_length=float(np.linalg.norm(points[2] - points[1])),
        calf_length=float(np.linalg.norm(at_zero.foot - points[2])),
        middles=0.5 * (lower + upper),
        axes=axes,
        points=points,
        foot=at_zero.foot,
        lower=lower,
        upper=upper,
        nominal=nominal,
    )
