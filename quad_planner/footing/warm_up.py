"""
Gets the compiled loops of this room ready, before there is a height map.
"""

from __future__ import annotations

import numpy as np

from quad_planner.footing.foothold_lattice import BINS
from quad_planner.footing.footing import FootedRobot
from quad_planner.footing.nearest_footholds import find_free, find_nearest, sample_heights
from quad_planner.footing.stances import Footholds, find_unfit
from quad_planner.outline.heading_kernels import STEP


def warm_up(footed: FootedRobot) -> None:
    """
    Call each loop once, with arrays of the kinds that height maps lead to.

    A height map would do it as well, but for that libraries are loaded that nothing else needs.

    Parameters
    ----------
    footed : FootedRobot
        The robot, whose tables are made.
    """
    side, places = 0.1, np.arange(4, dtype=np.float64) + 0.5
    level, heights = np.zeros((4, 4)), np.empty((4, 4))
    # As those of height maps.
    level.flags.writeable = False
    sample_heights(level, places, places, heights)
    shins = np.zeros((4 * BINS, 1, 3))
    cells, free = np.full((1, 2), 1.5), np.empty(1, dtype=np.uint64)
    find_free(cells, np.zeros(1), np.zeros((4, 4, 4)), shins, free)
    fit = np.full(level.shape, free[0])
    nearest = np.empty((4 * BINS, *level.shape), dtype=np.int32)
    offsets = np.zeros((1, 2), dtype=np.int64)
    find_nearest(fit, np.arange(level.size), offsets, nearest)
    ground = Footholds(nearest.reshape(BINS, 4, *level.shape), heights, 0.0, 0.0, side)
    looked_at = np.array([[1, 1, 1]], dtype=np.int64)
    layers = np.zeros((1, 4, 1), dtype=np.uint64)
    headings, centers = STEP * np.arange(1, dtype=np.float64), side * cells
    find_unfit(ground, footed.legs, headings, looked_at, centers, layers)
