"""Wilson's interval is that of its paper, and holds what it must."""

import pytest

from quad_lab.campaigns.intervals import wilson_interval


@pytest.mark.parametrize(
    ('successes', 'trials', 'lower', 'upper'),
    [
        # Newcombe 1998, table I, method 3.
        (81, 263, 0.2553, 0.3662),
        (15, 148, 0.0624, 0.1605),
        (0, 20, 0.0, 0.1611),
        (1, 29, 0.0061, 0.1718),
    ],
)
def test_published_intervals(successes, trials, lower, upper):
    assert wilson_interval(successes, trials) == pytest.approx((lower, upper), abs=5e-5)


@pytest.mark.parametrize('trials', [1, 7, 1000])
def test_failures_mirror_successes(trials):
    for successes in {0, 1, trials // 2, trials}:
        lower, upper = wilson_interval(successes, trials)
        assert wilson_interval(trials - successes, trials) == pytest.approx((1 - upper, 1 - lower))
        assert 0.0 <= lower <= successes / trials <= upper <= 1.0


def test_nothing_is_known_without_a_trial():
    assert wilson_interval(0, 0) == (0.0, 1.0)


def test_a_thousand_successes_leave_less_than_half_a_percent():
    lower, upper = wilson_interval(1000, 1000)
    assert upper == 1.0
    assert lower == pytest.approx(0.99617, abs=1e-5)
