"""
Part of ``quadwalk bench planner``: fields over whole maps, and descents of potentials.
"""

from __future__ import annotations

import importlib
import importlib.util
import time
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import NoPathFound
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_lab.tools.criterion import Criterion, at_least, figure
from quad_planner.methods.potential_planner import PotentialPlanner
from quad_planner.methods.shortest_planner import ShortestPlanner
from quad_planner.potential.map_potential import boundary_distances
from quad_planner.potential.navigation_field import slowness_near_obstacles, travel_times
from quad_planner.search.cell_steps import DIAGONAL, STRAIGHT
from quad_planner.search.distance_field import distance_field

Mask = NDArray[np.bool_]
MakeMap = Callable[[int, int], Mask]

_TIMES = 7
"""The best of so many is taken, for others share the machine."""

_FLOOR = 10.0
"""Side of the floor with circles, as in S1 part V.A [m]."""
_RESOLUTION = 0.05
"""[m]"""
_CLEARANCE = 0.3
"""[m]"""


def field_bars(makes: Mapping[str, MakeMap], quick: bool, seed: int) -> list[Criterion]:
    """
    Time fields, and count which descents arrive.

    Parameters
    ----------
    makes : mapping
        How maps are made, by name: of a size and a seed, to occupied cells.
    quick : bool
        Smaller maps.
    seed : int
        Of the maps.

    Returns
    -------
    list of Criterion
        What was measured.
    """
    bars = []
    for kind, make in makes.items():
        bars += _distance_bars(kind, make, 512 if quick else 1024, seed)
    if not quick:
        allowed = ~makes['streets'](4096, seed)
        took, _ = _best(lambda: distance_field(allowed, _start(allowed)), 3)
        bars.append(figure('streets 4096: distances of all cells', 1e3 * took, 'ms'))
    return bars + _descent_bars(40 if quick else 100, seed)


def circles(rng: np.random.Generator, with_pocket: bool) -> OccupancyGrid:
    """Draw twelve round obstacles on a floor; with a pocket, seven of them make a U."""
    places = rng.uniform(1.5, _FLOOR - 1.5, (12, 2))
    radii = rng.uniform(0.25, 0.45, 12)
    if with_pocket:
        y = rng.uniform(3.0, 7.0)
        places[:3] = [(6.0, y + 0.7 * k) for k in (-1, 0, 1)]
        places[3:7] = [(x, y + side) for x in (5.4, 6.0) for side in (-1.4, 1.4)]
    size = round(_FLOOR / _RESOLUTION)
    rows, columns = (np.indices((size, size)) + 0.5) * _RESOLUTION
    cells = np.zeros((size, size), dtype=np.int8)
    for (x, y), radius in zip(places, radii):
        cells[np.hypot(columns - x, rows - y) <= radius] = 100
    return OccupancyGrid(cells, _RESOLUTION, Pose2D(0.0, 0.0, 0.0))


def _distance_bars(kind: str, make: MakeMap, size: int, seed: int) -> list[Criterion]:
    """Time the fields from one cell to all, and the same by SciPy on a graph that is given."""
    occupied = make(size, seed)
    allowed = ~occupied
    x, y = _start(allowed)
    distance_field(allowed, (x, y))
    took, lengths = _best(lambda: distance_field(allowed, (x, y)), _TIMES)
    name = f'{kind} {size}'
    bars = [figure(f'{name}: distances of all cells', 1e3 * took, 'ms')]
    if importlib.util.find_spec('scipy') is not None:
        csgraph: Any = importlib.import_module('scipy.sparse.csgraph')

        graph = _graph(allowed)
        peer, found = _best(lambda: csgraph.dijkstra(graph, indices=y * size + x), 2)
        whole = np.where(np.isfinite(found), found, -1.0).astype(np.int64).reshape(lengths.shape)
        wrong = int((whole != lengths).sum())
        bars.append(
            at_least(f'{name}: csgraph.dijkstra, graph given', peer / took, 'x as long', 20.0)
        )
        bars.append(at_least(f'{name}: right distances', 100.0 * (wrong == 0), '%', 100.0))
    blocked = OccupancyGrid(
        np.where(occupied, 100, 0).astype(np.int8), _RESOLUTION, Pose2D(0.0, 0.0, 0.0)
    )
    safety = ShortestPlanner(clearance_radius=_CLEARANCE).inflated_map(blocked)
    distances = boundary_distances(safety.blocked_bits, _CLEARANCE, _RESOLUTION)
    slowness = slowness_near_obstacles(distances, safety.forbidden, 1.5)
    goal = _start(safety.allowed)
    travel_times(slowness, goal)
    took, _ = _best(lambda: travel_times(slowness, goal), 3)
    return [*bars, figure(f'{name}: navigation function of all cells', 1e3 * took, 'ms')]


