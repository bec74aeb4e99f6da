"""What time it is while nothing is measured."""

import numpy as np
import pytest

from quad_gait.state.measured_time import MeasuredTime


def told(pace=1.0, clock=lambda t: t, duration=2.0):
    """Return the time after measurements every 20 ms; all clocks begin at 0."""
    time = MeasuredTime()
    for newest in np.arange(0.0, duration + 1e-9, 0.02):
        time.note_odometry(100.0 + newest, clock(newest), newest / pace)
    return time


def test_before_anything_was_measured_no_time_is_known():
    time = MeasuredTime()
    time.note_joints(1.0, 1.0)
    assert time.now(2.0, 2.0) is None


def test_right_after_a_measurement_it_is_its_time():
    assert told().now(2.0, 2.0) == pytest.approx(102.0)


@pytest.mark.parametrize('pace', [0.3, 1.0, 12.0])
def test_it_goes_on_by_the_clock_at_any_pace(pace):
    assert told(pace, duration=24.0).now(25.5, 25.5 / pace) == pytest.approx(125.5)


def test_it_stands_still_while_simulated_time_does():
    assert told().now(2.0, 60.0) == pytest.approx(102.0)


@pytest.mark.parametrize('leap', [1e6, 3600.0, -3600.0])
def test_a_clock_that_leaps_says_little_while_measurements_come(leap):
    assert told().now(2.0 + leap, 2.01) == pytest.approx(102.0, abs=0.016)


def test_a_clock_that_is_not_that_of_the_simulation_does_not_run_ahead_of_it():
    # The wall clock's, beside a simulation at a third of real time.
    slow = told(0.3, clock=lambda t: t / 0.3)
    assert slow.now(3.0 / 0.3, 3.0 / 0.3) == pytest.approx(103.0, abs=0.51)


def test_measurements_of_a_clock_that_was_set_back_begin_anew():
    time = told()
    for newest in np.arange(0.0, 1.0, 0.02):
        time.note_odometry(5.0 + newest, 2.0 + newest, 2.0 + newest)
    assert time.now(3.48, 3.48) == pytest.approx(6.48, abs=0.02)


@pytest.mark.parametrize('ahead', [0.5, 4.9])
def test_joint_states_that_are_stamped_ahead_say_little(ahead):
    time = told()
    time.note_joints(102.0 + ahead, 2.0)
    assert time.now(2.01, 2.01) == pytest.approx(102.0, abs=0.016)


@pytest.mark.parametrize(
    'clock', [lambda t: t, lambda t: t + 100.0, lambda t: t - 100.0, lambda t: 2.0]
)
def test_while_odometry_is_silent_it_goes_on_by_the_joints_whatever_the_clock_does(clock):
    time = told()
    for newest in np.arange(2.02, 3.5, 0.02):
        time.note_joints(100.0 + newest, newest)
    assert time.now(clock(3.5), 3.5) == pytest.approx(103.48, abs=0.03)


def test_while_nothing_comes_it_goes_on_by_the_clock():
    time = told()
    for newest in np.arange(2.02, 2.5, 0.02):
        time.note_joints(100.0 + newest, newest)
    assert time.now(3.5, 3.5) == pytest.approx(103.5)
