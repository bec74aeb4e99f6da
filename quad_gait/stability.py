"""
Static stability: support polygon and stability margin.
"""

from __future__ import annotations

from itertools import permutations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def stability_margin(point: Array, feet: Array, in_contact: NDArray[np.bool_]) -> Array:
    """
    Shortest distance from the centre of mass to the edges of the support polygon.

    The support polygon is the convex hull of the feet on the ground. Of the twelve
    directed lines between two feet, its edges are those with every other supporting
    foot on their left; the margin is the least distance to the left of any of them
    (S0 sec. 4, fig. 9).

    Parameters
    ----------
    point : ndarray, shape (..., 2)
        Centre of mass projected onto the ground [m].
    feet : ndarray, shape (..., 4, 2)
        The feet, in the same frame [m].
    in_contact : ndarray of bool, shape (..., 4)
        Which feet bear load.

    Returns
    -------
    ndarray, shape (...)
        Margin [m]; negative when the point is outside, minus infinity with fewer
        than two feet down, and never positive with two.
    """
    margin = np.full(point.shape[:-1], np.inf)
    for i, j in permutations(range(4), 2):
        edge = feet[..., j, :] - feet[..., i, :]
        length = np.maximum(np.hypot(edge[..., 0], edge[..., 1]), 1e-9)
        is_edge = in_contact[..., i] & in_contact[..., j]
        for k in range(4):
            if k not in (i, j):
                left = _cross(edge, feet[..., k, :] - feet[..., i, :]) >= -1e-12
                is_edge = is_edge & (left | ~in_contact[..., k])
        distance = _cross(edge, point - feet[..., i, :]) / length
        margin = np.where(is_edge, np.minimum(margin, distance), margin)
    return np.where(np.isinf(margin), -np.inf, margin)


def support_polygon(feet: Array, in_contact: NDArray[np.bool_]) -> Array:
    """
    List the corners of the support polygon.

    Parameters
    ----------
    feet : ndarray, shape (4, 2)
        The feet [m].
    in_contact : ndarray of bool, shape (4,)
        Which feet bear load.

    Returns
    -------
    ndarray, shape (n, 2)
        The supporting feet, counter-clockwise around their middle [m].
    """
    standing = feet[in_contact]
    if len(standing) < 3:
        return standing
    arms = standing - standing.mean(axis=0)
    return standing[np.argsort(np.arctan2(arms[:, 1], arms[:, 0]))]


def _cross(a: Array, b: Array) -> Array:
    result: Array = a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
    return result
