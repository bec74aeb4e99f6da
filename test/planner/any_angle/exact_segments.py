"""Segments over allowed cells, piece by piece: slow, and plain to see."""

import math

import numpy as np

_EPSILON = 1e-6


def points_allowed(allowed, points):
    """Return which points, shape (..., 2), lie in an allowed cell or on its edge."""
    last = np.array(allowed.shape[::-1]) - 1
    low = np.clip(np.floor(points - _EPSILON).astype(np.intp), 0, last)
    high = np.clip(np.floor(points + _EPSILON).astype(np.intp), 0, last)
    return (
        allowed[low[..., 1], low[..., 0]]
        | allowed[low[..., 1], high[..., 0]]
        | allowed[high[..., 1], low[..., 0]]
        | allowed[high[..., 1], high[..., 0]]
    )


def segments_allowed(allowed, starts, step):
    """Return which segments from starts, shape (n, 2), by a step stay in allowed cells."""
    cuts = [np.zeros((len(starts), 1)), np.ones((len(starts), 1))]
    for axis in (0, 1):
        if step[axis] != 0.0:
            first = np.floor(np.minimum(starts[:, axis], starts[:, axis] + step[axis]))
            lines = first[:, None] + np.arange(1, math.ceil(abs(step[axis])) + 1)
            cuts.append(np.clip((lines - starts[:, axis, None]) / step[axis], 0.0, 1.0))
    t = np.sort(np.concatenate(cuts, axis=1), axis=1)
    midpoints = starts[:, None] + 0.5 * (t[:, 1:] + t[:, :-1])[..., None] * step
    # A piece of no length is where the segment touches a corner: the next piece decides.
    touches = np.diff(t, axis=1) * np.abs(step).max() < _EPSILON
    return (touches | points_allowed(allowed, midpoints)).all(axis=1)
