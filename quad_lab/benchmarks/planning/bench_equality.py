"""
Part of ``quadwalk bench planner``: plans that are equal to those of searches which look at all.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import islice

import numpy as np
from numpy.typing import NDArray

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_lab.benchmarks.planning.plain_searches import (
    least_cycles_over_cells,
    least_cycles_over_points,
    least_length_over_points,
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
from quad_planner.any_angle.interval_search import any_angle_path
from quad_planner.any_angle.rectangles import corners_of
from quad_planner.grid.bit_grid import BitGrid, BitMask
from quad_planner.search.mesh_search import mesh_path
from quad_planner.search.walk_terms import WalkTerms
from quad_planner.wave.wave_search import quickest_path

_REQUESTS = {
    'mesh': 1000,
    'quickest': 1000,
    'quickest, any angle': 1000,
    'shortest, any angle': 10_000,
}
"""Requests to each method that are compared."""
_QUICK_PART = 20
"""Of how many requests one is compared if few are to be."""
_BOUND = 500
"""Cycles that no path on so small a map takes."""
_ROUNDING = 1e-7
"""Difference of lengths that is rounding [cells]."""
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
    compared: dict[str, Iterator[bool | None]] = {
        'mesh': (
            mesh_path(*asked) == path_over_whole_mesh(*asked)
            for asked in random_meshes(seed, _REQUESTS['mesh'])
        ),
        'quickest': (
            _cycles_over_cells(asked) == least_cycles_over_cells(asked)
            for asked in random_requests(seed, _REQUESTS['quickest'])
        ),
        'quickest, any angle': map(_is_least_at_any_angle, _many_requests(seed)),
        'shortest, any angle': map(_is_shortest_at_any_angle, _many_requests(seed)),
    }
    bars = []
    for name, outcomes in compared.items():
        count = _REQUESTS[name] // _QUICK_PART if quick else _REQUESTS[name]
        equal = list(islice((outcome for outcome in outcomes if outcome is not None), count))
        bars.append(figure(f'{name}: requests compared with a plain search', len(equal), ''))
        bars.append(at_most(f'{name}: plans that differ', equal.count(False), 'plans', 0))
    return bars


def _many_requests(seed: int) -> Iterator[WalkRequest]:
    """Draw requests, more than there are to compare: some have no path."""
    return random_requests(seed, 10 * max(_REQUESTS.values()))


def _terms(request: WalkRequest) -> WalkTerms:
    return WalkTerms(request.pace, RESOLUTION, request.start_yaw, request.goal_yaw, _BOUND)


def _cycles_over_cells(request: WalkRequest) -> int | None:
    """Return the cycles of the quickest path over cells; None without one."""
    path = quickest_path(BitGrid.of(request.free), request.start, request.goal, _terms(request))
    return None if path is None else path.cycles


def _is_least_at_any_angle(request: WalkRequest) -> bool | None:
    """Return whether a path takes as few cycles as any over corners; None if there is no path."""
    free = _small_part(request)
    if free is None:
        return None
    request = request._replace(free=free)
    known = quickest_path(BitGrid.of(free), request.start, request.goal, _terms(request))
    if known is None:
        return None
    forbidden = BitMask.of(~free)
    space = FreeSpace.outside(forbidden)
    points = np.vstack(([request.start, request.goal], known.cells[1:-1])) + 0.5
    everywhere = np.vstack((points, _corners(space)))
    least = least_cycles_over_points(forbidden, everywhere, request)
    terms = replace(_terms(request), bound=known.cycles + 1)
    path = quickest_corners(space, forbidden, points, terms)
    if path is None:
        return False
    places = path * RESOLUTION
    start = Pose2D(float(places[0, 0]), float(places[0, 1]), request.start_yaw)
    return request.pace.cycles(start, Plan.through(places, request.goal_yaw)) == least


def _is_shortest_at_any_angle(request: WalkRequest) -> bool | None:
    """Return whether a path is as short as any over corners; None if there is no path."""
    free = _small_part(request)
    if free is None:
        return None
    forbidden = BitMask.of(~free)
    space = FreeSpace.outside(forbidden)
    # Anywhere in the two cells, by numbers that were drawn for something else.
    angles = np.array([[request.start_yaw], [request.goal_yaw]])
    within = np.hstack((np.cos(angles), np.sin(angles))) / 2.0 + 0.5
    ends = np.array([request.start, request.goal]) + within
    path = any_angle_path(space, *ends)
    least = least_length_over_points(forbidden, np.vstack((ends, _corners(space))))
    if path is None or not np.isfinite(least):
        return None if path is None and not np.isfinite(least) else False
    length = float(np.hypot(*np.diff(path, axis=0).T).sum())
    return abs(length - least) <= _ROUNDING


def _small_part(request: WalkRequest) -> NDArray[np.bool_] | None:
    """Return a part of the map small enough to join all corners; None if it has not both ends."""
    free = request.free[:_SMALLEST, :_SMALLEST]
    height, width = free.shape
    is_inside = all(x < width and y < height for x, y in (request.start, request.goal))
    return free if is_inside else None


def _corners(space: FreeSpace) -> NDArray[np.float64]:
    return np.unique(corners_of(space.rectangles), axis=0)
