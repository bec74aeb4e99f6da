"""
Part of ``quadwalk bench planner``: plans that are equal to those of searches which look at all.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import islice

import numpy as np

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_lab.benchmarks.planning.plain_searches import (
    least_cycles_over_cells,
    least_cycles_over_points,
    path_over_whole_mesh,
)
from quad_lab.benchmarks.planning.small_requests import (
    RESOLUTION,
    WalkRequest,
    random_meshes,
    random_requests,
)
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_planner.any_angle.corner_search import quickest_corners
from quad_planner.any_angle.free_space import FreeSpace
from quad_planner.any_angle.rectangles import corners_of
from quad_planner.grid.bit_grid import BitGrid, BitMask
from quad_planner.search.mesh_search import mesh_path
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.wave.wave_search import quickest_path

_REQUESTS = 1000
_BOUND = 500
"""Cycles that no path on so small a map takes."""
_SMALLEST = 18
"""Side of the maps on which all corners are joined to all [cells]."""


def equality_bars(quick: bool, seed: int) -> list[Criterion]:
    """
    Compare plans with those of plain searches, on small random maps.

    Parameters
    ----------
    quick : bool
        Few requests.
    seed : int
        Of the maps and requests.

    Returns
    -------
    list of Criterion
        For each method how many plans differ.
    """
    count = _REQUESTS // 20 if quick else _REQUESTS
    drawn = random_meshes(seed, count)
    meshes = [mesh_path(*asked) == path_over_whole_mesh(*asked) for asked in drawn]
    requests = list(random_requests(seed, count))
    cells = [_cycles_over_cells(asked) == least_cycles_over_cells(asked) for asked in requests]
    compared = (_is_least_at_any_angle(asked) for asked in random_requests(seed, 10 * count))
    corners = list(islice((equal for equal in compared if equal is not None), count))
    bars = []
    for name, equal in (
        ('mesh', meshes),
        ('quickest', cells),
        ('quickest, any angle', corners),
    ):
        bars.append(figure(f'{name}: requests compared with a plain search', len(equal), ''))
        bars.append(at_most(f'{name}: plans that differ', equal.count(False), 'plans', 0))
    return bars


def _terms(request: WalkRequest) -> WalkTerms:
    return WalkTerms(request.pace, RESOLUTION, request.start_yaw, request.goal_yaw, _BOUND)


def _cycles_over_cells(request: WalkRequest) -> int | None:
    """Return the cycles of the quickest path over cells; None without one."""
    path = quickest_path(BitGrid.of(request.free), request.start, request.goal, _terms(request))
    return None if path is None else path.cycles


def _is_least_at_any_angle(request: WalkRequest) -> bool | None:
    """Return whether a path takes as few cycles as any over corners; None if there is no path."""
    free = request.free[:_SMALLEST, :_SMALLEST]
    height, width = free.shape
    if any(x >= width or y >= height for x, y in (request.start, request.goal)):
        return None
    request = request._replace(free=free)
    known = quickest_path(BitGrid.of(free), request.start, request.goal, _terms(request))
    if known is None:
        return None
    forbidden = BitMask.of(~free)
    space = FreeSpace.outside(forbidden)
    points = np.vstack(([request.start, request.goal], known.cells[1:-1])) + 0.5
    everywhere = np.vstack((points, np.unique(corners_of(space.rectangles), axis=0)))
    least = least_cycles_over_points(forbidden, everywhere, request)
    terms = replace(_terms(request), bound=known.cycles + 1)
    path = quickest_corners(space, forbidden, points, terms)
    if path is None:
        return False
    places = path * RESOLUTION
    start = Pose2D(float(places[0, 0]), float(places[0, 1]), request.start_yaw)
    return request.pace.cycles(start, Plan.through(places, request.goal_yaw)) == least
