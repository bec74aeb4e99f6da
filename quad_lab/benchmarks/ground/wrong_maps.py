"""
Height maps as real ones are: shifted, with holes, for a robot whose odometry drifts; or none.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_lab.closed_loop.ground_walk import Knowledge, Scene
from quad_sim.simulated_localisation import LocalisationOptions

FAULTS = ('shifted', 'holes', 'none')
"""What is wrong with a map; odometry drifts with each."""

_SHIFT = 0.02
"""Distance by which a shifted map is off along x, y and z [m, of TITAN-VIII]."""

_DRIFT = 0.03
"""Drift of odometry, which nothing corrects [1]."""

_HOLE, _UNKNOWN = 0.12, 0.2
"""Radius of holes [m, of TITAN-VIII], and fraction of the ground that they cover."""


def faulty_knowledge(robot: Robot, scene: Scene, fault: str) -> Knowledge:
    """
    Spoil what a robot knows of a scene.

    Parameters
    ----------
    robot : Robot
        The robot; lengths are in proportion to it.
    scene : Scene
        The scene; its seed decides on signs, holes and drift.
    fault : str
        One of :data:`FAULTS`.

    Returns
    -------
    Knowledge
    """
    rng = np.random.default_rng((scene.seed, FAULTS.index(fault)))
    localisation = LocalisationOptions(drift=_DRIFT, seed=scene.seed)
    heights: HeightMap | None = scene.height_map
    if fault == 'shifted':
        heights = shifted(scene.height_map, robot.relative_size * _SHIFT, rng)
    elif fault == 'holes':
        heights = with_holes(scene.height_map, robot.relative_size * _HOLE, rng)
    else:
        heights = None
    return Knowledge(heights, localisation)


def shifted(heights: HeightMap, distance: float, rng: np.random.Generator) -> HeightMap:
    """Return a map that is off by a distance along x, y and z, each to one side or the other."""
    dx, dy, dz = (distance * rng.choice((-1.0, 1.0), 3)).tolist()
    x, y = heights.origin
    return HeightMap(heights.heights + dz, heights.resolution, (x + dx, y + dy))


def with_holes(heights: HeightMap, radius: float, rng: np.random.Generator) -> HeightMap:
    """Return a map that lacks discs of a radius [m], a fifth of its ground altogether."""
    x_min, y_min, x_max, y_max = heights.bounds
    area = (x_max - x_min) * (y_max - y_min)
    # Discs that overlap cover less: each leaves the same part of what the others left.
    count = math.ceil(-math.log(1.0 - _UNKNOWN) * area / (math.pi * radius * radius))
    holes = rng.uniform((x_min, y_min), (x_max, y_max), (count, 2))
    known = heights.heights.copy()
    centers = heights.centers
    for hole in holes:
        known[np.hypot(*np.moveaxis(centers - hole, -1, 0)) < radius] = math.nan
    return heights.with_heights(known)
