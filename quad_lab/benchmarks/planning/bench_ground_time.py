"""
Part of ``quadwalk bench planner``: how much longer walks take over rough and over sloping ground.

What the planner's costs of ground (:class:`quad_planner.costs.cell_costs.GroundCost`) are to be
compared with: by the gait for uneven ground, with the height map, in physics.
"""

from __future__ import annotations

import numpy as np
from rich.console import Console
from rich.table import Table

from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.terrain_walk import LENGTH, make_course, walk_course
from quad_lab.tools.criterion import Criterion, figure
from quad_lab.tools.workers import worker_pool

_ROBOT = 'titan_viii'

_GROUNDS = {
    'level': 'bumps:height=0.0001',
    'bumps of 20 mm': 'bumps:height=0.02',
    'bumps of 40 mm': 'bumps:height=0.04',
    'bumps of 60 mm': 'bumps:height=0.06',
    'across a slope of 4 degrees': 'cross_slope:angle=0.07',
    'across a slope of 8 degrees': 'cross_slope:angle=0.14',
    'across a slope of 12 degrees': 'cross_slope:angle=0.21',
    'up and down 10 degrees': 'slope:angle=0.1745,length=1.2',
}

_QUICK = ('level', 'bumps of 40 mm')


def ground_time_figures(console: Console, quick: bool, seed: int) -> list[Criterion]:
    """
    Walk straight on over ground of each kind.

    Parameters
    ----------
    console : Console
        Where the table goes.
    quick : bool
        Walk over two kinds only.
    seed : int
        Of the ground, and of the direction in which it is crossed.

    Returns
    -------
    list of Criterion
        For each kind the walking time over that on level ground: no bars.
    """
    names = _QUICK if quick else tuple(_GROUNDS)
    with worker_pool() as pool:
        taken = dict(zip(names, pool.map(_walked, names, [seed] * len(names))))
    table = Table('ground', f'time for {LENGTH:g} m [s]', 'over that on level ground')
    figures = []
    for name, seconds in taken.items():
        ratio = seconds / taken['level']
        table.add_row(name, f'{seconds:.1f}', f'{ratio:.3f}')
        arrived = float(ratio) if np.isfinite(ratio) else None
        figures.append(figure(f'{_ROBOT}, {name}: walking time', arrived, 'x level ground'))
    console.print(table)
    return figures


def _walked(name: str, seed: int) -> float:
    """Return how long a walk took [s], NaN if it did not arrive."""
    robot = load_robot(_ROBOT)
    outcome = walk_course(robot, make_course(robot, _GROUNDS[name], seed))
    return outcome.duration if outcome.arrived else float('nan')
