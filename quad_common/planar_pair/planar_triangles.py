"""
Triangles of links in a plane: a link that turns until the ends of a chain are in their places.

Points are complex numbers, angles counter-clockwise [rad]; see `planar_pair`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import PairCannotClose, PairUndetermined, ParameterError
from quad_common.planar_pair.planar_pair import Array, PlanarLeg, Points, wrap

_EDGE = 1e-12
"""Rounding at the very edge of the reach is not an error of the caller's."""

_COINCIDENT = 1e-12
"""Distance of two points, as a fraction of the links' lengths, that counts as none."""

_SIGNS = {'up': 1.0, 'down': -1.0}

Signs = float | Array
"""+1 or -1: on which side of its known side a triangle lies, counter-clockwise being +1."""


def bent_leg(
    leg: PlanarLeg, name: str, foot: Points, knee: str, before: Array | None = None
) -> tuple[Array, Array]:
    """
    Find both angles of a leg alone (S3 eqs. 20, 60 and 61).

    Parameters
    ----------
    leg : PlanarLeg
        The leg.
    name : str
        What it is called.
    foot : complex, shape (...)
        From the hip, in the body's axes [m].
    knee : {'up', 'down'}
        'up' has u1 <= 0.
    before : float, shape of a sample, optional
        u1 just before the first sample [rad]: it takes the branch's place.

    Returns
    -------
    tuple of ndarray, shape (...)
        u1 and u2 [rad].

    Raises
    ------
    PairCannotClose
        If the foot is not within the leg's reach.
    PairUndetermined
        If the foot is at the hip.
    """
    b, a = leg.upper, leg.lower
    squared = squared_length(foot)
    cosine = (squared - (a * a + b * b)) / (2.0 * a * b)
    within = np.abs(cosine) <= 1.0 + _EDGE
    if not within.all():
        index, where = first_of(~within)
        distance = float(np.sqrt(squared[where]))
        ends, links = f'hip {name} and foot {name}', f'leg {name} reaches'
        raise PairCannotClose(index, ends, links, distance, leg.reach())
    # A leg of two equal links, folded, has no direction.
    undetermined = squared <= (_COINCIDENT * (a + b)) ** 2
    if undetermined.any():
        raise PairUndetermined(first_of(undetermined)[0], f'foot {name} is at hip {name}')
    sine = np.sqrt(np.maximum((1.0 - cosine) * (1.0 + cosine), 0.0))
    sign: Signs = -sign_of(knee, f'knee_{name}')
    if before is not None:
        sign = nearest_signs(np.zeros(()), np.arctan2(sine, cosine), before, sign)
    sine = sign * sine
    W = np.empty(foot.shape, dtype=complex)
    W.real, W.imag = b + a * cosine, a * sine
    return wrapped(np.arctan2(sine, cosine)), argument(foot * W.conj())


class TriangleWords(NamedTuple):
    """What is said of a triangle that does not exist."""

    ends: str
    """Two ends that do not come together."""
    links: str
    """Links that are to reach."""
    undetermined: str
    """Remark on what is wrong where a side has no length."""
    is_third_side: bool = False
    """Whether link and third side are to span the base, and not base and link the third side."""


def turned_link(
    base: float | Points,
    link: Points,
    third_squared: float | Array,
    sign: Signs,
    before: Array | None,
    words: TriangleWords,
) -> tuple[Points, Array]:
    """
    Solve | base + e^(j u) link | = third for u, on one side of base.

    Parameters
    ----------
    base : complex, shape (...)
        The known side [m].
    link : complex, shape (...)
        What turns, at u = 0 [m].
    third_squared : float, shape (...)
        The third side's length, squared [m^2].
    sign : float, shape (...)
        +1 for the solution counter-clockwise from base, -1 for the other.
    before : float, shape of a sample, optional
        u just before the first sample [rad]: it takes the sign's place.
    words : TriangleWords
        What errors say.

    Returns
    -------
    tuple
        e^(j u) link, shape (...) [m], and u, shape (...) [rad].

    Raises
    ------
    PairCannotClose
        If no such triangle exists.
    PairUndetermined
        If one of its sides has no length.
    """
    base = np.asarray(base, dtype=complex)
    p2, q2, g2 = squared_length(base), squared_length(link), np.asarray(third_squared)
    p, q = np.sqrt(p2), np.sqrt(q2)
    # Along base and across it: the law of cosines.
    along = g2 - p2 - q2
    within = (np.abs(along) <= 2.0 * p * q + _EDGE * (p2 + q2)) & np.isfinite(along)
    if not within.all():
        raise _cannot_close(within, p, q, np.sqrt(g2), words)
    least = (_COINCIDENT * (p + q)) ** 2
    no_side = (p2 <= least) | (q2 <= least) | (g2 <= least)
    if no_side.any():
        raise PairUndetermined(first_of(no_side)[0], words.undetermined)
    x = along / (2.0 * p)
    y = np.sqrt(np.maximum((q - x) * (q + x), 0.0))
    if before is not None:
        sign = nearest_signs(argument(base * link.conj()), np.arctan2(y, x), before, sign)
    turned = np.empty(x.shape, dtype=complex)
    turned.real, turned.imag = x, sign * y
    turned *= base / p
    return turned, argument(turned * link.conj())


