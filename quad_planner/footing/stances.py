"""
Loop over cells and headings: whether all four legs find a foothold there, and reach it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled, inlined_part

Array = NDArray[np.float64]
Bits = NDArray[np.uint64]

_ONE = np.uint64(1)


class Footholds(NamedTuple):
    """Footholds on a lattice of places, as compiled code is given them."""

    nearest: NDArray[np.int32]
    """
    Index of the foothold nearest to each place, shape (bins, 4, rows, columns): the place itself
    where the ground is not known, -1 where there is none within reach.
    """
    heights: Array
    """Height of each place, shape (rows, columns); NaN where it is not known [m]."""
    x: float
    """Lower left corner of the lattice [m]."""
    y: float
    """The same along y [m]."""
    side: float
    """Distance between places [m]."""


class Legs(NamedTuple):
    """What legs reach, as :class:`~quad_common.footing.leg_room.LegRoom` says."""

    neutral: Array
    """Feet in the initial posture, body frame, shape (4, 3) [m]."""
    lowest: Array
    """Lowest height of a foot in the body frame, shape (4, n, n) [m]."""
    highest: Array
    """Highest such height, shape (4, n, n) [m]."""
    side: float
    """Side of a cell of these tables [m]."""
    raised: float
    """Distance by which the body may be higher than in the initial posture, negative [m]."""
    lowered: float
    """Distance by which it may be lower [m]."""
    tilts: Array
    """Fractions of the ground's tilt that the body may take."""


@inlined_part
def _bear(legs: Legs, feet: Array) -> bool:
    """
    Tell whether legs reach four footholds at some posture of the body.

    Parameters
    ----------
    legs : Legs
        What they reach.
    feet : ndarray, shape (4, 5)
        Place of each foot from the body, x and y, its height, and the lowest and the highest
        height that the leg reaches there [m].
    """
    x = y = z = 0.0
    for leg in range(4):
        x += 0.25 * feet[leg, 0]
        y += 0.25 * feet[leg, 1]
        z += 0.25 * feet[leg, 2]
    along = across = length = width = 0.0
    for leg in range(4):
        u, v, w = feet[leg, 0] - x, feet[leg, 1] - y, feet[leg, 2] - z
        along += u * w
        across += v * w
        length += u * u
        width += v * v
    along /= max(length, 1e-9)
    across /= max(width, 1e-9)
    for k in range(len(legs.tilts)):
        low, high = legs.raised, legs.lowered
        for leg in range(4):
            tilted = along * (feet[leg, 0] - x) + across * (feet[leg, 1] - y)
            above = feet[leg, 2] - z - legs.tilts[k] * tilted + legs.neutral[leg, 2]
            low = max(low, feet[leg, 3] - above)
            high = min(high, feet[leg, 4] - above)
        if low <= high:
            return True
    return False


@inlined_part
def _stands(
    ground: Footholds,
    legs: Legs,
    pose: tuple[float, float, float, float, bool],
    bin_: int,
    feet: Array,
) -> bool:
    """
    Tell whether there are footholds at a pose: x, y, cosine and sine of its heading.

    The last value tells whether legs may not reach every foothold; `feet` is written on.
    """
    x, y, c, s, is_uneven = pose
    rows, columns = ground.heights.shape
    size = legs.lowest.shape[1]
    half = 0.5 * size
    is_known = True
    for leg in range(4):
        u, v = legs.neutral[leg, 0], legs.neutral[leg, 1]
        column = math.floor((x + c * u - s * v - ground.x) / ground.side)
        row = math.floor((y + s * u + c * v - ground.y) / ground.side)
        if column < 0 or row < 0 or column >= columns or row >= rows:
            is_known = False
            continue
        at = ground.nearest[bin_, leg, row, column]
        if at < 0:
            return False
        if not is_uneven:
            continue
        row, column = at // columns, at % columns
        height = ground.heights[row, column]
        if math.isnan(height):
            is_known = False
            continue
        du = ground.x + (column + 0.5) * ground.side - x
        dv = ground.y + (row + 0.5) * ground.side - y
        feet[leg, 0], feet[leg, 1], feet[leg, 2] = c * du + s * dv, c * dv - s * du, height
        i = math.floor((feet[leg, 0] - u) / legs.side + half)
        j = math.floor((feet[leg, 1] - v) / legs.side + half)
        if i < 0 or j < 0 or i >= size or j >= size:
            return False
        feet[leg, 3], feet[leg, 4] = legs.lowest[leg, i, j], legs.highest[leg, i, j]
    # Of what is not known nothing bad is supposed, as everywhere in the planner.
    return not is_uneven or not is_known or _bear(legs, feet)


@compiled
def find_unfit(
    ground: Footholds,
    legs: Legs,
    headings: Array,
    cells: NDArray[np.int64],
    centers: Array,
    layers: Bits,
) -> None:
    """
    Mark the headings at which the robot finds no footholds.

    Parameters
    ----------
    ground : Footholds
        Footholds nearby.
    legs : Legs
        What the legs reach.
    headings : ndarray, shape (m,)
        Heading of each class [rad].
    cells : ndarray, shape (n, 3)
        Rows and columns of the cells to look at, and whether heights around them differ so much
        that legs may not reach every foothold.
    centers : ndarray, shape (n, 2)
        Their centers [m].
    layers : ndarray of uint64, shape (m, height, words)
        A bit is set where a class finds none.
    """
    bins = ground.nearest.shape[0]
    feet = np.zeros((4, 5))
    for k in range(len(headings)):
        c, s = math.cos(headings[k]), math.sin(headings[k])
        bin_ = int(np.floor(headings[k] / (2.0 * math.pi) * bins + 0.5)) % bins
        for n in range(len(cells)):
            pose = (centers[n, 0], centers[n, 1], c, s, cells[n, 2] > 0)
            if not _stands(ground, legs, pose, bin_, feet):
                row, column = cells[n, 0], cells[n, 1]
                layers[k, row, column >> 6] |= _ONE << np.uint64(column & 63)
