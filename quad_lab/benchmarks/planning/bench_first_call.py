"""
Part of ``quadwalk bench planner``: how long the first plan of a start of Python takes.
"""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from rich.console import Console
from rich.table import Table

from quad_common.process.temporary_folder import temporary_folder
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_lab.tools.workers import end_with_parent

_METHODS = {
    'mesh': ('mesh', False),
    'shortest': ('shortest', False),
    'shortest, any angle': ('shortest', True),
    'quickest': ('quickest', False),
    'quickest, any angle': ('quickest', True),
    'potential': ('potential', False),
}
"""Names, and of each the method and whether it takes any angle."""

_LONGEST_COMPILING = 10.0
"""Of the slowest method, after an installation [s]."""
_LONGEST_START = 1.5
"""From a start of Python to the first plan, ever after [s]."""

_ROUNDS, _LATER = 2, 3
"""So many first starts, and later ones after each: the quickest counts, in busy company."""

_TIMEOUT = 300.0
"""[s]"""

_FIRST_PLAN = """
import sys
import time
began = time.perf_counter()
from quad_common.maps.map_file import load_map
from quad_common.robot_files.walking_time import load_pace
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_planner.methods.planner import make_planner
robot = load_robot('titan_viii')
planner = make_planner(
    sys.argv[1],
    any_angle=sys.argv[2] == 'True',
    mesh_size=robot.mesh_size,
    clearance_radius=robot.standing_radius + 0.12,
    pace=load_pace('titan_viii', 'crawl'),
    potential='either',
)
planner.set_map(load_map(sample_map()))
planner.plan(Pose2D(1.2, 1.2, 0.0), Pose2D(6.8, 4.8, 1.57))
print(time.perf_counter() - began)
"""


@dataclass(frozen=True)
class _Starts:
    """From a start of Python to the first plan of a method."""

    first: float
    """After an installation [s]."""
    later: float
    """With what was compiled then [s]."""

    @property
    def compiling(self) -> float:
        """How much longer the first one took [s]."""
        return self.first - self.later


def first_call_times(console: Console, quick: bool) -> list[Criterion]:
    """
    Measure first plans, of each method with a cache of its own for what is compiled.

    Parameters
    ----------
    console : Console
        Where the table goes.
    quick : bool
        Measure `shortest` alone.

    Returns
    -------
    list of Criterion
        How long the methods compile after an installation, and how long they take from a
        later start of Python to the first plan.
    """
    names = ['shortest'] if quick else list(_METHODS)
    rounds = 1 if quick else _ROUNDS
    starts = {name: _starts(*_METHODS[name], rounds) for name in names}
    table = Table('method', 'first start [s]', 'later starts [s]', 'compiling [s]')
    for name, times in starts.items():
        table.add_row(name, *(f'{t:.2f}' for t in (times.first, times.later, times.compiling)))
    console.print(table)
    bars = [figure(f'{name}: compiling', times.compiling, 's') for name, times in starts.items()]
    compiling = max(times.compiling for times in starts.values())
    later = max(times.later for times in starts.values())
    return [
        *bars,
        at_most('the slowest method: compiling', compiling, 's', _LONGEST_COMPILING),
        at_most('the slowest method: a later start to the first plan', later, 's', _LONGEST_START),
    ]


def _starts(method: str, any_angle: bool, rounds: int) -> _Starts:
    """Measure a method with an empty cache, and with what it then holds."""
    firsts, laters = [], []
    for _ in range(rounds):
        with temporary_folder() as folder:
            cache = str(folder)
            firsts.append(_first_plan(method, any_angle, cache))
            laters += [_first_plan(method, any_angle, cache) for _ in range(_LATER)]
    return _Starts(min(firsts), min(laters))


def _first_plan(method: str, any_angle: bool, cache: str) -> float:
    """Start a new Python for one plan; return all the time up to it [s]."""
    result = subprocess.run(
        [sys.executable, '-c', _FIRST_PLAN, method, str(any_angle)],
        capture_output=True,
        text=True,
        check=True,
        timeout=_TIMEOUT,
        cwd=Path(__file__).parents[3],
        env={**os.environ, 'NUMBA_CACHE_DIR': cache},
        preexec_fn=end_with_parent,
    )
    return float(result.stdout)
