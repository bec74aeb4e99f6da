"""What is lost, doubled or swapped in a recording is counted, and so is every leap of a frame."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from quad_lab.benchmarks.recordings.laws import (
    Limits,
    Moved,
    angle_between,
    differing,
    jumps,
    without_way,
)

HEARD = [b'a', b'b', b'a', b'c', b'd']

STILL = (0.0, 0.0, 0.0, 1.0)

LIMITS = {'base_link': Limits(1.0, 2.0)}


def turned(angle):
    return (0.0, 0.0, math.sin(angle / 2.0), math.cos(angle / 2.0))


def at(time, x, turn=STILL, child='base_link'):
    return Moved('odom', child, time, (x, 0.0, 0.0), turn)


def test_two_that_have_the_same_differ_in_nothing():
    assert differing(HEARD, HEARD, 5) == 0
    assert differing([], [], 0) == 0


@pytest.mark.parametrize('late', [1, 2])
def test_either_may_have_begun_later(late):
    assert differing(HEARD, HEARD[late:], 3) == 0
    assert differing(HEARD[late:], HEARD, 3) == 0
    assert differing(HEARD[3:], HEARD, 3) > 0


@pytest.mark.parametrize('index', range(1, 5))
def test_what_is_lost_or_doubled_counts(index):
    lost = HEARD[:index] + HEARD[index + 1 :]
    doubled = HEARD[: index + 1] + HEARD[index:]
    assert differing(HEARD, lost, 4) > 0
    assert differing(HEARD, doubled, 6) > 0
    assert differing(lost, HEARD, 5) > 0


def test_order_counts():
    assert differing(HEARD, [b'a', b'b', b'a', b'd', b'c'], 5) == 1


def test_a_topic_that_only_one_has_counts():
    assert differing(HEARD, [], 0) > 0
    assert differing([], HEARD, 5) == 5


def test_a_frame_may_move_as_fast_as_it_can():
    steps = [at(0.02 * k, 0.02 * k, turned(0.04 * k)) for k in range(20)]
    assert jumps(steps, LIMITS, Limits(0.0, 0.0)) == 0


@pytest.mark.parametrize(
    'leap',
    [{'position': (0.5, 0.0, 0.0)}, {'turn': turned(1.0)}, {'time': 0.01}, {'parent': 'map'}],
)
def test_a_leap_is_counted_there_and_back(leap):
    steps = [at(0.02 * k, 0.0) for k in range(5)]
    steps[3] = replace(steps[3], **leap)
    assert jumps(steps, LIMITS, Limits(0.0, 0.0)) >= 1


def test_links_turn_on_their_joints_and_do_not_leave_them():
    others = Limits(0.0, 5.0)
    turning = [at(0.04 * k, 0.1, turned(0.2 * k), 'calf') for k in range(5)]
    assert jumps(turning, LIMITS, others) == 0
    assert jumps([at(0.0, 0.1, child='calf'), at(0.04, 0.12, child='calf')], LIMITS, others) == 1


@pytest.mark.parametrize('angle', [0.0, 1e-6, 0.3, 3.0])
def test_an_orientation_has_two_quaternions(angle):
    other = tuple(-part for part in turned(angle))
    assert angle_between(STILL, turned(angle)) == pytest.approx(angle, abs=1e-12)
    assert angle_between(STILL, other) == pytest.approx(angle, abs=1e-12)


def test_frames_lead_to_their_root_or_are_named():
    edges = [('map', 'odom'), ('odom', 'base_link'), ('other', 'foot'), ('x', 'y'), ('y', 'x')]
    assert without_way(edges, 'map') == {'foot', 'x', 'y'}
    assert without_way(edges[:2], 'map') == set()
