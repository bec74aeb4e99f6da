"""
Parts of height maps, and whether two say the same.
"""

from __future__ import annotations

import numpy as np

from quad_common.maps.height_map import HeightMap


def part_within(heights: HeightMap, bounds: tuple[float, float, float, float]) -> HeightMap:
    """
    Return the part of a map within bounds.

    Parameters
    ----------
    heights : HeightMap
        The map.
    bounds : tuple of float
        x_min, y_min, x_max, y_max [m].

    Returns
    -------
    HeightMap
        Its cells that share some area with the bounds; the whole map if none does.
    """
    origin, side = np.array(heights.origin), heights.resolution
    size = heights.columns, heights.rows
    low, high = ((np.array(corner) - origin) / side for corner in (bounds[:2], bounds[2:]))
    first = np.clip(np.floor(low), 0, size).astype(int)
    end = np.clip(np.ceil(high), 0, size).astype(int)
    if (end <= first).any():
        return heights
    x, y = (origin + first * side).tolist()
    return HeightMap(heights.heights[first[1] : end[1], first[0] : end[0]], side, (x, y))


def thinned(heights: HeightMap, least: float) -> HeightMap:
    """
    Return a map with larger cells: of those that it has, every so many.

    Parameters
    ----------
    heights : HeightMap
        The map.
    least : float
        Side of a cell that is small enough [m].

    Returns
    -------
    HeightMap
        With the largest cells that are no larger than that; itself if its own are.
    """
    every = int(least / heights.resolution)
    first = every // 2
    if every < 2 or min(heights.rows, heights.columns) <= first:
        return heights
    side = every * heights.resolution
    x, y = (c + (first + 0.5) * heights.resolution - 0.5 * side for c in heights.origin)
    return HeightMap(heights.heights[first::every, first::every], side, (x, y))


def are_alike(one: HeightMap | None, other: HeightMap | None) -> bool:
    """Return whether two maps say the same."""
    if one is None or other is None:
        return one is other
    return (
        one.origin == other.origin
        and one.resolution == other.resolution
        and np.array_equal(one.heights, other.heights, equal_nan=True)
    )
