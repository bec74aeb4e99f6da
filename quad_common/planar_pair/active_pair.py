"""
Where a planar pair of legs stands, from what of it is held: S3, corrected.

Both feet of a pair stand on the ground. Its body and legs (`planar_pair`) then
have three freedoms: three numbers must be given, and the rest follows. Which ones are given is the
pair's causality. The paper names it by the controlled angles of both legs, "motor00" with none,
"motor01" with the knee u1, "motor02" with the hip u2 (S3 eqs. 11 and 12). It solves the first case
below; the others follow from its blocks (S3 figs. 2 and 3) in the same way::

    function              causality         given, besides feet    found
    with_knee_held        motor00-motor01   hip i, u1 of j         theta, hip j, u2 of j, leg i
    with_hip_held         motor00-motor02   hip i, u2 of j         theta, hip j, u1 of j, leg i
    with_hips_placed      motor00-motor00   hip i, hip j           theta, all four angles
    with_hip_joints_held  motor02-motor02   theta, both u2         both hips, both u1

"Both hips controlled" has two meanings, and each its function: the hips' places, where the paper
calls both legs "motor" legs, or the angles of the hip joints, where the third number is the
body's angle.

**One triangle.** Each case is a triangle of a known side, a link that turns by an unknown angle,
and a third side of known length. For the knee that is held these are the body, lambda = lambda_j -
lambda_i, the leg W, and g = |G^j - R^i| (S3 eq. 33)::

    | lambda + e^(j u2) W | = g

Its law of cosines is the paper's a cos u2 + b sin u2 = c (S3 eqs. 39 to 45, with g squared in
S3 eq. 44). It has two solutions where g is from ||lambda| - |W|| to |lambda| + |W|, and none
elsewhere: :class:`~quad_common.errors.PairCannotClose` says so with the numbers. The body's
angle follows from S3 eqs. 57 and 58, hip j from S3 eq. 59, and leg i from the law of cosines again
(S3 eqs. 20, 60 and 61).

**Branches.** The two solutions mirror the link at the known side of its triangle.

- ``branch``, of the free joint of leg j: 'up' where foot j is above the body's line
  (``with_knee_held``), or above the line from hip i to knee j (``with_hip_held``), in the body's
  axes with hip j towards +x from hip i; 'up' where the body is higher (``with_hip_joints_held``).
  A body upright on its feet is 'down' in the first case.
- ``knee_i``, ``knee_j``, of a leg with both joints free: 'up' where its upper link is turned
  further counter-clockwise, so that u1 <= 0, and 'down' where u1 >= 0.

The paper calls u2 > 0 up, and u2 <= 0 down (S3 eqs. 25 and 26), which does not tell two solutions
apart that have one sign. For an upper link no shorter than the lower one, the names of
``with_knee_held`` are the paper's wherever the paper's tell them apart.

**Along a motion** a named branch stays on its side. With ``previous``, the posture just before the
first sample, each sample takes the solution nearest to the sample before it, in the free joint's
angle; samples are in order along the first axis. Motions must be sampled more finely than
the two solutions lie apart; at equal distance the side is kept.

Angles returned are in [-pi, pi). All arguments broadcast against one another; the result has
their common shape.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from quad_common.errors import PairCannotClose
from quad_common.planar_pair.planar_pair import ActivePair, Array, Branch, PairPosture, Points
from quad_common.planar_pair.planar_triangles import (
    TriangleWords,
    argument,
    bent_leg,
    first_of,
    same_shape,
    sign_of,
    squared_length,
    turned_link,
    unit,
    wrapped,
)

_RIGID = 1e-9
"""Fraction of the body's length by which hips may be off it: rounding of the caller's."""


_KNEE_HELD = TriangleWords(
    'hip i and foot j',
    'body and leg j with its knee as held reach',
    'foot j is at hip i or at hip j',
)
_HIP_HELD = TriangleWords(
    'hip i and foot j',
    'body and leg j with its hip as held reach',
    'foot j or knee j is at hip i',
)


def with_knee_held(
    pair: ActivePair,
    hip_i: ArrayLike,
    foot_i: ArrayLike,
    foot_j: ArrayLike,
    u1_j: ArrayLike,
    *,
    branch: Branch = 'down',
    knee_i: Branch = 'down',
    previous: PairPosture | None = None,
) -> PairPosture:
    """
    Find the posture where knee j is held, and the three other joints are free.

    This is the paper's case, motor00-motor01 (S3 eqs. 13 to 62).

    Parameters
    ----------
    pair : ActivePair
        The pair.
    hip_i, foot_i, foot_j : array_like of complex, shape (...)
        R^i, G^i and G^j, x + j z [m].
    u1_j : array_like, shape (...)
        Angle of knee j [rad].
    branch : {'up', 'down'}
        'up' has foot j above the body's line, 'down' below it.
    knee_i : {'up', 'down'}
        'up' has u1 of leg i <= 0, 'down' >= 0.
    previous : PairPosture, optional
        The posture just before the first sample: it takes the place of both branches.

    Returns
    -------
    PairPosture
        Fields of shape (...).

    Raises
    ------
    PairCannotClose
        If |G^j - R^i| is not from ||lambda| - |W_j|| to |lambda| + |W_j| with
        W_j = b^j + a^j e^(j u1), or |G^i - R^i| not within the reach of leg i.
    PairUndetermined
        If foot j is at hip i, or at hip j, or foot i is at hip i.
    """
    R_i, G_i, G_j, u1 = same_shape((hip_i, foot_i, foot_j), (u1_j,))
    W = pair.leg_j.upper + pair.leg_j.lower * unit(u1)
    AB, u2 = turned_link(
        pair.span,
        W,
        squared_length(G_j - R_i),
        sign_of(branch, 'branch') * np.sign(pair.span),
        _before(previous, 'u2_j'),
        _KNEE_HELD,
    )
    return _pair_on_leg_j(pair, _Ends(R_i, G_i, G_j), _LegJ(AB, u1, u2), knee_i, previous)


def with_hip_held(
    pair: ActivePair,
    hip_i: ArrayLike,
    foot_i: ArrayLike,
    foot_j: ArrayLike,
    u2_j: ArrayLike,
    *,
    branch: Branch = 'down',
    knee_i: Branch = 'down',
    previous: PairPosture | None = None,
) -> PairPosture:
    """
    Find the posture where hip joint j is held, and the three other joints are free.

    This is motor00-motor02 (S3 eq. 12). Knee j is at P = lambda + b^j e^(j u2) from hip i in the
    body's axes, so that S3 eq. 33 reads |P + a^j e^(j (u2 + u1))| = |G^j - R^i| with u1
    unknown.

    Parameters
    ----------
    pair : ActivePair
        The pair.
    hip_i, foot_i, foot_j : array_like of complex, shape (...)
        R^i, G^i and G^j, x + j z [m].
    u2_j : array_like, shape (...)
        Angle of hip joint j [rad].
    branch : {'up', 'down'}
        'up' has foot j above the line from hip i to knee j, with hip j towards +x from hip i:
        for lambda_j > lambda_i, counter-clockwise from it.
    knee_i : {'up', 'down'}
        'up' has u1 of leg i <= 0, 'down' >= 0.
    previous : PairPosture, optional
        The posture just before the first sample: it takes the place of both branches.

    Returns
    -------
    PairPosture
        Fields of shape (...).

    Raises
    ------
    PairCannotClose
        If |G^j - R^i| is not from ||P| - a^j| to |P| + a^j, or |G^i - R^i| not within the reach
        of leg i.
    PairUndetermined
        If foot j, or knee j, is at hip i, or foot i is at hip i.
    """
    R_i, G_i, G_j, u2 = same_shape((hip_i, foot_i, foot_j), (u2_j,))
    upper = unit(u2)
    lower, u1 = turned_link(
        pair.span + pair.leg_j.upper * upper,
        pair.leg_j.lower * upper,
        squared_length(G_j - R_i),
        sign_of(branch, 'branch') * np.sign(pair.span),
        _before(previous, 'u1_j'),
        _HIP_HELD,
    )
    AB = pair.leg_j.upper * upper + lower
    return _pair_on_leg_j(pair, _Ends(R_i, G_i, G_j), _LegJ(AB, u1, u2), knee_i, previous)


def with_hips_placed(
    pair: ActivePair,
    hip_i: ArrayLike,
    hip_j: ArrayLike,
    foot_i: ArrayLike,
    foot_j: ArrayLike,
    *,
    knee_i: Branch = 'down',
    knee_j: Branch = 'down',
    previous: PairPosture | None = None,
) -> PairPosture:
    """
    Find the posture whose hips are where they are wanted; all four joints are free.

    This is motor00-motor00: theta by S3 eq. 27, and each leg alone by S3 eq. 20.

    Parameters
    ----------
    pair : ActivePair
        The pair.
    hip_i, hip_j, foot_i, foot_j : array_like of complex, shape (...)
        R^i, R^j, G^i and G^j, x + j z [m].
    knee_i, knee_j : {'up', 'down'}
        'up' has u1 of that leg <= 0, 'down' >= 0.
    previous : PairPosture, optional
        The posture just before the first sample: it takes the place of both branches.

    Returns
    -------
    PairPosture
        Fields of shape (...). Hip j is the one that the rigid body has.

    Raises
    ------
    PairCannotClose
        If |R^j - R^i| is not |lambda_j - lambda_i| (S3 eq. 24) to a billionth, or a foot is not
        within the reach of its leg.
    PairUndetermined
        If a foot is at its hip.
    """
    R_i, R_j, G_i, G_j = same_shape((hip_i, hip_j, foot_i, foot_j), ())
    with np.errstate(invalid='ignore', over='ignore'):
        apart = np.abs(R_j - R_i)
        holds = np.abs(apart - abs(pair.span)) <= _RIGID * abs(pair.span)
    if not holds.all():
        index, where = first_of(~holds)
        span = abs(pair.span)
        raise PairCannotClose(
            index, 'hip i and hip j', 'the body holds them at', float(apart[where]), (span, span)
        )
    along = (R_j - R_i) / (np.sign(pair.span) * apart)
    u1_i, u2_i = bent_leg(
        pair.leg_i, 'i', (G_i - R_i) * along.conj(), knee_i, _before(previous, 'u1_i')
    )
    u1_j, u2_j = bent_leg(
        pair.leg_j, 'j', (G_j - R_j) * along.conj(), knee_j, _before(previous, 'u1_j')
    )
    hip_j_of_body = R_i + pair.span * along
    return PairPosture(argument(along), R_i.copy(), hip_j_of_body, u1_i, u2_i, u1_j, u2_j)


def with_hip_joints_held(
    pair: ActivePair,
    theta: ArrayLike,
    u2_i: ArrayLike,
    u2_j: ArrayLike,
    foot_i: ArrayLike,
    foot_j: ArrayLike,
    *,
    branch: Branch = 'up',
    previous: PairPosture | None = None,
) -> PairPosture:
    """
    Find the posture with both hip joints held and the body's angle known; both knees are free.

    This is motor02-motor02. The directions of body and upper links are known, so that knee i
    is at a known vector from hip i, and so is knee j. Hip i is where two circles meet: about
    C^i = G^i - b^i e^(j (theta + u2^i)) with radius a^i, and about
    C^j = G^j - lambda e^(j theta) - b^j e^(j (theta + u2^j)) with radius a^j (S3 eqs. 21 to 23).

    Parameters
    ----------
    pair : ActivePair
        The pair.
    theta : array_like, shape (...)
        Angle of the body, for example as an imu measures it [rad].
    u2_i, u2_j : array_like, shape (...)
        Angles of the hip joints [rad].
    foot_i, foot_j : array_like of complex, shape (...)
        G^i and G^j, x + j z [m].
    branch : {'up', 'down'}
        'up' has the body higher.
    previous : PairPosture, optional
        The posture just before the first sample: it takes the branch's place.

    Returns
    -------
    PairPosture
        Fields of shape (...).

    Raises
    ------
    PairCannotClose
        If |C^j - C^i| is not from |a^i - a^j| to a^i + a^j.
    PairUndetermined
        If C^i and C^j are one point, as with upper links in parallel, lower links of one
        length and feet as far apart as the hips: the lower links are a parallelogram's.
    """
    G_i, G_j, angle, hip_angle_i, hip_angle_j = same_shape((foot_i, foot_j), (theta, u2_i, u2_j))
    along = unit(angle)
    upper_i, upper_j = along * unit(hip_angle_i), along * unit(hip_angle_j)
    C_i = G_i - pair.leg_i.upper * upper_i
    C_j = G_j - pair.span * along - pair.leg_j.upper * upper_j
    back = _back_to_hip_i(pair, C_i - C_j, branch, previous)
    R_i = C_i + back
    R_j = R_i + pair.span * along
    u1_i = argument(-back * upper_i.conj())
    u1_j = argument((C_j - R_i) * upper_j.conj())
    wrapped_i, wrapped_j = argument(unit(hip_angle_i)), argument(unit(hip_angle_j))
    return PairPosture(argument(along), R_i, R_j, u1_i, wrapped_i, u1_j, wrapped_j)


def _back_to_hip_i(
    pair: ActivePair, base: Points, branch: Branch, previous: PairPosture | None
) -> Points:
    """Return the vector from C^i to hip i, against lower link i; base is C^i - C^j."""
    before = None
    if previous is not None:
        before = previous.theta + previous.u2_i + previous.u1_i + np.pi
    back, _ = turned_link(
        base,
        np.asarray(pair.leg_i.lower + 0j),
        pair.leg_j.lower**2,
        sign_of(branch, 'branch') * np.where(base.real < 0.0, -1.0, 1.0),
        before,
        TriangleWords(
            'the feet, less body and upper links,',
            'the lower links reach',
            'both lower links may turn in parallel',
            is_third_side=True,
        ),
    )
    return back


class _Ends(NamedTuple):
    """What the ground and hip i are given as, x + j z [m]."""

    hip_i: Points
    """R^i."""
    foot_i: Points
    """G^i."""
    foot_j: Points
    """G^j."""


class _LegJ(NamedTuple):
    """Leg j in the body's axes."""

    AB: Points
    """Vector from hip j to foot j, x + j z [m]."""
    u1: Array
    """Angle of its knee [rad]."""
    u2: Array
    """Angle of its hip joint [rad]."""


def _pair_on_leg_j(
    pair: ActivePair, ends: _Ends, leg_j: _LegJ, knee_i: Branch, previous: PairPosture | None
) -> PairPosture:
    """Place body and leg i, once leg j is known in the body's axes (S3 eqs. 57 to 61)."""
    R_i, G_i, G_j = ends
    chain = pair.span + leg_j.AB
    along = (G_j - R_i) * chain.conj()
    along /= np.sqrt(squared_length(along))
    R_j = R_i + pair.span * along
    u1_i, u2_i = bent_leg(
        pair.leg_i, 'i', (G_i - R_i) * along.conj(), knee_i, _before(previous, 'u1_i')
    )
    u1_j, u2_j = wrapped(leg_j.u1), wrapped(leg_j.u2)
    return PairPosture(argument(along), R_i.copy(), R_j, u1_i, u2_i, u1_j, u2_j)


def _before(previous: PairPosture | None, angle: str) -> Array | None:
    """Return an angle of the posture before a motion, if there is one."""
    return None if previous is None else np.asarray(getattr(previous, angle))
