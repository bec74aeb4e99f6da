"""
The maps on which benchmarks walk and plan.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from quad_common.resources import sample_map

OTHERS_MAPS = ('depot', 'warehouse')
"""Nav2's maps, looked for in the folder that QUADWALK_MAPS names, or beside the project."""


def maps_of_others() -> Path:
    """Return the folder for maps that others made; it need not exist."""
    beside = Path(__file__).resolve().parents[3] / 'shared' / 'maps'
    return Path(os.environ.get('QUADWALK_MAPS', beside))


def benchmark_maps() -> list[Path]:
    """List the maps to walk on: the samples, and those of others that are there."""
    maps = [sample_map('room'), sample_map('office')]
    folder = maps_of_others()
    for name in OTHERS_MAPS:
        found = sorted(folder.glob(f'**/{name}.yaml'))
        maps += found[:1]
    return maps


@dataclass(frozen=True)
class Problem:
    """A search on a map of cells, and the length that is published for it."""

    start: tuple[int, int]
    """x and y of a cell."""
    goal: tuple[int, int]
    length: float
    """Of a shortest path that cuts no corner [cells]; 0 says that there is none."""

    def is_right(self, length: float | None) -> bool:
        """Return whether a length, or None, is the published one, as far as it is printed."""
        return abs((length or 0.0) - self.length) <= 0.01 + 1e-5 * self.length


def scenario_files() -> list[Path]:
    """List the scenario files of MovingAI's benchmark that are there; each beside its map."""
    return sorted(maps_of_others().rglob('*.scen'))


def load_scenario(path: Path) -> tuple[NDArray[np.bool_], list[Problem]]:
    """
    Read a scenario file and its map.

    Parameters
    ----------
    path : Path
        `some.map.scen`, beside `some.map`.

    Returns
    -------
    tuple
        The free cells, shape (height, width), and the problems.
    """
    lines = path.with_suffix('').read_text(encoding='utf-8').splitlines()
    height, width = int(lines[1].split()[1]), int(lines[2].split()[1])
    free = np.array([[cell in '.G' for cell in line[:width]] for line in lines[4 : 4 + height]])
    problems = []
    for fields in map(str.split, path.read_text(encoding='utf-8').splitlines()[1:]):
        if fields:
            x, y, u, v = map(int, fields[4:8])
            problems.append(Problem((x, y), (u, v), float(fields[8])))
    return free, problems
