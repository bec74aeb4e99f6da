"""The attack on the last gate finds nothing, and would find a gate that fails."""

import numpy as np
import pytest
from rich.console import Console

from quad_common.errors import CommandJumps
from quad_lab.attacks.walks import gate_attack as faults_gate
from quad_lab.attacks.walks.gate_attack import attack_gate


def quiet_attack(monkeypatch, check=None):
    monkeypatch.setattr(faults_gate, '_QUICK_CASES', 400)
    if check is not None:
        monkeypatch.setattr(faults_gate, 'check_command', check)
    bars, _ = attack_gate(Console(quiet=True), quick=True, seed=1)
    return {bar.name: bar.value for bar in bars}


def test_the_gate_is_right_about_motions_at_random(monkeypatch):
    values = quiet_attack(monkeypatch)
    assert values['passed though beyond the limits'] == 0
    assert values['refused though within'] == 0
    assert 0.2 < values['of which refused'] / values['motions'] < 0.8


@pytest.mark.parametrize(
    ('refuses', 'found'),
    [(False, 'passed though beyond the limits'), (True, 'refused though within')],
)
def test_a_gate_that_always_says_the_same_is_found_out(monkeypatch, refuses, found):
    def check(*_):
        if refuses:
            raise CommandJumps('a', float(np.pi), 0.02)

    assert quiet_attack(monkeypatch, check)[found] > 50
