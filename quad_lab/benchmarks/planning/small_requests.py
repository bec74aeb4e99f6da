"""
Requests on small random maps, on which plain searches can look at everything.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.robot_files.walking_time import WalkingTimeModel
from quad_planner.grid.bit_grid import BitMask
from quad_planner.methods.mesh_moves import mesh_moves
from quad_planner.search.mesh_search import Ends, Legs, Mesh

RESOLUTION = 0.05
"""Side of a cell [m]."""

STRAIGHT, DIAGONAL = 500_000, 707_107
"""Lengths along a mesh [um]."""


class WalkRequest(NamedTuple):
    """Two cells of a map, headings, and a pace."""

    free: NDArray[np.bool_]
    """Free cells, shape (height, width)."""
    start: tuple[int, int]
    """Cell of the start, x and y."""
    goal: tuple[int, int]
    """Cell of the goal, x and y."""
    start_yaw: float
    """Heading at the start [rad]."""
    goal_yaw: float
    """Heading at the goal [rad]."""
    pace: WalkingTimeModel
    """Pace of the gait."""


def random_requests(seed: int, count: int) -> Iterator[WalkRequest]:
    """Draw small maps with two free cells, headings and paces."""
    rng = np.random.default_rng(seed)
    while count:
        height, width = rng.integers(4, 26, 2)
        free = rng.random((height, width)) >= rng.choice([0.0, 0.1, 0.2, 0.3, 0.4])
        cells = np.argwhere(free)[:, ::-1]
        if len(cells) < 2:
            continue
        ends = cells[rng.choice(len(cells), 2, replace=False)].tolist()
        pace = WalkingTimeModel(
            cycle_period=1.0,
            stride=float(rng.choice([0.2261, 0.07, 0.439, 0.1])),
            turn=math.radians(rng.choice([44.2, 30.0, 56.0, 91.0])),
            stopping=float(rng.choice([0.0, 0.0, 0.7])),
        )
        start_yaw, goal_yaw = rng.uniform(-math.pi, math.pi, 2).tolist()
        start, goal = ((end[0], end[1]) for end in ends)
        yield WalkRequest(free, start, goal, start_yaw, goal_yaw, pace)
        count -= 1


def random_meshes(seed: int, count: int) -> Iterator[tuple[Mesh, Ends]]:
    """Draw meshes over small maps, with segments from a start and to a goal."""
    rng = np.random.default_rng(seed)
    while count:
        free = rng.random(tuple(rng.integers(4, 40, 2))) >= rng.choice([0.0, 0.03, 0.1])
        spacing = float(rng.choice([1.0, 2.5, 3.3]))
        columns, rows = (int(n / spacing) + 1 for n in free.shape[::-1])
        candidates, exits = mesh_moves(BitMask.of(~free), spacing, (0, rows), columns)
        crossings = np.flatnonzero(candidates)
        if len(crossings) < 2:
            continue
        direct = int(rng.choice([-1, -1, 2 * STRAIGHT, 0]))
        ends = Ends(
            _random_legs(rng, crossings),
            _random_legs(rng, crossings),
            direct,
            1600 if direct > 0 else -1,
            tuple(rng.choice([0, 800, 77, 1600], 2).tolist()),
        )
        yield Mesh(exits, STRAIGHT, DIAGONAL), ends
        count -= 1


def _random_legs(rng: np.random.Generator, crossings: NDArray[np.int64]) -> Legs:
    """Join some crossings, now and then at no length, and along the mesh or not."""
    picked = np.sort(rng.choice(crossings, min(len(crossings), 4), replace=False))
    lengths = rng.integers(0, 3, len(picked)) * STRAIGHT // 2
    bearings = rng.choice([0, 800, 1600, 4000, 123, 5600], len(picked))
    return Legs(picked, lengths, np.where(lengths == 0, -1, bearings))
