"""
The time of a recording runs, stands still, ends, and is set.
"""

import pytest

from quad_view.scene.timeline import Timeline


@pytest.mark.parametrize('speed', [0.5, 1.0, 4.0])
def test_it_runs_at_its_speed(speed):
    timeline = Timeline(10.0, 30.0)
    timeline.speed = speed
    timeline.advance(2.0)
    assert timeline.time == pytest.approx(10.0 + 2.0 * speed)
    assert timeline.elapsed == pytest.approx(2.0 * speed)


def test_it_stops_at_the_end_and_begins_anew():
    timeline = Timeline(0.0, 1.0)
    timeline.advance(5.0)
    assert timeline.time == 1.0
    assert not timeline.is_playing
    timeline.toggle()
    assert (timeline.time, timeline.is_playing) == (0.0, True)


def test_it_stands_still():
    timeline = Timeline(0.0, 10.0)
    timeline.advance(1.0)
    timeline.toggle()
    timeline.advance(3.0)
    assert timeline.time == 1.0
    timeline.toggle()
    timeline.advance(3.0)
    assert timeline.time == 4.0


@pytest.mark.parametrize(('elapsed', 'time'), [(-1.0, 5.0), (2.5, 7.5), (99.0, 9.0)])
def test_it_is_set_between_its_ends(elapsed, time):
    timeline = Timeline(5.0, 9.0)
    timeline.seek(elapsed)
    assert timeline.time == time
