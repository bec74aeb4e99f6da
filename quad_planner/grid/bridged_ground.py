"""
The ground as a robot finds it that goes from foothold to foothold: narrow gaps are bridged.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.maps.height_map import HeightMap
from quad_planner.grid.array_types import Mask
from quad_planner.grid.ground_limits import GroundLimits


def bridged(heights: HeightMap, limits: GroundLimits) -> HeightMap:
    """
    Fill what no foot can stand on, where it is narrow.

    A gap between places on which feet can stand is filled if no disc as wide as the largest gap
    fits into it (a morphological closing): each of its cells receives the height of the nearest
    such place. Steps between these places remain.

    Parameters
    ----------
    heights : HeightMap
        The ground.
    limits : GroundLimits
        Limits of the robot.

    Returns
    -------
    HeightMap
        The same one, if no gaps are bridged.
    """
    if not limits.largest_gap > 0.0:
        return heights
    # Imported late, as only a height map needs it: it takes a good part of a node's start.
    from scipy import ndimage

    side = heights.resolution
    rough = heights.steps(limits.foothold_radius)
    fit: Mask = np.isfinite(heights.heights) & (rough <= limits.foothold_step)
    if fit.all() or not fit.any():
        return heights
    # A foothold begins a radius behind the edge, and cells are as wide as they are.
    reach = 0.5 * limits.largest_gap + limits.foothold_radius + side
    margin = math.ceil(reach / side) + 1
    away, nearest = ndimage.distance_transform_edt(~fit, return_indices=True)
    near = np.pad(side * away <= reach, margin, mode='edge')
    inner = side * ndimage.distance_transform_edt(near)[margin:-margin, margin:-margin]
    filled = ~fit & np.isfinite(heights.heights) & (inner > reach)
    if not filled.any():
        return heights
    bridged_heights = heights.heights.copy()
    bridged_heights[filled] = heights.heights[tuple(nearest)][filled]
    return heights.with_heights(bridged_heights)
