"""
Distances between line segments, and between line segments and a box: exact, for many at once.

A capsule is a segment with a radius around it, so these are distances between capsules as well.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_PARALLEL = 1e-12
"""Squared sine of the angle below which two segments count as parallel."""

_TINY = 1e-30
"""Least squared length of a segment: points are segments too [m^2]."""


def distance_between_segments(first: Array, second: Array) -> Array:
    """
    Measure the least distance between segments.

    Either an end of one of them is nearest to the other, or both are nearest at inner
    points, where the connection is normal to both.

    Parameters
    ----------
    first, second : ndarray, shape (..., 2, 3)
        Both ends of each segment, which may coincide [m].

    Returns
    -------
    ndarray, shape (...)
        Distances, 0 where segments cross [m].
    """
    p, q = first[..., 0, :], second[..., 0, :]
    u, v, w = first[..., 1, :] - p, second[..., 1, :] - q, p - q
    uu, vv, uv = _dot(u, u), _dot(v, v), _dot(u, v)
    uw, vw, ww = _dot(u, w), _dot(v, w), _dot(w, w)

    def squared(s: Array, t: Array) -> Array:
        """Square of the distance between p + s u and q + t v."""
        return ww + s * s * uu + t * t * vv + 2.0 * (s * uw - t * vw - s * t * uv)

    zero, one = np.zeros_like(uu), np.ones_like(uu)
    along_u, along_v = np.maximum(uu, _TINY), np.maximum(vv, _TINY)
    candidates = [
        squared(zero, _fraction(vw / along_v)),
        squared(one, _fraction((vw + uv) / along_v)),
        squared(_fraction(-uw / along_u), zero),
        squared(_fraction((uv - uw) / along_u), one),
    ]
    determinant = uu * vv - uv * uv
    crosses = determinant > _PARALLEL * uu * vv
    safe = np.where(crosses, determinant, 1.0)
    s, t = (uv * vw - vv * uw) / safe, (uu * vw - uv * uw) / safe
    inside = crosses & (s > 0.0) & (s < 1.0) & (t > 0.0) & (t < 1.0)
    candidates.append(np.where(inside, squared(s, t), np.inf))
    nearest = np.minimum.reduce(candidates)
    distance: Array = np.sqrt(np.maximum(nearest, 0.0))
    return distance


def distance_to_box(segments: Array, half_size: Array) -> Array:
    """
    Measure the least distance from segments to a box around the origin, along the axes.

    With p(t) a point of the segment, the squared distance is the sum over the axes of
    max(|p_i(t)| - h_i, 0)^2. That is convex, and its slope is linear between the places
    where the segment passes a plane of the box, so the least one is found exactly.

    Parameters
    ----------
    segments : ndarray, shape (..., 2, 3)
        Both ends of each segment, in the box's frame [m].
    half_size : ndarray, shape (3,)
        Half of the box's length, width and height [m].

    Returns
    -------
    ndarray, shape (...)
        Distances, 0 where a segment reaches into the box [m].
    """
    p = segments[..., 0, :]
    u = segments[..., 1, :] - p
    moving = np.where(np.abs(u) > 1e-15, u, np.inf)
    passes = np.concatenate([(half_size - p) / moving, (-half_size - p) / moving], axis=-1)
    ends = np.broadcast_to([0.0, 1.0], (*p.shape[:-1], 2))
    t = np.sort(np.concatenate([_fraction(passes), ends], axis=-1), axis=-1)
    at = p[..., None, :] + t[..., None] * u[..., None, :]
    outside = np.sign(at) * np.maximum(np.abs(at) - half_size, 0.0)
    slope = (outside * u[..., None, :]).sum(axis=-1)
    # The last place where it still falls, and the first one where it does not.
    last = np.maximum((slope < 0.0).sum(axis=-1) - 1, 0)[..., None]
    after = np.minimum(last + 1, t.shape[-1] - 1)
    t0, t1 = np.take_along_axis(t, last, -1), np.take_along_axis(t, after, -1)
    f0, f1 = np.take_along_axis(slope, last, -1), np.take_along_axis(slope, after, -1)
    falls = (f0 < 0.0) & (f1 > 0.0)
    fraction = np.where(falls, f0 / np.where(falls, f0 - f1, 1.0), np.where(f0 < 0.0, 1.0, 0.0))
    nearest = p + (t0 + fraction * (t1 - t0)) * u
    distance: Array = np.linalg.norm(np.maximum(np.abs(nearest) - half_size, 0.0), axis=-1)
    return distance


def _dot(a: Array, b: Array) -> Array:
    product: Array = np.einsum('...i,...i->...', a, b)
    return product


def _fraction(values: Array) -> Array:
    fraction: Array = np.minimum(np.maximum(values, 0.0), 1.0)
    return fraction
