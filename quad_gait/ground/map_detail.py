"""
How much detail of a height map the feet of a robot need.
"""

from __future__ import annotations

from quad_common.maps.height_map import MAX_REACH, HeightMap
from quad_common.maps.height_map_parts import thinned
from quad_common.robot.robot import Robot

_PER_FOOT = 6.0
"""Number of cells in the radius of a foot that are enough."""

_FARTHEST = 0.18
"""Radius of what is looked at around a place at most [m, of TITAN-VIII]."""


def as_feet_need(height_map: HeightMap, robot: Robot) -> HeightMap:
    """
    Return a height map with cells no smaller than the feet of a robot need.

    What is looked at around each foot takes the more time the smaller the cells are: a map of
    1 mm would keep the robot from answering for seconds.

    Parameters
    ----------
    height_map : HeightMap
        The map.
    robot : Robot
        The robot.

    Returns
    -------
    HeightMap
        The map itself if its cells are large enough.
    """
    least = max(robot.foot_radius / _PER_FOOT, 2.0 * robot.relative_size * _FARTHEST / MAX_REACH)
    return thinned(height_map, least)
