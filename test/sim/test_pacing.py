"""Simulated time keeps its pace by the wall clock, or does not leave the gait behind."""

import numpy as np
import pytest

from quad_sim.pacing import Answers, Pacing


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


def waited(answers, simulated, since, until):
    """Look again and again, as a simulator does; return how much longer is to be waited."""
    for wall in np.arange(since, until + 1e-9, 0.1):
        wait = answers.wait(simulated, wall)
    return wait


def test_a_pause_of_the_machine_is_no_silence_of_the_gait():
    # The simulator went on at once, and the gait, paused like it, was left behind.
    answers = Answers()
    answers.take(1.0, 1.0, wall=5.0)
    assert answers.wait(1.3, wall=5.1) > 0.0
    assert answers.wait(1.3, wall=25.0) > 0.0
    assert waited(answers, 1.3, 25.0, 26.0) == 0.0


def test_nobody_is_waited_for_who_has_never_answered():
    assert Answers().wait(100.0, wall=1.0) == 0.0


def test_a_gait_that_is_left_behind_is_waited_for_until_it_answers():
    answers = Answers()
    answers.take(1.0, 1.0, wall=5.0)
    assert answers.wait(1.1, wall=5.0) == 0.0
    assert waited(answers, 1.3, 5.0, 5.3) == pytest.approx(0.7)
    answers.take(1.2, 1.3, wall=5.4)
    assert answers.wait(1.3, wall=5.4) == 0.0


def test_a_gait_that_is_silent_is_not_waited_for_any_more():
    answers = Answers()
    answers.take(1.0, 1.0, wall=5.0)
    assert waited(answers, 1.3, 5.0, 10.1) == 0.0
    assert answers.wait(9.0, wall=10.2) == 0.0
    # It is waited for again once it answers.
    answers.take(1.4, 1.5, wall=9.0)
    assert answers.wait(1.7, wall=9.1) > 0.0


def test_after_a_second_without_an_answer_time_goes_on_no_faster_than_the_wall_clock():
    # A gait that was not given the processor for 1.5 s lost whole cycles, and robots fell.
    answers = Answers()
    answers.take(1.0, 1.0, wall=5.0)
    assert waited(answers, 1.3, 5.0, 6.1) == 0.0
    assert answers.wait(1.32, wall=6.1) == pytest.approx(0.02)
    assert answers.wait(1.32, wall=6.12) == pytest.approx(0.0, abs=1e-9)
    assert answers.wait(2.3, wall=6.2) == pytest.approx(0.9)


def test_a_gait_that_falls_silent_late_is_not_waited_for_since_the_beginning():
    # A slow machine simulates for more than a second what a gait may be left behind by.
    answers = Answers()
    answers.take(100.0, 100.0, wall=5.0)
    assert waited(answers, 100.1, 5.0, 6.5) == 0.0
    assert answers.wait(100.3, wall=6.6) == 0.0
    assert answers.wait(100.32, wall=6.6) == pytest.approx(0.02)


def test_a_gait_that_answers_each_measurement_is_to_answer_it_before_the_next():
    answers = Answers()
    for time in (1.0, 1.01, 1.02):
        answers.take(time, time, wall=5.0)
    assert answers.wait(1.03, wall=5.0) == 0.0
    assert answers.wait(1.04, wall=5.0) > 0.0
    # Once it answers seldom again it has its lead.
    answers.take(1.12, 1.12, wall=5.0)
    assert answers.wait(1.3, wall=5.0) > 0.0
    answers.take(1.22, 1.22, wall=5.0)
    assert answers.wait(1.4, wall=5.0) == 0.0


def test_a_gait_that_skips_a_measurement_is_not_left_behind_farther():
    # It answered every other measurement from then on, each two late.
    answers = Answers()
    for time in (1.0, 1.02, 1.06):
        answers.take(time, time, wall=5.0)
    assert answers.wait(1.08, wall=5.0) == 0.0
    assert answers.wait(1.1, wall=5.0) > 0.0


@pytest.mark.parametrize('stamp', [0.5, 1.0, 7.0, float('nan'), float('inf')])
def test_an_answer_that_is_old_or_of_the_future_holds_nobody_up(stamp):
    answers = Answers()
    answers.take(1.0, 1.0, wall=5.0)
    assert waited(answers, 2.0, 5.0, 5.9) > 0.0
    answers.take(stamp, 2.0, wall=5.9)
    assert waited(answers, 2.0, 5.9, 6.1) == 0.0
