"""Simulated time keeps its pace by the wall clock, and does not catch up what is lost."""

import pytest

from quad_sim.pacing import Pacing


def test_a_simulation_that_is_early_waits_for_real_time():
    pacing = Pacing(2.0, wall=10.0)
    assert pacing.ahead(1.0, wall=10.2) == pytest.approx(0.3)
    assert pacing.ahead(1.0, wall=10.5) == pytest.approx(0.0)


def test_time_that_was_lost_is_not_caught_up():
    pacing = Pacing(1.0, wall=0.0)
    assert pacing.ahead(1.0, wall=3.0) < 0.0
    assert pacing.ahead(1.5, wall=3.1) == pytest.approx(0.4)


def test_without_a_factor_nothing_waits():
    assert Pacing(0.0, wall=0.0).ahead(100.0, wall=1.0) == 0.0


def test_after_a_pause_the_pace_begins_again():
    pacing = Pacing(1.0, wall=0.0)
    pacing.restart(1.0, wall=50.0)
    assert pacing.ahead(1.2, wall=50.0) == pytest.approx(0.2)


def test_the_measured_factor_is_that_since_the_last_time():
    pacing = Pacing(0.0, wall=0.0)
    assert pacing.measured_factor(4.0, wall=2.0) == pytest.approx(2.0)
    assert pacing.measured_factor(5.0, wall=4.0) == pytest.approx(0.5)
