"""A batch holds what was put into it, in its order, and is sent in time."""

from __future__ import annotations

import numpy as np
import pytest

from quad_common.errors import InvalidMessage
from quad_common.message_batch import MessageBatch, read_batch

TOPICS = ('/clock', '/odom', '/joint_states')

MS = 1_000_000


def filled(messages):
    batch = MessageBatch(TOPICS)
    for topic, data, now in messages:
        batch.add(topic, data, now)
    return batch


@pytest.mark.parametrize('seed', range(5))
def test_what_was_put_in_comes_out(seed):
    rng = np.random.default_rng(seed)
    times = np.cumsum(rng.integers(0, 5 * MS, 40)).tolist()
    put = [(int(rng.integers(3)), rng.bytes(int(rng.integers(0, 900))), time) for time in times]
    got = list(read_batch(TOPICS, filled(put).close(times[-1] + 7)))
    assert [(m.topic, m.data) for m in got] == [(TOPICS[topic], data) for topic, data, _ in put]
    assert [m.age for m in got] == [times[-1] + 7 - time for time in times]


def test_a_closed_batch_begins_again():
    batch = filled([(0, b'old', 0)])
    batch.close(1)
    batch.add(1, b'new', 2)
    assert [m.data for m in read_batch(TOPICS, batch.close(3))] == [b'new']


def test_nothing_is_due_where_nothing_waits():
    assert not MessageBatch(TOPICS).is_due(10**18)


def test_a_message_waits_for_others_but_not_for_long():
    batch = filled([(0, b'x', 100 * MS)])
    assert not batch.is_due(110 * MS)
    assert batch.is_due(120 * MS)


def test_a_clock_that_was_set_back_holds_nothing_up():
    assert filled([(0, b'x', 100 * MS)]).is_due(50 * MS)


def test_a_batch_fits_one_datagram():
    batch, size = MessageBatch(TOPICS), 1000
    while not batch.is_due(0):
        batch.add(0, bytes(size), 0)
    assert 50_000 < len(batch.close(0)) < 65_507 - size


@pytest.mark.parametrize('length', [0, 5, 12, 20, 30])
def test_a_batch_that_is_cut_off_says_so(length):
    data = filled([(1, bytes(10), 0)]).close(5)
    with pytest.raises(InvalidMessage, match='batch'):
        list(read_batch(TOPICS, data[:length]))


def test_what_comes_before_the_damage_is_good():
    data = filled([(1, b'good', 0), (2, b'damaged', 1)]).close(5)
    got = read_batch(TOPICS, data[:-1])
    assert next(got).data == b'good'
    with pytest.raises(InvalidMessage):
        next(got)


def test_a_topic_that_is_not_named_is_refused():
    with pytest.raises(InvalidMessage, match='1 topics'):
        list(read_batch(TOPICS[:1], filled([(2, b'x', 0)]).close(1)))
