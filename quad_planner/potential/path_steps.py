"""
A path cut into steps of one length, as S1's robot takes them.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled
from quad_common.errors import ParameterError

Array = NDArray[np.float64]


def steps_along(points: Array, length: float) -> tuple[Array, Array]:
    """
    Cut a path into steps of one length, with a heading each (S1 part IV.A).

    Parameters
    ----------
    points : array_like, shape (n, 2)
        The path, n >= 1 [m].
    length : float
        S1's r: how far a step's end is from its beginning, > 0 [m].

    Returns
    -------
    ends : ndarray, shape (m + 1, 2)
        Ends of the steps; the last step is shorter [m].
    headings : ndarray, shape (m,)
        S1's beta, from the x axis counterclockwise [rad].

    Raises
    ------
    ParameterError
        If the length is not positive.
    """
    if not 0.0 < length < np.inf:
        raise ParameterError('length', length, 'positive and finite')
    ends = _cut(np.asarray(points, dtype=float).reshape(-1, 2), float(length))
    steps = np.diff(ends, axis=0)
    return ends, np.arctan2(steps[:, 1], steps[:, 0])


@compiled
def _cut(path: Array, length: float) -> Array:
    """Return where the steps begin and end."""
    pieces = np.hypot(path[1:, 0] - path[:-1, 0], path[1:, 1] - path[:-1, 1])
    ends = np.empty((int(pieces.sum() / length) + len(path) + 2, 2))
    x, y = path[0]
    ends[0] = x, y
    count, k = 1, 1
    while k < len(path):
        # The first point of the path that is a step away, along this piece of it.
        ax, ay = path[k - 1, 0] - x, path[k - 1, 1] - y
        bx, by = path[k, 0] - x, path[k, 1] - y
        if np.hypot(bx, by) < length * (1.0 - 1e-12):
            k += 1
            continue
        px, py = bx - ax, by - ay
        square = px * px + py * py
        middle = -(ax * px + ay * py) / square
        half = np.sqrt(max(middle * middle - (ax * ax + ay * ay - length * length) / square, 0.0))
        along = min(middle + half, 1.0)
        x, y = x + ax + along * px, y + ay + along * py
        ends[count] = x, y
        count += 1
    if np.hypot(path[-1, 0] - x, path[-1, 1] - y) > 1e-9 * length:
        ends[count] = path[-1]
        count += 1
    return ends[:count]
