"""
``quadwalk bench faults``: the attack on nodes, files and commands, as a benchmark.
"""

from __future__ import annotations

import importlib
from dataclasses import replace

from rich.console import Console

from quad_lab.tools.criterion import Criterion

PARTS = {
    'messages': 'quad_lab.attacks.messages.message_attack.attack_messages',
    'processes': 'quad_lab.attacks.processes.process_attack.attack_processes',
    'gate': 'quad_lab.attacks.walks.gate_attack.attack_gate',
    'silence': 'quad_lab.attacks.walks.silence.attack_by_silence',
    'files': 'quad_lab.attacks.files.file_attack.measure_files',
    'watch': 'quad_lab.attacks.walks.busy_machine.attack_by_load',
    'kills': 'quad_lab.attacks.walks.kills.attack_by_kills',
    'soak': 'quad_lab.attacks.walks.soak.soak',
    'localisation': 'quad_lab.attacks.walks.drift.attack_by_drift',
}
"""What is attacked, by the name for ``--only``: the function of each part."""


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
    bars: list[Criterion] = []
    details: dict[str, object] = {'quick': quick, 'seed': seed}
    for name, function in PARTS.items():
        if only and name not in only:
            continue
        console.rule(name)
        # Only what is run is imported: some parts need ROS, and some do not.
        module, _, attack = function.rpartition('.')
        part_bars, part_details = getattr(importlib.import_module(module), attack)(
            console, quick, seed
        )
        bars += [replace(bar, name=f'{name}: {bar.name}') for bar in part_bars]
        details[name] = part_details
    return bars, details
