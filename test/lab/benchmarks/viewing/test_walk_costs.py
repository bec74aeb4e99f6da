"""What a recording lacks is counted by the gaps between stamps."""

from __future__ import annotations

import random

import pytest

pytest.importorskip('rclpy')
pytest.importorskip('rosbags')

from quad_lab.benchmarks.viewing.walk_costs import missing

STAMPS = [20_000_000 * k for k in range(7, 107)]


def test_nothing_is_missing_of_a_regular_series_in_any_order():
    assert missing(STAMPS) == 0
    assert missing(random.Random(0).sample(STAMPS, len(STAMPS))) == 0
    assert missing([stamp + 3 * (stamp % 7) for stamp in STAMPS]) == 0


@pytest.mark.parametrize('gone', [{5}, {5, 6}, {1, 50, 98}])
def test_what_is_gone_in_the_middle_is_counted(gone):
    assert missing([s for k, s in enumerate(STAMPS) if k not in gone]) == len(gone)


@pytest.mark.parametrize('stamps', [[], [5]])
def test_a_topic_that_was_not_recorded_is_missing(stamps):
    assert missing(stamps) == 1
