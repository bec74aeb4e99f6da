"""The attack on what joints are commanded finds nothing, and would find commands that are wrong."""

import pytest
from rich.console import Console

from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_lab.attacks.walks import execution_attack
from quad_lab.attacks.walks.execution_attack import attack_execution

WRONG = (
    'commands out of range',
    'commands too fast',
    'commands that the gate does not know',
)


def quiet_attack(monkeypatch, trajectories=400):
    monkeypatch.setattr(execution_attack, '_QUICK_TRAJECTORIES', trajectories)
    bars, details = attack_execution(Console(quiet=True), quick=True, seed=3)
    return {bar.name: bar.value for bar in bars}, details


def test_commands_keep_the_limits_whatever_trajectories_come(monkeypatch):
    values, details = quiet_attack(monkeypatch)
    assert [values[name] for name in WRONG] == [0, 0, 0]
    assert details == {'wrong': []}
    assert values['of which late'] > 50
    assert 0.2 < values['refused'] / (values['refused'] + values['trajectories executed']) < 0.8


def test_joints_that_go_out_of_range_on_their_way_are_found_out(monkeypatch):
    monkeypatch.setattr(JointLimits, 'keeps_range', lambda *_: True)
    monkeypatch.setattr(JointLimits, 'clip', lambda _, positions: positions)
    values, details = quiet_attack(monkeypatch, 600)
    assert values['commands out of range'] > 0
    assert 'rad out of range' in details['wrong'][0]


@pytest.mark.parametrize('is_lost', [False, True])
def test_commands_that_leap_are_found_out(monkeypatch, is_lost):
    accept = TrajectoryExecutor.accept

    def leap(self, trajectory, now):
        fits = accept(self, trajectory, now)
        self._fading = None
        if is_lost:
            self.hold(trajectory.positions[-1])
        return fits

    monkeypatch.setattr(TrajectoryExecutor, 'accept', leap)
    values, _ = quiet_attack(monkeypatch)
    assert values['commands too fast'] > 10
