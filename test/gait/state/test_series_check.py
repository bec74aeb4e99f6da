"""A reading that does not fit is refused; those that fit one another for a while are believed."""

import numpy as np
import pytest

from quad_common.errors import InvalidMessage
from quad_gait.state.readings.series_check import LEAST_TIME, LONGEST_GAP, SeriesCheck, Taken


def make_check(rate=1.0):
    """Return a check of numbers that change by no more than a rate."""

    def difference(before, after, dt):
        return '' if abs(after - before) <= rate * dt + 1e-9 else f'{before} to {after}'

    return SeriesCheck('number', difference)


def take_all(check, readings):
    return [check.take(time, value) for time, value in readings]


def refusals(check, readings):
    """Return what became of readings, None for those that were refused."""
    results = []
    for time, value in readings:
        try:
            results.append(check.take(time, value))
        except InvalidMessage:
            results.append(None)
    return results


def test_what_changes_no_faster_than_it_can_fits():
    check = make_check()
    assert set(take_all(check, [(0.1 * k, 0.09 * k) for k in range(50)])) == {Taken.FITS}
    assert check.time == pytest.approx(4.9)


def test_a_reading_of_the_same_time_says_nothing_new():
    check = make_check()
    assert take_all(check, [(1.0, 0.0), (1.0, 99.0)]) == [Taken.FITS, Taken.REPEATED]


@pytest.mark.parametrize('outlier', [(0.5, 7.0), (0.3, 0.0), (1e9, 0.0), (-1e9, 0.0)])
def test_a_single_outlier_in_value_or_time_is_refused_and_nothing_else(outlier):
    check = make_check()
    before = [(0.1 * k, 0.0) for k in range(5)]
    after = [(0.5 + 0.1 * k, 0.0) for k in range(1, 20)]
    take_all(check, before)
    with pytest.raises(InvalidMessage):
        check.take(*outlier)
    assert set(take_all(check, after)) == {Taken.FITS}


def test_outliers_that_do_not_fit_one_another_are_never_believed():
    rng = np.random.default_rng(0)
    check = make_check()
    check.take(0.0, 0.0)
    readings = [(0.02 * k, v) for k, v in enumerate(rng.choice([-1, 1], 500) * 50.0, 1)]
    alternating = [(t, v * (1 + k % 2)) for k, (t, v) in enumerate(readings)]
    assert set(refusals(check, alternating)) == {None}


@pytest.mark.parametrize('shift', [(0.0, 9.0), (-100.0, 0.0), (100.0, 0.0), (-100.0, 9.0)])
def test_a_robot_that_was_moved_or_a_clock_that_was_set_is_believed_after_a_while(shift):
    check = make_check()
    take_all(check, [(200.0 + 0.02 * k, 0.0) for k in range(10)])
    readings = [(200.2 + 0.02 * k + shift[0], shift[1]) for k in range(30)]
    results = refusals(check, readings)
    first = results.index(Taken.NEW_SERIES)
    assert results[:first] == [None] * first
    assert readings[first][0] - readings[0][0] == pytest.approx(LEAST_TIME, abs=0.021)
    assert set(results[first + 1 :]) == {Taken.FITS}


def test_after_silence_more_may_have_changed_but_not_while_other_readings_came():
    check = make_check()
    check.take(0.0, 0.0)
    assert check.take(1.0, 0.9) is Taken.FITS
    # From here on readings say 3, again and again: no silence in which 3 was reached.
    results = refusals(check, [(1.02 + 0.02 * k, 3.0) for k in range(8)])
    assert results == [None] * 8


def test_a_gap_that_is_too_long_counts_as_a_clock_that_was_set():
    check = make_check()
    check.take(0.0, 0.0)
    with pytest.raises(InvalidMessage, match='after that of the last one'):
        check.take(LONGEST_GAP + 0.1, 0.0)
