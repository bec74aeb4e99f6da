"""The active pair's figures hold, and would not if the method were wrong."""

from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip('rich')

from quad_common.planar_pair.planar_pair import points_of
from quad_lab.benchmarks.ground.bench_active_pair import (
    CASES,
    FLATTEST,
    active_pair_bars,
    flatness,
    random_postures,
    recovery_error,
)


def test_the_bars_hold():
    pytest.importorskip('pybullet')
    bars = active_pair_bars(quick=True, seed=1)
    assert len({bar.name for bar in bars}) == len(bars) == 10
    # The rate's bar is that of an idle machine.
    failed = [bar for bar in bars if bar.holds is False and bar.unit != '1/s']
    assert failed == []


def test_postures_are_as_many_as_asked_for_and_none_is_flat():
    drawn = list(random_postures(np.random.default_rng(0), 5000))
    assert sum(posture.theta.size for _, posture in drawn) == 5000
    assert len({np.sign(pair.span) for pair, _ in drawn}) == 2
    for pair, posture in drawn:
        assert flatness(pair, points_of(pair, posture)).min() >= FLATTEST


@pytest.mark.parametrize('case', CASES, ids=lambda case: case.causality)
def test_an_error_of_a_millionth_would_be_seen(case):
    assert recovery_error(case, np.random.default_rng(0), 1000) < 1e-9

    def wrong(pair, posture, points, **how):
        found = case.solve(pair, posture, points, **how)
        return replace(found, theta=found.theta + 1e-6)

    error = recovery_error(replace(case, solve=wrong), np.random.default_rng(0), 1000)
    assert error == pytest.approx(1e-6, rel=1e-3)
