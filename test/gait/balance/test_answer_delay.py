"""By how much later than they should answers take effect, told by the joints."""

import math
from collections import deque

import numpy as np
import pytest

from quad_gait.balance.answer_delay import AnswerDelay
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.joint_motion import JointMotion

KNOT = 0.02
NOISE = 1e-3


def answered(rng, last, now, held):
    """A motion that goes on as the last one for some knots, and then somewhere else."""
    times = now + KNOT * np.arange(9 + held)
    if last is None:
        return JointMotion(times, *np.zeros((2, 9 + held, 4, 3)))
    position, speed = last.at(now + held * KNOT)
    later = np.arange(9)[:, None, None] * KNOT
    # All swing on, each answer in a way of its own.
    change = rng.normal(size=(4, 3)) * 0.5
    positions = position + speed * later + 0.5 * change * later**2 / KNOT
    speeds = speed + change * later / KNOT
    before = [last.at(now + k * KNOT) for k in range(held)]
    return JointMotion(
        times,
        np.concatenate([[place for place, _ in before], positions]),
        np.concatenate([[speed for _, speed in before], 0.9 * speeds]),
    )


def delay_told(late, lag=0.0, noise=NOISE, seconds=3.0, change=None, held=1):
    """
    Decide at every knot; joints follow what arrives after what is held, so much later, and lag.

    Return the delay that is told in the end.
    """
    options = BalanceOptions(reaction_time=held * KNOT)
    rng, delay, told = np.random.default_rng(7), AnswerDelay(options), 0.0
    given, on_the_way, followed = None, deque(), None
    for k in range(round(seconds / KNOT)):
        now = k * KNOT
        if change is not None and now > change[0]:
            late = change[1]
        # Joints are where what they followed until now has brought them.
        if given is not None and followed is not None:
            joints = followed.at(now - lag)[0] + noise * rng.normal(size=(4, 3))
            told = delay.take(now, joints, given)
            assert 0.0 <= told <= 1.0
        while on_the_way and on_the_way[0][0] <= now + 1e-9:
            followed = on_the_way.popleft()[1]
        given = answered(rng, given, now, held)
        on_the_way.append((now + held * KNOT + late - 1e-3, given))
    return told


def test_answers_that_are_in_time_have_no_delay():
    assert delay_told(0.0) == pytest.approx(0.0, abs=0.05)


def test_answers_that_take_effect_a_decision_later_do():
    assert delay_told(KNOT) == pytest.approx(1.0, abs=0.1)


def test_a_longer_reaction_time_is_a_delay_too():
    assert delay_told(0.0, held=2) == pytest.approx(1.0, abs=0.05)
    # Answers that come before their time take effect in time.
    assert delay_told(-KNOT, held=2) == pytest.approx(1.0, abs=0.05)
    assert delay_told(KNOT, held=3) == 1.0


def test_later_ones_count_as_a_decision_late_at_least():
    assert delay_told(2.0 * KNOT) > 0.5


def test_joints_that_lag_behind_their_motion_are_told_from_answers_that_are_late():
    assert delay_told(0.0, lag=0.006) < 0.2
    # What a late answer changes has not come through in full, either.
    assert delay_told(KNOT, lag=0.006) > 0.4


def test_noise_alone_tells_of_no_delay():
    rng, delay = np.random.default_rng(3), AnswerDelay(BalanceOptions())
    still = JointMotion(KNOT * np.arange(400), np.zeros((400, 4, 3)), np.zeros((400, 4, 3)))
    for k in range(300):
        assert delay.take(k * KNOT, 0.01 * rng.normal(size=(4, 3)), still) < 0.01


def test_a_delay_that_comes_and_goes_is_followed_within_two_seconds():
    assert delay_told(0.0, seconds=4.0, change=(2.0, KNOT)) > 0.75
    assert delay_told(KNOT, seconds=4.0, change=(2.0, 0.0)) < 0.25


def test_a_motion_is_told_between_its_knots_as_drives_follow_it():
    times = np.array([0.0, 0.1, 0.3])
    curve, slope = np.sin(times), np.cos(times)
    shape = np.ones((1, 4, 3))
    motion = JointMotion(times, curve[:, None, None] * shape, slope[:, None, None] * shape)
    for time in (0.0, 0.03, 0.1, 0.22, 0.3):
        position, speed = motion.at(time)
        assert position == pytest.approx(math.sin(time), abs=1e-5)
        assert speed == pytest.approx(math.cos(time), abs=1e-3)