def _descent_bars(count: int, seed: int) -> list[Criterion]:
    """Count which descents arrive among circles, where there is a path."""
    planners = {
        name: PotentialPlanner(clearance_radius=_CLEARANCE, potential=name)
        for name in ('paper', 'navigation')
    }
    shortest = ShortestPlanner(clearance_radius=_CLEARANCE)
    arrived: dict[tuple[str, bool], int] = {}
    solvable = {False: 0, True: 0}
    times = []
    rng = np.random.default_rng(seed)
    start, goal = Pose2D(0.5, 5.0, 0.0), Pose2D(9.5, 5.2, 0.0)
    for k in range(count):
        with_pocket = k % 2 == 1
        grid = circles(rng, with_pocket)
        if not _arrives(shortest, grid, start, goal):
            continue
        solvable[with_pocket] += 1
        for name, planner in planners.items():
            began = time.perf_counter()
            arrived.setdefault((name, with_pocket), 0)
            arrived[name, with_pocket] += _arrives(planner, grid, start, goal)
            if name == 'navigation':
                times.append(time.perf_counter() - began)
    all_solvable = max(sum(solvable.values()), 1)
    navigated = arrived['navigation', False] + arrived['navigation', True]
    return [
        figure(
            "S1's descent arrives, twelve circles at random",
            100.0 * arrived['paper', False] / max(solvable[False], 1),
            '%',
        ),
        figure(
            "S1's descent arrives, with a U",
            100.0 * arrived['paper', True] / max(solvable[True], 1),
            '%',
        ),
        at_least(
            'the navigation function leads to the goal',
            100.0 * navigated / all_solvable,
            '%',
            100.0,
        ),
        figure('a plan by the navigation function', 1e3 * float(np.median(times)), 'ms'),
    ]


def _arrives(method: Any, grid: OccupancyGrid, start: Pose2D, goal: Pose2D) -> bool:
    try:
        method.plan(method.prepare(grid), start, goal)
    except NoPathFound:
        return False
    return True


def _start(allowed: Mask) -> tuple[int, int]:
    """Return an allowed cell, x and y."""
    rows, columns = np.nonzero(allowed)
    return int(columns[len(rows) // 3]), int(rows[len(rows) // 3])


def _best(work: Callable[[], Any], times: int) -> tuple[float, Any]:
    """Return the shortest of some times, and what came of it."""
    best = float('inf')
    result = None
    for _ in range(times):
        began = time.perf_counter()
        result = work()
        best = min(best, time.perf_counter() - began)
    return best, result


def _graph(allowed: Mask) -> Any:
    """Join each allowed cell to its neighbours, with no corner cut, as SciPy wants it."""
    from scipy.sparse import coo_array

    height, width = allowed.shape
    numbers = np.arange(height * width, dtype=np.int32).reshape(allowed.shape)
    froms, tos, lengths = [], [], []
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        rows, left, right = slice(0, height - dy), max(-dx, 0), width - max(dx, 0)
        here = (rows, slice(left, right))
        there = (slice(dy, height), slice(left + dx, right + dx))
        may = allowed[here] & allowed[there]
        if dy and dx:
            may &= allowed[rows, left + dx : right + dx] & allowed[dy:height, left:right]
        froms.append(numbers[here][may])
        tos.append(numbers[there][may])
        lengths.append(np.full(may.sum(), float(DIAGONAL if dx and dy else STRAIGHT)))
    a, b, weights = (np.concatenate(parts) for parts in (froms, tos, lengths))
    size = height * width
    return coo_array(
        (np.tile(weights, 2), (np.concatenate((a, b)), np.concatenate((b, a)))), shape=(size, size)
    ).tocsr()
