"""
Bad luck with odometry: it drifts, and a localiser corrects it by leaps and with noise.
"""

from __future__ import annotations

from rich.console import Console

from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks import bench_localisation
from quad_lab.benchmarks.bench_walk import draw_pairs
from quad_lab.tools.benchmark_maps import benchmark_maps
from quad_lab.tools.criterion import Criterion

QUICK_LENGTH = 0.7
"""Longest path of the one walk of the quick sample [m]."""

_ROBOT = 'titan_viii'


def attack_by_drift(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk by drifting odometry, and work out the bars of ``quadwalk bench localisation``.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        One short walk, without topics: the other parts take their time as well.
    seed : int
        Of the poses, the drift and the noise.

    Returns
    -------
    tuple
        The bars, and details for JSON: every walk's figures.
    """
    if not quick:
        return bench_localisation.measure(console, quick, seed)
    pairs = draw_pairs(load_robot(_ROBOT), benchmark_maps(), 1, QUICK_LENGTH, seed)
    records = bench_localisation.measure_drift(console, pairs, seed)
    return bench_localisation.bars_of(records, []), {
        'walks': [bench_localisation.as_dict(record) for record in records]
    }
