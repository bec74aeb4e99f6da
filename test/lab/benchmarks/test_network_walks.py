"""Walks over a network are judged by all of them, and its settings leave time for a few trials."""

from __future__ import annotations

from dataclasses import replace
from xml.etree import ElementTree

import pytest

pytest.importorskip('rclpy')

from quad_common.resources import share_directory
from quad_lab.benchmarks import network_walks
from quad_lab.benchmarks.network_walks import LEAD_TIME, NetworkWalk

WALK = NetworkWalk(0, True, 0, 1.0, 1000, 10, '')


def holds(*walks):
    return [bar.holds for bar in network_walks._bars(list(walks), 2)][:2]


def test_every_walk_counts():
    assert holds(WALK, WALK) == [True, True]
    assert holds(WALK, replace(WALK, arrived=False)) == [False, True]
    assert holds(WALK, replace(WALK, late=1)) == [True, False]


def test_what_was_not_measured_does_not_hold():
    assert holds() == [False, False]


def test_a_packet_is_sent_four_times_before_a_trajectory_is_late():
    settings = ElementTree.parse(share_directory() / 'config' / 'fastdds_network.xml')
    periods = {
        element.tag.rpartition('}')[2]: 1e-9 * float(element[1].text)
        for element in settings.iter()
        if element.tag.endswith(('heartbeatPeriod', 'Delay'))
    }
    delay = network_walks._IMPAIRMENT.delay
    # It is asked for, the answer comes back, and it is sent again.
    trial = 3 * delay + sum(periods.values())
    assert len(periods) == 3
    # Measurement and trajectory are under way once each.
    assert 2 * delay + 3 * trial < LEAD_TIME
