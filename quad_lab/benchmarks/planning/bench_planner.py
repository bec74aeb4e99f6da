"""
``quadwalk bench planner``: shortest paths on large maps, beside other libraries.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table
from scipy.ndimage import distance_transform_edt

from quad_common.errors import PlannerError
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_lab.benchmarks.planning.bench_equality import equality_bars
from quad_lab.benchmarks.planning.bench_fields import field_bars
from quad_lab.benchmarks.planning.bench_first_call import first_call_times
from quad_lab.benchmarks.planning.bench_footprint import footprint_bars
from quad_lab.benchmarks.planning.bench_ground_time import ground_time_figures
from quad_lab.benchmarks.planning.bench_quickest import walking_bars
from quad_lab.benchmarks.planning.bench_searches import scenario_bars, search_bars
from quad_lab.benchmarks.planning.bench_worst_case import worst_case_bars
from quad_lab.benchmarks.planning.planner_peers import available_peers
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import end_with_parent
from quad_planner.grid.inflation import inflate
from quad_planner.methods.shortest_planner import ShortestPlanner

Mask = NDArray[np.bool_]

PARTS = ('peers', 'searches', 'equality', 'worst', 'footprint', 'start', 'node', 'walks', 'ground')
"""Parts that can be run alone."""

_RADIUS = 8.0
"""That the robot keeps from occupied cells [cells]."""
_RESOLUTION = 0.05
"""[m]"""

_ENOUGH = 0.5
"""What took less is measured again, for others share the machine [s]."""
_ROUNDS = 15
"""Work that takes less is done so often at most: the shortest time counts, for all alike."""

_ONE_PLAN = """
import pathlib
import sys
import numpy as np
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_planner.methods.shortest_planner import ShortestPlanner
planner = ShortestPlanner(clearance_radius=0.4)
size = int(sys.argv[1])
grid = OccupancyGrid(np.zeros((size, size), dtype=np.int8), 0.05, Pose2D(0.0, 0.0, 0.0))
planner.plan(planner.prepare(grid), Pose2D(1.0, 1.0, 0.0), Pose2D(4.0, 4.0, 0.0))
status = pathlib.Path('/proc/self/status').read_text()
print(status.split('VmHWM:')[1].split()[0])
"""


def streets(size: int, seed: int) -> Mask:
    """Draw blocks of houses between streets of several widths, with yards and gaps."""
    rng = np.random.default_rng(seed)
    occupied = np.zeros((size, size), dtype=np.bool_)
    corners = np.cumsum(rng.integers(90, 180, 2 * size // 100))
    edges = [0, *corners[corners < size - 40].tolist(), size]
    for top, bottom in pairwise(edges):
        for left, right in pairwise(edges):
            if rng.random() < 0.12:
                continue
            gap = rng.integers(10, 30, 4)
            occupied[top + gap[0] : bottom - gap[1], left + gap[2] : right - gap[3]] = True
            if rng.random() < 0.5:
                rows = slice(top + 45, bottom - 45)
                # A yard, open to the right.
                occupied[rows, left + 40 : right] = False
    return occupied


def noise(size: int, seed: int) -> Mask:
    """Scatter small boxes: the bad case of jump point search."""
    rng = np.random.default_rng(seed)
    occupied = np.zeros((size, size), dtype=np.bool_)
    for _ in range(size * size // 2500):
        y, x = rng.integers(0, size - 4, 2)
        occupied[y : y + rng.integers(1, 5), x : x + rng.integers(1, 5)] = True
    return occupied


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = PARTS
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Time whole requests: inflation, search and turning points, from the occupied cells.

    Parameters
    ----------
    console : Console
        Where progress and tables go.
    quick : bool
        Smaller maps, fewer requests.
    seed : int
        Of the maps and of what is drawn on them.
    only : tuple of str
        Parts to run, of `PARTS`.

    Returns
    -------
    tuple
        The bars, and details for JSON.
    """
    largest = 512 if quick else 4096
    makes = {'streets': streets, 'noise': noise}
    bars: list[Criterion] = []
    details: dict[str, object] = {'quick': quick, 'seed': seed}
    if 'peers' in only:
        part, details['ratios'] = _peer_bars(console, quick, seed)
        bars += part
    if 'searches' in only:
        bars += field_bars(makes, quick, seed) + search_bars(makes, quick, seed)
        bars += scenario_bars(quick)
    if 'equality' in only:
        bars += equality_bars(quick, seed)
    if 'worst' in only:
        bars += worst_case_bars(console, quick, seed)
    if 'footprint' in only:
        part, plans = footprint_bars(console, quick, seed)
        bars += part
        details.update(plans)
    if 'start' in only:
        bars += first_call_times(console, quick)
        memory = _memory_of_a_plan(largest)
        bars.append(at_most(f'memory of a plan on a map of {largest}', memory, 'MiB', 512.0))
    if 'node' in only:
        bars += _node_bars(largest, seed)
    if 'walks' in only:
        part, walks = walking_bars(console, quick, seed)
        bars += part
        details.update(walks)
    if 'ground' in only:
        bars += ground_time_figures(console, quick, seed)
    return bars, details