def _cannot_close(
    within: NDArray[np.bool_], p: Array, q: Array, g: Array, words: TriangleWords
) -> PairCannotClose:
    """Return the error of the first triangle of sides p, q and g that does not exist."""
    index, where = first_of(~within)
    sides = (p, g) if words.is_third_side else (g, p)
    distance, one, other = (
        float(np.broadcast_to(side, within.shape)[where]) for side in (*sides, q)
    )
    return PairCannotClose(
        index, words.ends, words.links, distance, (abs(one - other), one + other)
    )


def nearest_signs(middle: Array, half: Array, before: Array, kept: Signs) -> Array:
    """
    Choose between the angles middle + half and middle - half so that a motion is continuous.

    Parameters
    ----------
    middle, half : ndarray, shape (n, ...) or ()
        [rad]
    before : ndarray, shape (...)
        The angle before the first sample [rad].
    kept : float or ndarray, shape (n, ...)
        Sign that is taken where the first sample's angles are equally near.

    Returns
    -------
    ndarray, shape (n, ...)
        +1 or -1: of the angle that is nearer to the one chosen before.
    """
    shape = half.shape
    middle, half, kept_signs = np.broadcast_arrays(
        np.atleast_1d(middle), np.atleast_1d(half), np.atleast_1d(kept)
    )
    first = np.broadcast_to(before, half.shape[1:])[None]
    plus, minus = middle + half, middle - half
    last_plus, last_minus = (np.concatenate([first, sign[:-1]]) for sign in (plus, minus))
    # Where each sign leads to at the next sample; the sign is kept at equal distance.
    stays = np.abs(wrap(plus - last_plus)) <= np.abs(wrap(minus - last_plus))
    goes = np.abs(wrap(plus - last_minus)) < np.abs(wrap(minus - last_minus))
    # Steps either forget what was before, keep it, or change sides.
    forgets = stays == goes
    changes = goes & ~stays
    steps = np.arange(len(half)).reshape(-1, *[1] * (half.ndim - 1))
    last = np.maximum.accumulate(np.where(forgets, steps, -1), axis=0)
    swaps = np.cumsum(changes, axis=0)
    since: NDArray[np.int64] = swaps - np.where(
        last >= 0, np.take_along_axis(swaps, np.maximum(last, 0), 0), 0
    )
    anchor = np.where(
        last >= 0,
        np.where(np.take_along_axis(stays, np.maximum(last, 0), 0), 1.0, -1.0),
        kept_signs[:1],
    )
    return np.reshape(np.where(since % 2 == 0, anchor, -anchor), shape)


def sign_of(branch: str, name: str) -> float:
    """Return +1 for 'up' and -1 for 'down', or say that the argument ``name`` is neither."""
    if branch not in _SIGNS:
        raise ParameterError(name, branch, "'up' or 'down'")
    return _SIGNS[branch]


def first_of(wrong: NDArray[np.bool_]) -> tuple[int | tuple[int, ...] | None, tuple[int, ...]]:
    """Find the first posture that is wrong: what people are told, and its index."""
    where = tuple(int(n) for n in np.unravel_index(int(np.argmax(wrong)), wrong.shape))
    return (where if len(where) > 1 else where[0] if where else None), where


def unit(angle: Array) -> Points:
    """Return e^(j angle), faster than the complex exponential."""
    result = np.empty(np.shape(angle), dtype=complex)
    result.real, result.imag = np.cos(angle), np.sin(angle)
    return result


def squared_length(point: Points) -> Array:
    """Return the squared absolute value."""
    squared: Array = point.real * point.real + point.imag * point.imag
    return np.asarray(squared)


def argument(point: Points) -> Array:
    """Return the argument in [-pi, pi)."""
    return wrapped(np.arctan2(point.imag, point.real))


def wrapped(angle: Array) -> Array:
    """Wrap angles; most are in range."""
    if ((angle < -np.pi) | (angle >= np.pi)).any():
        return wrap(angle)
    return np.asarray(angle)


def same_shape(points: tuple[ArrayLike, ...], angles: tuple[ArrayLike, ...]) -> tuple[Any, ...]:
    """Bring points, as complex numbers, and angles to their common shape."""
    return np.broadcast_arrays(
        *(np.asarray(point, dtype=complex) for point in points),
        *(np.asarray(angle, dtype=float) for angle in angles),
    )
