"""
The ground as a robot finds it that goes from foothold to foothold: narrow gaps are bridged.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.maps.height_map import HeightMap
from quad_planner.grid.cell_overlap import EPSILON


def bridged(heights: HeightMap, largest_gap: float) -> HeightMap:
    """
    Fill gaps that are narrow.

    This is the closing of mathematical morphology by a disc: where no disc as wide as the largest
    gap fits between higher ground, the gap is filled up to it. Steps, and whatever stands on the
    ground, stay as they are.

    Parameters
    ----------
    heights : HeightMap
        The ground; what is unknown bounds no gap, and remains unknown.
    largest_gap : float
        Width of the widest gap that is filled; 0 for none [m].

    Returns
    -------
    HeightMap
        The same one, if no gaps are filled.
    """
    reach = 0.5 * largest_gap / heights.resolution
    if reach < 1.0:
        return heights
    # Imported late, as only a height map needs it: it takes a good part of a node's start.
    from scipy import ndimage

    cells = np.arange(-math.floor(reach + EPSILON), math.floor(reach + EPSILON) + 1)
    disc = np.hypot(cells[:, None], cells) <= reach + EPSILON
    known = ~np.isnan(heights.heights)
    ground = np.where(known, heights.heights, -math.inf)
    highest = ndimage.maximum_filter(ground, footprint=disc, mode='nearest')
    closed = ndimage.minimum_filter(highest, footprint=disc, mode='nearest')
    return heights.with_heights(np.where(known, np.maximum(closed, ground), math.nan))
