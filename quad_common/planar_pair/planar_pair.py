"""
A body on two planar legs: its measures, its postures, and where its points are (S3 sec. 2).

Everything lies in one vertical plane. A point is a complex number, x + j z: x forward, z up,
both in metres. An angle is counter-clockwise from x towards z, in radians. (Pitch about the y
axis of REP-103 is the other way round: pitch = -theta.)

The body is a line through its origin O at the angle theta. On it are the two hips, and at
each hip a leg hangs, of an upper link b and a lower link a::

    R = O + lambda e^(j theta)              hip (S3 eqs. 3 and 4)
    W = b + a e^(j u1)                      leg from its hip, along its upper link (S3 eq. 35)
    AB = e^(j u2) W                         leg in the body's axes (S3 eq. 22)
    G = R + e^(j theta) AB                  foot (S3 eq. 21)

So u2 is the hip's angle, of the upper link from the body's line, and u1 the knee's, of the lower
link from the upper one. Legs and hips are called i and j, as in the paper; which of them is in
front is the sign of lambda_j - lambda_i.

With both feet on the ground three freedoms are left to the pair: what must be given to know the
rest is in :mod:`quad_common.planar_pair.active_pair`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any, Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import ParameterError

Array = NDArray[np.float64]
Points = NDArray[np.complex128]

Branch = Literal['up', 'down']
"""Which of two solutions: see :mod:`quad_common.planar_pair.active_pair`."""


@dataclass(frozen=True)
class PlanarLeg:
    """The links of a leg."""

    upper: float
    """Length from hip to knee, b [m]."""
    lower: float
    """Length from knee to foot, a [m]."""

    def __post_init__(self) -> None:
        for name in ('upper', 'lower'):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, 'a finite length greater than 0 m')

    def reach(self) -> tuple[float, float]:
        """Return the least and the largest distance between hip and foot [m]."""
        return abs(self.upper - self.lower), self.upper + self.lower


@dataclass(frozen=True)
class ActivePair:
    """
    Two legs on a body, which alone say where the body is (S3 sec. 2).

    Raises
    ------
    ParameterError
        If a length is not positive, or both hips are in one place (S3 eq. 27 asks for two).
    """

    leg_i: PlanarLeg
    """Leg i of the pair."""
    leg_j: PlanarLeg
    """Leg j of the pair."""
    lambda_i: float
    """Place of hip i on the body's line, from the body's origin [m]."""
    lambda_j: float
    """Place of hip j [m]."""

    def __post_init__(self) -> None:
        for name in ('lambda_i', 'lambda_j'):
            if not math.isfinite(getattr(self, name)):
                raise ParameterError(name, getattr(self, name), 'finite')
        if self.lambda_i == self.lambda_j:
            raise ParameterError('lambda_j', self.lambda_j, 'another than lambda_i')

    @property
    def span(self) -> float:
        """Distance from hip i to hip j, lambda_j - lambda_i; negative if j is behind [m]."""
        return self.lambda_j - self.lambda_i

    def swapped(self) -> ActivePair:
        """Return the same pair with leg i for j, and j for i."""
        return ActivePair(self.leg_j, self.leg_i, self.lambda_j, self.lambda_i)


class JointAngles(NamedTuple):
    """Angles of the four joints of a pair, each of shape (...)."""

    u1_i: ArrayLike
    """Angle of knee i [rad]."""
    u2_i: ArrayLike
    """Angle of hip joint i [rad]."""
    u1_j: ArrayLike
    """Angle of knee j [rad]."""
    u2_j: ArrayLike
    """Angle of hip joint j [rad]."""

    def swapped(self) -> JointAngles:
        """Return the same angles of :meth:`ActivePair.swapped`."""
        return JointAngles(self.u1_j, self.u2_j, self.u1_i, self.u2_i)


@dataclass(frozen=True, eq=False)
class PairPosture:
    """
    How a pair stands: one posture, or many, all fields with the same shape.

    Angles are in [-pi, pi).
    """

    theta: Array
    """Angle of the body's line [rad]."""
    hip_i: Points
    """R^i [m]."""
    hip_j: Points
    """R^j [m]."""
    u1_i: Array
    """Knee of leg i [rad]."""
    u2_i: Array
    """Hip of leg i [rad]."""
    u1_j: Array
    """Knee of leg j [rad]."""
    u2_j: Array
    """Hip of leg j [rad]."""

    def __getitem__(self, index: int | slice | NDArray[Any]) -> PairPosture:
        """Take some of the postures."""
        return PairPosture(*(np.asarray(getattr(self, f.name))[index] for f in fields(self)))

    def swapped(self) -> PairPosture:
        """Return the same posture of :meth:`ActivePair.swapped`."""
        return PairPosture(
            self.theta, self.hip_j, self.hip_i, self.u1_j, self.u2_j, self.u1_i, self.u2_i
        )


class PairPoints(NamedTuple):
    """Where the joints and feet of a pair are, x + j z [m]."""

    hip_i: Points
    """Place of the hip of leg i, x + iz [m]."""
    knee_i: Points
    """Place of the knee of leg i [m]."""
    foot_i: Points
    """Place of the foot of leg i [m]."""
    hip_j: Points
    """Place of the hip of leg j [m]."""
    knee_j: Points
    """Place of the knee of leg j [m]."""
    foot_j: Points
    """Place of the foot of leg j [m]."""


def posture_of(
    pair: ActivePair, hip_i: ArrayLike, theta: ArrayLike, joints: JointAngles
) -> PairPosture:
    """
    Put a posture together from the body's pose and the angles of all joints.

    Parameters
    ----------
    pair : ActivePair
        The pair.
    hip_i : array_like of complex, shape (...)
        Where hip i is [m].
    theta : array_like, shape (...)
        Angle of the body [rad].
    joints : JointAngles
        Angles of the joints.

    Returns
    -------
    PairPosture
        With hip j by S3 eq. 23.
    """
    angles = [np.asarray(angle, dtype=float) for angle in (theta, *joints)]
    place = np.asarray(hip_i, dtype=complex)
    shape = np.broadcast_shapes(place.shape, *(angle.shape for angle in angles))
    R_i = np.broadcast_to(place, shape).copy()
    body, *wrapped = (wrap(np.broadcast_to(angle, shape)) for angle in angles)
    R_j = np.asarray(R_i + pair.span * np.exp(1j * body))
    return PairPosture(body, R_i, R_j, *wrapped)


def points_of(pair: ActivePair, posture: PairPosture) -> PairPoints:
    """
    Place hips, knees and feet: the forward model (S3 eqs. 3, 4, 21 and 22).

    Parameters
    ----------
    pair : ActivePair
        The pair.
    posture : PairPosture
        Fields of shape (...).

    Returns
    -------
    PairPoints
        Each of shape (...), x + j z [m].
    """
    points: list[Points] = []
    for leg, hip, u1, u2 in (
        (pair.leg_i, posture.hip_i, posture.u1_i, posture.u2_i),
        (pair.leg_j, posture.hip_j, posture.u1_j, posture.u2_j),
    ):
        upper = posture.theta + u2
        knee = hip + leg.upper * np.exp(1j * upper)
        points += [hip, knee, knee + leg.lower * np.exp(1j * (upper + u1))]
    return PairPoints(*points)


def wrap(angle: Array) -> Array:
    """Wrap angles to [-pi, pi)."""
    wrapped: Array = np.mod(angle + np.pi, 2.0 * np.pi) - np.pi
    # Just below -pi the modulus may round up to a whole turn.
    return np.where(wrapped >= np.pi, -np.pi, wrapped)