def _peer_bars(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], list[dict[str, object]]]:
    """Time ourselves beside other libraries; return ratios for JSON, too."""
    sizes = (512,) if quick else (1024, 4096)
    requests = 4 if quick else 8
    bars: list[Criterion] = []
    table = Table('map', 'who', 'median [ms]', 'times as long', 'mean length, of ours')
    noted: list[dict[str, object]] = []
    for kind, make in (('streets', streets), ('noise', noise)):
        for size in sizes:
            occupied = make(size, seed)
            name = f'{kind} {size}'
            ours, peers = _compare(occupied, requests if size < 4096 else 3, seed, size >= 4096)
            table.add_row(name, 'quadwalk, shortest', f'{1e3 * ours:.2f}', '', '')
            for peer, (seconds, length) in peers.items():
                ratio = seconds / ours
                table.add_row(
                    name, peer, f'{1e3 * seconds:.1f}', f'{ratio:.0f}', f'{100.0 * length:.1f} %'
                )
                noted.append({'map': name, 'peer': peer, 'ratio': ratio, 'length': length})
                bars.append(_bar(f'{name}: {peer}', ratio, peer, kind == 'streets' and not quick))
            bars.append(figure(f'{name}: a whole request', 1e3 * ours, 'ms'))
            bars.append(_inflation_bar(name, occupied))
            console.print(f'{name}: done')
    console.print(table)
    return bars, noted


def _node_bars(size: int, seed: int) -> list[Criterion]:
    """Send a map through the node, if there is ROS."""
    try:
        from quad_lab.benchmarks.planning.bench_planner_node import node_bars
    except ImportError:
        name = f'map of {size} through the node'
        return [at_most(f'{name}, at most', None, 's', 1.0)]
    return node_bars(streets(size, seed))


def _bar(name: str, ratio: float, peer: str, counts: bool) -> Criterion:
    """Make a bar where there is one: on large maps with structure."""
    for library, times in {'pyastar2d': 30.0, 'scipy': 200.0}.items():
        if counts and library in peer:
            return at_least(name, ratio, 'x as long', times)
    return figure(name, ratio, 'x as long')


def _inflation_bar(name: str, occupied: Mask) -> Criterion:
    """Compare the inflation alone with exact distances from SciPy, both giving a mask."""
    grid = _grid(occupied)
    ours, _ = _timed(lambda: inflate(grid, _RADIUS * _RESOLUTION))
    theirs, _ = _timed(lambda: distance_transform_edt(~occupied) < _RADIUS)
    return at_least(f'{name}: inflation by scipy', theirs / ours, 'x as long', 20.0)


def _grid(occupied: Mask) -> OccupancyGrid:
    cells = np.where(occupied, 100, 0).astype(np.int8)
    return OccupancyGrid(cells, _RESOLUTION, Pose2D(0.0, 0.0, 0.0))


def _compare(
    occupied: Mask, requests: int, seed: int, is_large: bool
) -> tuple[float, dict[str, tuple[float, float]]]:
    """Time ourselves and the peers on the same requests: medians, and lengths of ours."""
    planner = ShortestPlanner(clearance_radius=_RADIUS * _RESOLUTION, start_tolerance=0.0)
    grid = _grid(occupied)
    # Two cells farther off, for peers that measure from center to center.
    wide = ShortestPlanner(clearance_radius=(_RADIUS + 2.0) * _RESOLUTION).prepare(grid)
    free = np.argwhere(wide.allowed)[:, ::-1]
    rng = np.random.default_rng(seed)
    pairs: list[tuple[tuple[int, int], tuple[int, int]]] = []
    lengths: list[float] = []
    times: list[float] = []
    while len(pairs) < requests:
        start, goal = (tuple(map(int, free[k])) for k in rng.integers(0, len(free), 2))
        poses = [
            Pose2D((x + 0.5) * _RESOLUTION, (y + 0.5) * _RESOLUTION, 0.0) for x, y in (start, goal)
        ]
        try:
            took, plan = _timed(lambda: planner.plan(planner.prepare(grid), *poses))  # noqa: B023
        except PlannerError:
            continue
        pairs.append(((start[0], start[1]), (goal[0], goal[1])))
        lengths.append(plan.length / _RESOLUTION)
        times.append(took)
    peers = {}
    for name, peer in available_peers().items():
        if is_large and not ('scipy' in name or 'pyastar2d' in name):
            continue
        few = pairs[:1] if is_large and 'scipy' in name else pairs
        taken, ratios = [], []
        for (start, goal), length in zip(few, lengths):
            took, found = _timed(lambda: peer(occupied, _RADIUS, start, goal))  # noqa: B023
            taken.append(took)
            ratios.append(found / length)
        peers[name] = (float(np.median(taken)), float(np.mean(ratios)))
    return float(np.median(times)), peers


def _timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the least time that some work took [s], and its result."""
    times: list[float] = []
    while not times or (sum(times) < _ENOUGH and len(times) < _ROUNDS):
        began = time.perf_counter()
        result = work()
        times.append(time.perf_counter() - began)
    return min(times), result


def _memory_of_a_plan(size: int) -> float:
    """Start a new Python for one plan on a map of a size; return its peak memory [MiB]."""
    result = subprocess.run(
        [sys.executable, '-c', _ONE_PLAN, str(size)],
        capture_output=True,
        text=True,
        check=True,
        cwd=Path(__file__).parents[3],
        preexec_fn=end_with_parent,
    )
    return float(result.stdout) / 1024.0
