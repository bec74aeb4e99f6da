"""
Where on a height map a robot is, by the heights at which its feet have met the ground.

Haptic localisation (R. Buchanan et al., "Haptic Sequential Monte Carlo Localization for Quadrupedal
Locomotion in Vision-Denied Scenarios", IROS 2020) with a search in place of particles: the drift of
the last few strides is nearly one shift along the ground. Of all shifts within reach the one is
taken at which the map fits the felt heights best, up to one height that is common to all.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap

Array = NDArray[np.float64]

_FEWEST = 6
"""Places that must be on known ground."""

_FIRM = 0.6
"""A shift must make the misfit smaller than this fraction of what it is."""

_GAIN = 0.25
"""And by so much, in tolerances: a pebble under one foot is no reason to move a map."""

_NEAR = 0.25
"""What the farthest shift costs, in tolerances: level ground fits everywhere."""


MOST_STEPS = 12
"""Number of steps to the farthest shift, however fine the cells are."""


class Fit(NamedTuple):
    """How a map fits what was felt."""

    shift: Array
    """Distance from a place as odometry has it to where it is on the map, shape (2,) [m]."""
    misfit: float
    """Mean difference of heights, each counted up to a bound [m]."""


def misfits(heights: HeightMap, felt: Array, shifts: Array, most: float) -> Array:
    """
    Return by how much a map differs from what was felt.

    Parameters
    ----------
    heights : HeightMap
        The map.
    felt : ndarray, shape (n, 3)
        Places at which feet met the ground; heights relative to any level [m].
    shifts : ndarray, shape (m, 2)
        Shifts to try [m].
    most : float
        A difference counts as so much at most: feet stand on edges [m].

    Returns
    -------
    ndarray, shape (m,)
        Mean difference up to the median; infinite where too few places are known [m].
    """
    off = felt[:, 2] - heights.height_at(felt[:, :2] + shifts[:, None])
    known = np.isfinite(off)
    enough = known.sum(axis=1) >= min(_FEWEST, len(felt))
    off = np.where(enough[:, None], off, 0.0)
    off -= np.nanmedian(off, axis=1, keepdims=True)
    difference = np.minimum(np.abs(np.nan_to_num(off, nan=most / 2.0)), most)
    mean: Array = difference.mean(axis=1)
    return np.where(enough, mean, math.inf)


def registered(
    heights: HeightMap, felt: Array, now: Array, reach: float, tolerance: float
) -> Fit | None:
    """
    Find the shift at which a map fits what was felt.

    Parameters
    ----------
    heights : HeightMap
        The map.
    felt : ndarray, shape (n, 3)
        Places at which feet met the ground; heights relative to any level [m].
    now : ndarray, shape (2,)
        Shift that is in force [m].
    reach : float
        Distance from it up to which others are tried [m].
    tolerance : float
        Mean difference that a map which fits may have at most [m].

    Returns
    -------
    Fit or None
        None where no shift fits clearly better than the one in force.
    """
    if len(felt) < _FEWEST:
        return None
    side = max(heights.resolution, reach / MOST_STEPS)
    count = math.ceil(reach / side)
    steps = np.arange(-count, count + 1) * side
    moves = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    away = np.hypot(*moves.T)
    moves, away = moves[away <= reach + 1e-9], away[away <= reach + 1e-9]
    cost = misfits(heights, felt, now + moves, 4.0 * tolerance)
    own = float(cost[int(np.argmin(away))])
    # Where several fit alike, the nearest one.
    best = int(np.argmin(cost + _NEAR * tolerance * away / reach))
    if cost[best] > min(tolerance, _FIRM * own, own - _GAIN * tolerance):
        return None
    return Fit(now + moves[best], float(cost[best]))
