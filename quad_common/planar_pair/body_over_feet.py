"""
How a body stands over a front and a hind foot: the sagittal plane of a quadruped.

Points are x + j z, angles counter-clockwise, as in `planar_pair`. For a leg
that rolls, pitches and pitches, with its plane upright, the angles are::

    theta = -pitch        u2 = -pi/2 - q2        u1 = -q3
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from quad_common.errors import (
    ActivePairError,
    BodyOutOfReach,
    PairCannotClose,
    ParameterError,
)
from quad_common.planar_pair.planar_pair import (
    ActivePair,
    Array,
    JointAngles,
    PairPosture,
    Points,
    posture_of,
)
from quad_common.planar_pair.planar_triangles import (
    TriangleWords,
    argument,
    first_of,
    squared_length,
    turned_link,
    unit,
)

_STEPS = 50
"""Number of steps of Newton's method, which needs about five; fifty halvings leave nothing."""

_CLOSE_ENOUGH = 1e-12
"""Error of the body's place that is allowed, as a fraction of its length."""

Joint = Literal['u1_i', 'u2_i', 'u1_j', 'u2_j']


class SagittalPose(NamedTuple):
    """Where a body is over its feet."""

    theta: Array
    """Angle of the body's line; the body's pitch is -theta [rad]."""
    hip_i: Points
    """Place of the hip of leg i [m]."""
    hip_j: Points
    """Place of the hip of leg j [m]."""


def body_over_feet(
    pair: ActivePair,
    foot_i: ArrayLike,
    foot_j: ArrayLike,
    length_i: ArrayLike,
    length_j: ArrayLike,
    middle: ArrayLike | None = None,
) -> SagittalPose:
    """
    Stand a body on two feet, at different heights, with legs of given lengths.

    Feet, legs and body are a linkage of four bars, which has one freedom left: the place of
    the point midway between the hips, along x, is what fixes it. Hip i is at the end of leg i,
    in its direction phi; hip j by the triangle of body and leg j, above the line from hip i to
    foot j as the robot stands upright; Newton's method finds phi, between the ends of its range.

    Parameters
    ----------
    pair : ActivePair
        The pair.
    foot_i, foot_j : array_like of complex, shape (...)
        x + j z [m].
    length_i, length_j : array_like, shape (...)
        From hip to foot [m].
    middle : array_like, shape (...), optional
        Where the point midway between the hips is to be, along x; midway between the feet if
        not given [m].

    Returns
    -------
    SagittalPose
        Fields of shape (...).

    Raises
    ------
    PairCannotClose
        If body and legs do not span the feet at all.
    BodyOutOfReach
        If they do, and do not carry the body to its place.
    """
    points = (np.asarray(foot, dtype=complex) for foot in (foot_i, foot_j))
    lengths = (np.asarray(length, dtype=float) for length in (length_i, length_j))
    G_i, G_j, l_i, l_j = np.broadcast_arrays(*points, *lengths)
    wanted = (G_i.real + G_j.real) / 2.0 if middle is None else np.asarray(middle, dtype=float)
    G_i, G_j, l_i, l_j, wanted = np.broadcast_arrays(G_i, G_j, l_i, l_j, wanted)
    for name, length in (('length_i', l_i), ('length_j', l_j)):
        if not (length > 0.0).all():
            raise ParameterError(name, float(np.min(length)), 'greater than 0 m')
    if pair.span < 0.0:
        # Seen from the other side, hip j is towards +x from hip i.
        mirrored = _over_feet(-pair.span, -G_i.conj(), -G_j.conj(), l_i, l_j, -wanted)
        R_i, body = (-point.conj() for point in mirrored)
    else:
        R_i, body = _over_feet(pair.span, G_i, G_j, l_i, l_j, wanted)
    return SagittalPose(argument(body * np.sign(pair.span)), R_i, R_i + body)


