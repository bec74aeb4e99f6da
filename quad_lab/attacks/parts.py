"""
The parts of ``quadwalk bench faults``.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable

from rich.console import Console

from quad_lab.tools.criterion import Criterion

Result = tuple[list[Criterion], dict[str, object]]
"""Bars of a part, and details for JSON."""

PARTS = {
    'messages': 'quad_lab.attacks.messages.message_attack.attack_messages',
    'stops': 'quad_lab.attacks.processes.process_attack.attack_nodes',
    'commands': 'quad_lab.attacks.processes.process_attack.attack_demos_and_benches',
    'gate': 'quad_lab.attacks.walks.gate_attack.attack_gate',
    'execution': 'quad_lab.attacks.walks.execution_attack.attack_execution',
    'silence': 'quad_lab.attacks.walks.silence.attack_by_silence',
    'pauses': 'quad_lab.attacks.walks.pauses.attack_by_pauses',
    'sensors': 'quad_lab.attacks.walks.sensor_attack.attack_by_sensors',
    'late': 'quad_lab.attacks.walks.late_trajectories.attack_by_lateness',
    'files': 'quad_lab.attacks.files.file_attack.measure_files',
    'watch': 'quad_lab.attacks.walks.busy_machine.attack_by_load',
    'kills': 'quad_lab.attacks.walks.kills.attack_by_kills',
    'soak': 'quad_lab.attacks.walks.soak.soak',
    'localisation': 'quad_lab.attacks.walks.drift.attack_by_drift',
}
"""What is attacked, by the name for ``--only``: the function of each part."""


def attack_of(part: str) -> Callable[[Console, bool, int], Result]:
    """
    Import a part, and what it needs: some parts need ROS, and some do not.

    Parameters
    ----------
    part : str
        Key of :data:`PARTS`.

    Returns
    -------
    callable
        Takes the console, whether a small sample is enough, and the seed.
    """
    module, _, name = PARTS[part].rpartition('.')
    attack: Callable[[Console, bool, int], Result] = getattr(importlib.import_module(module), name)
    return attack
