"""
Intervals of confidence for fractions.
"""

from __future__ import annotations

import math

_Z = 1.959963984540054
"""Quantile of the normal distribution of two-sided 95 %."""


def wilson_interval(successes: int, trials: int) -> tuple[float, float]:
    """
    Return the 95 % interval of a probability, of independent trials.

    Wilson 1927, "Probable inference, the law of succession, and statistical inference", eq. 4: it
    is right for few trials and for fractions near 0 and 1 too.

    Parameters
    ----------
    successes, trials : int
        Number of successes, and of trials.

    Returns
    -------
    lower, upper : float
        0 and 1 without any trial.
    """
    if trials == 0:
        return 0.0, 1.0
    p, n, z2 = successes / trials, float(trials), _Z * _Z
    middle = (p + z2 / (2.0 * n)) / (1.0 + z2 / n)
    half = _Z / (1.0 + z2 / n) * math.sqrt(p * (1.0 - p) / n + z2 / (4.0 * n * n))
    lower = 0.0 if successes == 0 else middle - half
    upper = 1.0 if successes == trials else middle + half
    return lower, upper
