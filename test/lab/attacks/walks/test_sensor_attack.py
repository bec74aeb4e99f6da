"""Robots whose sensors go bad do not fall, and the attack by them says so where one does."""

import pytest

pytest.importorskip('pybullet')

from rich.console import Console

from quad_lab.attacks.walks import sensor_attack
from quad_lab.attacks.walks.sensor_attack import (
    FAULTS,
    WALKERS,
    SensorCase,
    SensorOutcome,
    attack_by_sensors,
    walk_with_bad_sensors,
)


@pytest.mark.sweep(kept=1)
@pytest.mark.parametrize('fault', ['imu at 10 Hz', 'all 0.15 s late'])
def test_a_trot_that_keeps_its_balance_bears_readings_that_get_old(fault):
    # Both fell by it within 2 s, at level OK.
    outcome = walk_with_bad_sensors(SensorCase('genibo', 'trot', 'flat', True, fault, 0))
    assert not outcome.has_fallen
    assert not outcome.is_called_lame
    assert outcome.goes_on
    assert outcome.tilt < 0.35


def outcome_of(case, **wrong):
    facts = {'has_fallen': False, 'is_called_lame': False, 'goes_on': True, 'tilt': 0.1}
    return SensorOutcome(case, said='', **{**facts, **wrong})


class Pool:
    """Walks in this process, as the test says."""

    def __enter__(self):
        return self

    def __exit__(self, *_):
        pass

    def map(self, walk, cases):
        return map(walk, cases)


@pytest.mark.parametrize(
    ('wrong', 'bar'),
    [
        ({'has_fallen': True}, 'falls'),
        ({'is_called_lame': True}, 'sound robots called lame'),
        ({'goes_on': False}, 'goes on afterwards, of 72'),
    ],
)
def test_one_walk_that_does_not_end_well_misses_a_bar(monkeypatch, wrong, bar):
    walked = []

    def walk(case):
        walked.append(case)
        return outcome_of(case, **(wrong if len(walked) == 20 else {}))

    monkeypatch.setattr(sensor_attack, 'worker_pool', Pool)
    monkeypatch.setattr(sensor_attack, 'walk_with_bad_sensors', walk)
    bars, details = attack_by_sensors(Console(quiet=True), False, 0)
    assert len(walked) == len(WALKERS) * len(FAULTS) == 72
    assert len(details['walks']) == 72
    assert [each.name for each in bars if each.holds is False] == [bar]
