"""
Parts of ``quadwalk bench fleet``: several robots in one world, without topics.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_lab.fleet.fleet_walk import FleetRecord, FleetWalk, Member
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.fleet_maps import corridor, warehouse
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import AUTO, ENGINES, resolved

SEEDS, QUICK_SEEDS = 20, 1
"""Walks of each kind."""

KINDS = ('a1', 'cuhk', 'titan_viii', 'genibo')
"""Robots that exchange the corners."""

NUMBERS, QUICK_NUMBERS = (1, 2, 4, 8, 16), (1, 2)
"""Numbers of robots whose speed is measured."""

_TIMEOUT = {'warehouse': 900.0, 'corridor': 300.0}
"""Time in which all have to arrive [s], simulated."""

_LANE = 1.5
"""Distance between robots whose speed is measured [m]."""

_MEASURED = 4.0
"""Simulated time over which speed is measured [s]."""


def warehouse_walk(seed: int, backend: str) -> FleetRecord:
    """
    Have four robots exchange the corners of a warehouse.

    Parameters
    ----------
    seed : int
        Of who begins where, where each goes, and how it stands at first.
    backend : str
        One of :data:`quad_sim.engines.registry.ENGINES`.
    """
    rng = np.random.default_rng((seed, 1))
    grid, corners = warehouse()
    kinds, shift = rng.permutation(KINDS), int(rng.integers(1, 4))
    members = {}
    for index, corner in enumerate(corners):
        goal = corners[(index + shift) % len(corners)]
        start = Pose2D(corner.x, corner.y, float(rng.uniform(-math.pi, math.pi)))
        members[f'robot{index + 1}'] = Member(str(kinds[index]), start, goal)
    return _walked(members, grid, backend, _TIMEOUT['warehouse'])


def corridor_walk(seed: int, backend: str) -> FleetRecord:
    """Have two robots meet in a corridor; arguments as of :func:`warehouse_walk`."""
    rng = np.random.default_rng((seed, 2))
    grid, left, right = corridor(length=float(rng.uniform(2.5, 4.5)))
    aside = rng.uniform(-0.4, 0.4, 2)
    left = Pose2D(left.x + float(rng.uniform(-0.4, 0.4)), left.y + float(aside[0]), 0.0)
    right = Pose2D(right.x + float(rng.uniform(-0.4, 0.4)), right.y + float(aside[1]), math.pi)
    first, second = rng.permutation(('a1', 'cuhk', 'a1')).tolist()[:2]
    members = {
        'robot1': Member(first, left, Pose2D(right.x, right.y, 0.0)),
        'robot2': Member(second, right, Pose2D(left.x, left.y, math.pi)),
    }
    return _walked(members, grid, backend, _TIMEOUT['corridor'])


def _walked(
    members: Mapping[str, Member], grid: OccupancyGrid, backend: str, timeout: float
) -> FleetRecord:
    fleet = FleetWalk(members, grid, backend)
    try:
        return fleet.run(timeout)
    finally:
        fleet.close()


def walks(
    part: str, console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, Any]]:
    """Walk through the warehouse, or the corridor, with many seeds; see ``measure``."""
    walk = {'warehouse': warehouse_walk, 'corridor': corridor_walk}[part]
    what = {
        'warehouse': 'four robots that exchanged the corners of a warehouse',
        'corridor': 'two robots that met in a corridor, and arrived',
    }[part]
    seeds = range(seed, seed + (QUICK_SEEDS if quick else SEEDS))
    backend = resolved(AUTO)
    records = []
    with worker_pool() as pool:
        for number, record in zip(seeds, pool.map(walk, seeds, [backend] * len(seeds))):
            records.append(record)
            verdict = 'all arrived' if not record.said else f'WRONG: {record.said}'
            touched = f', CONTACTS: {sorted(record.contacts)}' if record.contacts else ''
            console.print(
                f'{part} {number}: {verdict} after {record.duration:.0f} s{touched}',
                highlight=False,
            )
    count = len(records)
    bars = [
        at_least(what, sum(not r.said for r in records), f'of {count}', count),
        at_most(f'walks with a contact ({part})', sum(bool(r.contacts) for r in records), '', 0),
        figure(f'longest time until all arrived ({part})', max(r.duration for r in records), 's'),
        figure(f'least gap between two robots ({part})', min(r.least_gap for r in records), 'm'),
    ]
    details = [
        asdict(r) | {'contacts': sorted(r.contacts), 'waits': sorted(r.waits)} for r in records
    ]
    return bars, {part: details}


def speeds(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, Any]]:
    """
    Time walking robots in one world, with physics, gaits and planners, in every engine.

    What counts is the processor's time of this thread, as in ``quadwalk bench engines``.
    """
    bars: list[Criterion] = []
    details: dict[str, Any] = {}
    engines = [name for name, one in ENGINES.items() if one.has_world and one.is_installed]
    for backend in engines:
        for number in QUICK_NUMBERS if quick else NUMBERS:
            spent = _time_lanes(number, backend)
            total = sum(spent.values())
            speed = _MEASURED / total
            name = f'speed of {number} robots in one world, {backend}'
            is_bar = number == 8 and backend == 'mujoco'
            unit = 'times real time'
            bars.append(at_least(name, speed, unit, 1.0) if is_bar else figure(name, speed, unit))
            parts = ', '.join(f'{100 * part / total:.0f} % {what}' for what, part in spent.items())
            console.print(f'{name}: {speed:.1f} times real time ({parts})', highlight=False)
            details[f'{backend} {number}'] = spent
    return bars, {'speed': details}


def _time_lanes(number: int, backend: str) -> dict[str, float]:
    """Return the processor's time of each part of robots that walk in lanes [s]."""
    cells = np.zeros((round((number + 1) * _LANE / 0.05), 240), np.int8)
    grid = OccupancyGrid(cells, 0.05, Pose2D(0.0, 0.0, 0.0))
    lanes = [_LANE * (index + 1) for index in range(number)]
    members = {
        f'robot{index + 1}': Member('titan_viii', Pose2D(1.0, y, 0.0), Pose2D(11.0, y, 0.0))
        for index, y in enumerate(lanes)
    }
    fleet = FleetWalk(members, grid, backend)
    try:
        # The first steps compile searches, and stand.
        fleet.run(1.0)
        fleet.spent = dict.fromkeys(fleet.spent, 0.0)
        fleet.run(1.0 + _MEASURED)
    finally:
        fleet.close()
    return fleet.spent
