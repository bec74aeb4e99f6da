"""
The maps on which benchmarks walk and plan.
"""

from __future__ import annotations

import os
from pathlib import Path

from quad_common.resources import sample_map

OTHERS_MAPS = ('depot', 'warehouse')
"""Nav2's maps, looked for in the folder that QUADWALK_MAPS names, or beside the project."""


def benchmark_maps() -> list[Path]:
    """List the maps to walk on: the samples, and those of others that are there."""
    maps = [sample_map('room'), sample_map('office')]
    beside = Path(__file__).resolve().parents[2] / 'shared' / 'maps' / 'ros'
    folder = Path(os.environ.get('QUADWALK_MAPS', beside))
    for name in OTHERS_MAPS:
        found = sorted(folder.glob(f'**/{name}.yaml'))
        maps += found[:1]
    return maps
