"""
Static stability: support polygon and stability margin.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_FIRST, _SECOND = (np.array(ends) for ends in zip(*combinations(range(4), 2)))
"""The six pairs of feet: each is a line of which the polygon may have an edge."""
_OTHERS = np.array([[k for k in range(4) if k not in pair] for pair in combinations(range(4), 2)]).T
"""The two feet that are not in a pair, shape (2, 6)."""

_SAME = 1e-9
"""Feet nearer to one another, or to a line, than this coincide with it [m]."""


def stability_margin(point: Array, feet: Array, in_contact: NDArray[np.bool_]) -> Array:
    """
    Shortest distance from the center of mass to the border of the support polygon.

    The support polygon is the convex hull of the feet on the ground (S0 sec. 4,
    fig. 9). A line through two of them holds one of its edges if it has all others on
    one side. Inside, the margin is the least distance to such a line; outside, it is
    minus the least distance to a segment between two feet, for no segment within the
    polygon is nearer than its border. So it is continuous, also where the polygon
    shrinks to a segment: on two feet, or on feet in a line, it is minus the distance to
    the segment between the outermost.

    Parameters
    ----------
    point : ndarray, shape (..., 2)
        Center of mass projected onto the ground [m].
    feet : ndarray, shape (..., 4, 2)
        The feet, in the same frame [m].
    in_contact : ndarray of bool, shape (..., 4)
        Which feet bear load.

    Returns
    -------
    ndarray, shape (...)
        Margin [m]; negative when the point is outside, minus infinity with fewer than
        two feet down, and never positive with two.
    """
    # Feet and pairs first: the instants then lie side by side in memory.
    x, y = np.moveaxis(feet, (-1, -2), (0, 1)).copy()
    down = np.moveaxis(in_contact, -1, 0)
    start_x, start_y = x[_FIRST], y[_FIRST]
    edge_x, edge_y = x[_SECOND] - start_x, y[_SECOND] - start_y
    arm_x, arm_y = point[..., 0] - start_x, point[..., 1] - start_y
    square = edge_x * edge_x + edge_y * edge_y
    is_pair = down[_FIRST] & down[_SECOND]

    fraction = (edge_x * arm_x + edge_y * arm_y) / np.maximum(square, _SAME * _SAME)
    fraction = np.minimum(np.maximum(fraction, 0.0), 1.0)
    away_x, away_y = arm_x - fraction * edge_x, arm_y - fraction * edge_y
    outside = np.sqrt(np.where(is_pair, away_x * away_x + away_y * away_y, np.inf).min(axis=0))

    length = np.sqrt(square)
    others_left = edge_x * (y[_OTHERS] - start_y) - edge_y * (x[_OTHERS] - start_x)
    tolerance, lifted = _SAME * length, ~down[_OTHERS]
    on_left = ((others_left >= -tolerance) | lifted).all(axis=0)
    on_right = ((others_left <= tolerance) | lifted).all(axis=0)
    # A line with all feet on it has no inside: there the distance is never positive.
    sign = np.where(on_left & on_right, 0.0, np.where(on_left, 1.0, -1.0))
    is_edge = is_pair & (on_left | on_right) & (length > _SAME)
    left = sign * (edge_x * arm_y - edge_y * arm_x) / np.maximum(length, _SAME)
    inside = np.where(is_edge, left, np.inf).min(axis=0)
    margin: Array = np.where((inside > 0.0) & (inside < np.inf), inside, -outside)
    return margin


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
        Corners of the supporting feet's convex hull, counter-clockwise, from the first
        foot that is one [m]. Feet in a line leave the outermost two, feet in one place
        leave one.
    """
    standing: list[int] = np.flatnonzero(in_contact).tolist()
    order = sorted(standing, key=lambda k: (feet[k, 0], feet[k, 1], k))
    # Andrew's monotone chain: below from left to right, above from right to left.
    below, above = _chain(feet, order), _chain(feet, order[::-1])
    corners = below[:-1] + above[:-1] or below
    first = corners.index(min(corners)) if corners else 0
    return feet[corners[first:] + corners[:first]]


def _chain(feet: Array, order: list[int]) -> list[int]:
    """Go through feet in order, dropping those that are not to the right of the path."""
    chain: list[int] = []
    for k in order:
        while chain and _coincide(feet[chain[-1]], feet[k]):
            chain.pop()
        while len(chain) > 1 and not _turns_left(*feet[[*chain[-2:], k]]):
            chain.pop()
        chain.append(k)
    return chain


def _coincide(a: Array, b: Array) -> bool:
    return bool(np.hypot(*(b - a)) <= _SAME)


def _turns_left(a: Array, b: Array, c: Array) -> bool:
    """Return whether b lies to the right of the line from a to c."""
    (x, y), (u, v) = c - a, b - a
    return bool(u * y - v * x > _SAME * np.hypot(x, y))
