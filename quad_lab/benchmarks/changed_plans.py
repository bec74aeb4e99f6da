"""
Part of ``quadwalk bench fleet``: robots whose plans change in mid-walk, as traffic changes them.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from functools import partial
from typing import Any

from rich.console import Console

from quad_common.robot_files.robot_file import available_robots
from quad_lab.seeded_walks.changing_plans import ChangedWalk, walk_changing_plans
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import AUTO, ENGINES, resolved

WALKS, QUICK_WALKS = 50, 2
"""Walks of each robot."""


def replans(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, Any]]:
    """Walk every robot that ships with plans that change at any moment; see ``measure``."""
    backend = resolved(AUTO)
    seeds = range(seed, seed + (QUICK_WALKS if quick else WALKS))
    bars: list[Criterion] = []
    details: dict[str, Any] = {}
    with worker_pool() as pool:
        for robot in available_robots() if ENGINES[backend].has_world else ():
            done: list[ChangedWalk] = list(
                pool.map(partial(walk_changing_plans, robot, backend=backend), seeds)
            )
            fallen = sum(walk.fell_at is not None for walk in done)
            tilt = math.degrees(max(walk.largest_tilt for walk in done))
            what = f'{robot}, trot, plans that change'
            bars.append(at_most(f'falls of {len(done)} ({what})', fallen, '', 0))
            bars.append(figure(f'largest tilt ({what})', tilt, 'degrees'))
            console.print(f'{what}: {fallen} of {len(done)} fell, tilt {tilt:.1f} degrees')
            details[f'replans {robot}'] = [asdict(walk) for walk in done]
    return bars, details
