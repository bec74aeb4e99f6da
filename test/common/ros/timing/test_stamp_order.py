"""Stamps rise; one that does not is refused, and a clock that was set again is followed."""

import pytest

from quad_common.errors import InvalidMessage
from quad_common.ros.timing.stamp_order import StampOrder


def taken(order, stamps):
    """Return which stamps were taken."""
    kept = []
    for stamp in stamps:
        try:
            order.check(stamp)
        except InvalidMessage:
            continue
        kept.append(stamp)
    return kept


def test_rising_stamps_are_taken():
    stamps = [0.0, 0.02, 0.04, 1.0, 2.9]
    assert taken(StampOrder('odometry', 2.0), stamps) == stamps


@pytest.mark.parametrize('stamp', [5.0, 4.9, 0.0, 7.5, 2e9])
def test_one_stamp_that_does_not_follow_is_refused_and_changes_nothing(stamp):
    order = StampOrder('odometry', 2.0)
    assert taken(order, [4.0, 5.0, stamp, 5.1, stamp, 5.2]) == [4.0, 5.0, 5.1, 5.2]


def test_the_sentence_says_which_stamps_would_be_valid():
    order = StampOrder('odometry', 2.0)
    order.check(5.0)
    with pytest.raises(InvalidMessage, match=r'is 4\.000 s; it must be after 5\.000 s and not '):
        order.check(4.0)
    endless = StampOrder('image')
    endless.check(5.0)
    with pytest.raises(InvalidMessage, match=r'must be after 5\.000 s$'):
        endless.check(5.0)


def test_a_clock_that_was_set_anew_is_followed_after_a_few_messages():
    order = StampOrder('odometry', 2.0, patience=3)
    order.check(100.0)
    assert taken(order, [1.0, 1.1]) == []
    assert order.check(1.2)
    assert not order.check(1.3)


def test_a_hostile_first_stamp_does_not_keep_the_good_ones_out():
    order = StampOrder('image', patience=3)
    order.check(2e9)
    assert taken(order, [1.0, 2.0, 3.0, 4.0]) == [3.0, 4.0]


def test_hostile_stamps_between_good_ones_never_win():
    order = StampOrder('odometry', 2.0, patience=3)
    good = [0.02 * index for index in range(100)]
    mixed = [stamp for pair in zip(good, [1e6 + s for s in good], strict=True) for stamp in pair]
    assert taken(order, mixed) == good


def test_the_same_stamp_again_and_again_is_never_taken_twice():
    assert taken(StampOrder('odometry', 2.0, patience=3), [1.0] * 20) == [1.0]