def _over_feet(
    span: float, G_i: Points, G_j: Points, l_i: Array, l_j: Array, wanted: Array
) -> tuple[Points, Points]:
    """Find hip i, and the vector from it to hip j, for a hip j towards +x from hip i."""
    between = G_j - G_i
    apart = np.abs(between)
    # Where hip i is so far from foot j as body and leg j reach: angles from the feet's line.
    ends = [(apart**2 + l_i**2 - (span + part) ** 2) / (2.0 * apart * l_i) for part in (-l_j, l_j)]
    closes = (ends[0] > -1.0) & (ends[1] < 1.0)
    if not closes.all():
        index, where = first_of(~closes)
        sides = (span, float(l_i[where]), float(l_j[where]))
        reach = (max(0.0, 2.0 * max(sides) - sum(sides)), sum(sides))
        links = 'body and legs of these lengths reach'
        raise PairCannotClose(index, 'foot i and foot j', links, float(apart[where]), reach)
    near, far = (argument(between) + np.arccos(np.clip(end, -1.0, 1.0)) for end in ends)

    def place(phi: Array) -> tuple[Points, Points, Array, Array]:
        """Return hip i, body, how far the middle is off, and how fast that changes with phi."""
        leg = l_i * unit(phi)
        R_i = G_i + leg
        to_foot = G_j - R_i
        squared = squared_length(to_foot)
        x = (squared + span * span - l_j * l_j) / (2.0 * squared)
        y = np.sqrt(np.maximum(span * span / squared - x * x, 0.0))
        body = to_foot * (x + 1j * y)
        off = (R_i + body / 2.0).real - wanted
        # Hip j stays on its circle about foot j.
        leg_j = body - to_foot
        with np.errstate(divide='ignore', invalid='ignore'):
            turn = -(leg_j.conj() * 1j * leg).real / (leg_j.conj() * 1j * body).real
        return R_i, body, off, (1j * leg + 0.5j * body * turn).real

    off_near, off_far = place(near)[2], place(far)[2]
    outside = ~((off_near >= 0.0) & (off_far <= 0.0))
    if outside.any():
        index, where = first_of(outside)
        x = float(wanted[where])
        raise BodyOutOfReach(index, x, (x + float(off_far[where]), x + float(off_near[where])))
    phi = np.clip(np.pi / 2.0, near + 0.1 * (far - near), far - 0.1 * (far - near))
    for _ in range(_STEPS):
        R_i, body, off, speed = place(phi)
        if (np.abs(off) <= _CLOSE_ENOUGH * span).all():
            break
        near, far = np.where(off > 0.0, phi, near), np.where(off > 0.0, far, phi)
        with np.errstate(divide='ignore', invalid='ignore'):
            newton = phi - off / speed
        # Newton's step where it stays between what is known, half of that otherwise.
        phi = np.where((newton > near) & (newton < far), newton, (near + far) / 2.0)
    return R_i, body


class FreeJointPose(NamedTuple):
    """Where a pair comes to stand on planted feet when one of its joints gives way."""

    posture: PairPosture | None
    """Posture; None if the stance does not close any more."""
    why: str
    """Why it does not; empty if it does."""

    @property
    def closes(self) -> bool:
        """Whether there is such a posture."""
        return self.posture is not None


def pose_with_free_joint(
    pair: ActivePair,
    foot_i: complex,
    foot_j: complex,
    held: JointAngles,
    free: Joint,
) -> FreeJointPose:
    """
    Find where a pair stands when one joint is free, and three hold their angles.

    Three held angles leave nothing free. With AB of the other leg known, S3 eq. 33 reads
    |lambda - AB^i + AB^j| = |G^j - G^i|, and is solved in the same way.

    Parameters
    ----------
    pair : ActivePair
        The pair.
    foot_i, foot_j : complex
        Where the feet are planted, x + j z [m].
    held : JointAngles
        Angles that the joints hold, each a float. For the free one its last known angle: of two
        solutions the one that is nearer to it is taken.
    free : {'u1_i', 'u2_i', 'u1_j', 'u2_j'}
        The joint that is free.

    Returns
    -------
    FreeJointPose
        The posture, or why there is none.
    """
    if free not in ('u1_i', 'u2_i', 'u1_j', 'u2_j'):
        raise ParameterError('free', free, "'u1_i', 'u2_i', 'u1_j' or 'u2_j'")
    try:
        if free.endswith('_i'):
            feet = foot_j, foot_i
            posture = _on_free_leg_j(pair.swapped(), *feet, held.swapped(), free.startswith('u1'))
            return FreeJointPose(posture.swapped(), '')
        posture = _on_free_leg_j(pair, foot_i, foot_j, held, free.startswith('u1'))
    except ActivePairError as error:
        return FreeJointPose(None, str(error))
    return FreeJointPose(posture, '')


def _on_free_leg_j(
    pair: ActivePair, G_i: complex, G_j: complex, held: JointAngles, knee_is_free: bool
) -> PairPosture:
    """Find the posture where leg j has the free joint."""
    i, j = pair.leg_i, pair.leg_j
    u1_i, u2_i, u1_j, u2_j = (float(np.asarray(angle)) for angle in held)
    AB_i = np.exp(1j * u2_i) * (i.upper + i.lower * np.exp(1j * u1_i))
    upper = np.exp(1j * u2_j)
    base = pair.span - AB_i
    turned, angle = turned_link(
        base + j.upper * upper if knee_is_free else base,
        j.lower * upper if knee_is_free else j.upper + j.lower * np.exp(1j * u1_j),
        abs(G_j - G_i) ** 2,
        1.0,
        np.asarray(u1_j if knee_is_free else u2_j),
        TriangleWords('the feet', 'the legs, as held, reach', 'both feet may be in one place'),
    )
    chain = base + j.upper * upper + turned if knee_is_free else base + turned
    theta = np.angle((G_j - G_i) / chain)
    hip_i = G_i - np.exp(1j * theta) * AB_i
    found = held._replace(**{'u1_j' if knee_is_free else 'u2_j': angle})
    return posture_of(pair, hip_i, theta, found)
