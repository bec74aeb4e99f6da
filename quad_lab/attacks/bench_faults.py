"""
``quadwalk bench faults``: the attack on nodes, files and commands, as a benchmark.
"""

from __future__ import annotations

from dataclasses import replace

from rich.console import Console

from quad_lab.attacks.parts import PARTS, attack_of
from quad_lab.attacks.quick_faults import attack_quickly
from quad_lab.tools.criterion import Criterion

__all__ = ['PARTS', 'measure']


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = ()
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Attack, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A small sample of every part.
    seed : int
        Of what is drawn at random.
    only : tuple of str
        Parts to run; all if empty.

    Returns
    -------
    tuple
        The bars of all parts, and details for JSON by part.
    """
    parts = [part for part in PARTS if part in (only or PARTS)]
    results = {}
    if quick:
        results = attack_quickly(console, parts, seed)
    else:
        for part in parts:
            console.rule(part)
            results[part] = attack_of(part)(console, quick, seed)
    bars: list[Criterion] = []
    details: dict[str, object] = {'quick': quick, 'seed': seed}
    for part in parts:
        part_bars, details[part] = results[part]
        bars += [replace(bar, name=f'{part}: {bar.name}') for bar in part_bars]
    return bars, details
