"""Readings come as seldom, as late and as wrong as is asked for."""

from dataclasses import dataclass

import numpy as np
import pytest

from quad_lab.attacks.walks.sensor_streams import SensorStream, StreamFault


@dataclass(frozen=True)
class Seen:
    """An observation, as far as it matters here."""

    time: float
    value: float


def passed(fault, steps=20, before=5):
    """Return when each reading comes, and the reading, from the time on at which a fault begins."""
    stream, come = SensorStream(), []
    for number in range(steps):
        if number == before:
            stream.begin(fault)
        seen = Seen(round(0.02 * number, 6), float(number))
        come += [(seen.time, told) for told in stream.pass_on(seen)]
    return [(time, told) for time, told in come if time >= 0.02 * before]


def test_sound_readings_come_at_once():
    assert all(told.time == time for time, told in passed(StreamFault()))
    assert len(passed(StreamFault())) == 15


def test_readings_come_seldom():
    times = [time for time, _ in passed(StreamFault(period=0.1))]
    assert np.diff(times) == pytest.approx([0.1, 0.1])
    assert len(times) == 3


def test_readings_come_late_and_those_on_their_way_do_not():
    ages = [time - told.time for time, told in passed(StreamFault(delay=0.06))]
    assert ages == pytest.approx([0.06] * 12)


def test_a_stuck_sensor_tells_the_same_at_every_time():
    told = [told for _, told in passed(StreamFault(is_stuck=True))]
    assert {each.value for each in told} == {5.0}
    assert [each.time for each in told] == pytest.approx([0.02 * k for k in range(5, 20)])


def test_a_silent_sensor_tells_nothing():
    assert passed(StreamFault(is_silent=True)) == []
