"""
Which sentences of a node are logged: bad input may come in streams.
"""

from __future__ import annotations

import time
from collections.abc import Callable

from quad_common.status import without_figures

_PERIOD = 10.0
"""The same sentence is logged again only after so long [s]."""

_MOST_SENTENCES = 200
"""Different sentences that are logged in that time; more of them are bad input in a stream."""

_MOST_ALIKE = 5
"""Sentences that differ in figures alone and are logged in that time."""


class LogLimit:
    """
    Lets a sentence into the log, unless its like was there a moment ago.

    Parameters
    ----------
    clock : callable
        Returns the time [s].
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._logged_at: dict[str, float] = {}

    def lets(self, kind: str, sentence: str) -> bool:
        """
        Return whether a sentence is to be logged now; it counts as logged then.

        Parameters
        ----------
        kind : str
            A word for how it is logged, as ``ERROR``.
        sentence : str
            The sentence, or what it is about.
        """
        now, key = self._clock(), f'{kind} {sentence}'
        self._logged_at = {k: t for k, t in self._logged_at.items() if now - t < _PERIOD}
        if key in self._logged_at or len(self._logged_at) >= _MOST_SENTENCES:
            return False
        pattern = without_figures(key)
        alike = sum(without_figures(logged) == pattern for logged in self._logged_at)
        if alike >= _MOST_ALIKE:
            return False
        self._logged_at[key] = now
        return True
