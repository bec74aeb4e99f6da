"""
The numbers of stacked legs as arrays, and what is done with the axes of each.

The axes are those of :mod:`quad_common.robot.leg_kinematics`: rho0, nu0 and zeta.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import FootTargetUnreachable, SingularPosture

if TYPE_CHECKING:
    from quad_common.robot.leg_kinematics import Leg

Array = NDArray[np.float64]

EDGE = 1e-12
"""Rounding at the very edge of the reach is not an error of the caller's."""

_TWO_PI = 2.0 * np.pi

_SINGULAR = 1e-9
"""Sine of the knee, and leg length as a fraction of the reach, that count as zero."""


class LegArrays(NamedTuple):
    """The numbers of legs with the legs first, to broadcast against (legs, samples)."""

    names: tuple[str, ...]
    """Names of the legs."""
    to_local: Array
    """Rotation from the body's axes to (rho0, nu0, zeta) of each leg, (3 legs, 3 legs)."""
    to_body: Array
    """Rotation back, multiplied from the right: rows of samples."""
    hips: Array
    """Hip points in the body frame, shape (3 legs,) [m]."""
    hips_local: Array
    """Hip points in each leg's own axes, shape (3 legs, 1) [m]."""
    axial: Array
    """Offsets of the pitch axes along zeta, shape (legs, 1) [m]."""
    radial: Array
    """Offsets of the pitch axes along rho, shape (legs, 1) [m]."""
    lateral: Array
    """Offsets of the legs' planes along nu, shape (legs, 1) [m]."""
    has_lateral: bool
    """Whether any of them is not zero."""
    thigh: Array
    """Lengths of the thighs, shape (legs, 1) [m]."""
    calf: Array
    """Lengths of the calves, shape (legs, 1) [m]."""
    knee_sign: Array
    """Signs of the knees' angles, shape (legs, 1)."""
    signs: Array
    """Signs of the joint angles, shape (3, legs, 1)."""
    zeros: Array
    """Angles in the formulas at which joints are at 0, shape (3, legs, 1) [rad]."""
    middles: Array
    """Joint angles within half a turn of which solutions lie, shape (3, legs, 1) [rad]."""
    is_turned: bool
    """Whether any zero or middle is not 0."""

    @property
    def legs(self) -> int:
        """Number of the legs."""
        return len(self.names)

    def angles(self, joints: Array) -> Array:
        """Bring joint angles (..., 3) into the formulas' order (3, legs, samples), [rad]."""
        angles = self.rates(joints)
        if self.is_turned:
            angles += self.zeros
        return angles

    def rates(self, joints: Array) -> Array:
        """Bring joint velocities (..., 3) into the formulas' order and signs, as angles."""
        in_order = np.reshape(joints, (-1, self.legs, 3)).transpose(2, 1, 0)
        rates: Array = np.multiply(in_order, self.signs, order='C')
        return rates

    def to_joints(self, angles: Array) -> None:
        """Turn the formulas' angles (3, legs, samples) into joint angles, in place [rad]."""
        if self.is_turned:
            angles -= self.zeros
        angles *= self.signs
        if self.is_turned:
            turns = np.rint((angles - self.middles) / _TWO_PI)
            angles -= _TWO_PI * turns
        else:
            np.subtract(angles[:2], _TWO_PI, out=angles[:2], where=angles[:2] >= np.pi)

    def locals(self, vectors: Array, origin: Array | None = None) -> Array:
        """Bring vectors (..., 3) of the body into the legs' axes: (3, legs, samples)."""
        result = self.to_local @ np.reshape(vectors, (-1, 3 * self.legs)).T
        if origin is not None:
            result -= origin
        return result.reshape(3, self.legs, -1)

    def in_body(self, local: Array, shape: tuple[int, ...]) -> Array:
        """Bring vectors (3, legs, samples) of the legs' axes into the body's."""
        result: Array = local.reshape(3 * self.legs, -1).T @ self.to_body
        return result.reshape(shape)

    def points(
        self, shape: tuple[int, ...], c1: Array, s1: Array, length: Array, height: Array
    ) -> Array:
        """Place what is at ``length`` along rho and ``height`` along zeta."""
        local = np.empty((3, *c1.shape))
        np.multiply(c1, length, out=local[0])
        np.multiply(s1, length, out=local[1])
        if self.has_lateral:
            local[0] -= self.lateral * s1
            local[1] += self.lateral * c1
        local[2] = height
        result = local.reshape(3 * self.legs, -1).T @ self.to_body
        result += self.hips
        return result.reshape(shape)

    def check_regular(self, sin_knee: Array, B: Array) -> None:
        """Raise SingularPosture where a knee is straight or a foot on the first axis."""
        for values, least, why in (
            (np.abs(sin_knee), _SINGULAR, 'its knee is straight or folded'),
            (
                np.abs(B),
                _SINGULAR * (self.thigh + self.calf),
                'the foot is in line with the first axis',
            ),
        ):
            singular = values <= least
            if singular.any():
                raise SingularPosture(self._name(int(np.argmax(singular)) // B.shape[1]), why)

    def too_near(self, squared_length: Array) -> FootTargetUnreachable:
        """Return the error of a foot that is nearer to the first axis than the leg's plane."""
        worst = int(np.argmax(squared_length < -EDGE * self.lateral * self.lateral))
        leg = worst // squared_length.shape[1]
        lateral = abs(float(self.lateral[leg, 0]))
        distance = float(np.sqrt(max(squared_length.reshape(-1)[worst] + lateral**2, 0.0)))
        longest = abs(float(self.radial[leg, 0])) + float(self.thigh[leg, 0] + self.calf[leg, 0])
        reach = (lateral, float(np.hypot(longest, lateral)))
        return FootTargetUnreachable(self._name(leg), distance, reach, 'first axis')

    def unreachable(self, foot: Array, cos_knee: Array, squared: Array) -> FootTargetUnreachable:
        """Return the error of a foot out of the reach of thigh and calf."""
        bad = ~(np.abs(cos_knee) <= 1.0 + EDGE)
        finite = np.isfinite(foot).all(axis=-1).reshape(-1, self.legs).T
        if not finite.all():
            # One leg's number that is not finite spoils the others of its sample.
            bad = ~finite
        worst = int(np.argmax(bad))
        leg = worst // bad.shape[1]
        d, b = float(self.thigh[leg, 0]), float(self.calf[leg, 0])
        distance = float(np.sqrt(squared.reshape(-1)[worst]))
        return FootTargetUnreachable(self._name(leg), distance, (abs(d - b), d + b))

    def _name(self, leg: int) -> str:
        return self.names[leg]


def arrays_of(leg: Leg) -> LegArrays:
    """Take the numbers of one leg, or of several stacked, as arrays."""
    hips = np.reshape(np.asarray(leg.hip, dtype=float), (-1, 3))
    count = len(hips)
    axes = np.stack([leg.radial_direction, leg.lateral_direction, leg.first_axis])
    axes = axes.reshape(3, count, 3)
    # All legs at once: rows are (axis, leg), columns are (leg, body axis).
    blocks = np.zeros((3, count, count, 3))
    for index in range(count):
        blocks[:, index, index] = axes[:, index]
    to_local = blocks.reshape(3 * count, 3 * count)

    def column(values: ArrayLike) -> Array:
        return np.reshape(np.asarray(values, dtype=float), (count, 1))

    def by_joint(values: ArrayLike) -> Array:
        return np.reshape(np.asarray(values, dtype=float), (count, 3)).T[:, :, None].copy()

    lateral = column(leg.lateral_offset)
    return LegArrays(
        names=(leg.name,) if isinstance(leg.name, str) else leg.name,
        to_local=to_local,
        # The axes are orthonormal.
        to_body=to_local,
        hips=hips.reshape(-1),
        hips_local=to_local @ hips.reshape(-1, 1),
        axial=column(leg.axial_offset),
        radial=column(leg.radial_offset),
        lateral=lateral,
        has_lateral=bool(np.any(lateral != 0.0)),
        thigh=column(leg.thigh_length),
        calf=column(leg.calf_length),
        knee_sign=column(leg.knee_sign),
        signs=by_joint(leg.signs),
        zeros=by_joint(leg.zeros),
        middles=by_joint(leg.middles),
        is_turned=bool(np.any(leg.zeros) or np.any(leg.middles)),
    )


def part_frames(
    leg: Leg, joint_angles: Array, chain: tuple[Array, Array, Array]
) -> list[tuple[Array, tuple[Array, ...]]]:
    """Place the frames of hip, thigh and calf: see the leg's own method."""
    pitch_axis, knee, foot = chain
    zeros, signs = np.asarray(leg.zeros)[..., 0], np.asarray(leg.signs)[..., 0]
    q1 = (zeros + signs * joint_angles[..., 0])[..., None]
    cos, sin = np.cos(q1), np.sin(q1)
    rho: Array = cos * leg.radial_direction + sin * leg.lateral_direction
    nu: Array = cos * leg.lateral_direction - sin * leg.radial_direction
    zeta = np.broadcast_to(leg.first_axis, rho.shape)
    frames: list[tuple[Array, tuple[Array, ...]]] = [
        (np.broadcast_to(leg.hip, rho.shape), (rho, nu, zeta))
    ]
    for start, end, length in (
        (pitch_axis, knee, leg.thigh_length),
        (knee, foot, leg.calf_length),
    ):
        along = (end - start) / np.asarray(length)[..., None]
        frames.append((start, (along, nu, np.cross(along, nu))))
    return frames


def is_in_reach(leg: Leg, feet: Array) -> NDArray[np.bool_]:
    """Return which feet (..., 3) in the body frame [m] one leg reaches in closed form."""
    arms = feet - leg.hip
    x, y, z = (
        arms @ np.asarray(axis)
        for axis in (leg.radial_direction, leg.lateral_direction, leg.first_axis)
    )
    squared = x * x + y * y - np.square(leg.lateral_offset)
    out = np.sqrt(np.maximum(squared, 0.0)) - leg.radial_offset
    distance = np.hypot(out, leg.axial_offset - z)
    least, largest = leg.reach()
    found: NDArray[np.bool_] = (squared >= 0.0) & (distance >= least) & (distance <= largest)
    return found
