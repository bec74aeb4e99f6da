"""
The time at which messages are recorded: it goes on, also where the clock goes back.
"""

from __future__ import annotations

from quad_common.errors import ClockDisbelieved, ClockLeapt, QuadError

_BACK = 1.0
"""Time by which a clock that goes back was set back, and is not only late [s]."""

_FORWARD = 30.0
"""Time by which a clock has to go forward at once for the next one to be waited for [s]."""

_MOST_REMARKS = 10
"""Leaps that are told of: two simulators on one topic make any number."""

_INSTANT = 1e-6
"""Time between two messages that are received at the same time of the clock [s]."""


class RecordedTime:
    """
    Follows a clock through restarts of it, and leaves out single clocks that fit no others.

    Parameters
    ----------
    is_confirmed : bool
        Whether a leap is believed only when the next clock comes from where it went to. The
        machine's own clock tells nothing by mistake.
    """

    def __init__(self, is_confirmed: bool = True) -> None:
        self.remarks: list[QuadError] = []
        """Leaps of the clock, in their order: the first of them."""
        self._is_confirmed = is_confirmed
        self._told: float | None = None
        self._offset = 0.0
        self._leap: float | None = None
        # What was added to the clock before it went back the last time.
        self._before = 0.0
        self._last = 0.0

    @property
    def is_known(self) -> bool:
        """Whether the clock has told a time."""
        return self._told is not None

    def follow(self, told: float) -> None:
        """Take what the clock tells [s], from 0 on."""
        if self._told is None:
            self._told = told
        elif self._returns(told):
            self._told, self._offset, self._leap = told, self._before, None
        elif _follows(told, self._told):
            self._drop_leap()
            self._told = max(told, self._told)
        elif not self._is_confirmed:
            self._go_to(told, told)
        elif self._leap is not None and _follows(told, self._leap):
            leap, self._leap = self._leap, None
            self._go_to(leap, told)
        else:
            self._drop_leap()
            self._leap = told

    def next(self) -> float:
        """Return the time of the next message [s]: readers sort by it."""
        now = 0.0 if self._told is None else self._told + self._offset
        self._last = max(now, self._last + _INSTANT)
        return self._last

    def _returns(self, told: float) -> bool:
        """Return whether the first of two clocks that take turns has its turn again."""
        assert self._told is not None
        return told - self._told > _BACK and _follows(told + self._before, self._last)

    def _go_to(self, leap: float, told: float) -> None:
        """Go on with a clock that has leapt, and tells some time by now."""
        assert self._told is not None
        if leap < self._told:
            self._before = self._offset
            self._offset += self._told - leap
        if leap < self._told or self._is_confirmed:
            self._remark(ClockLeapt(self._told, leap))
        self._told = told

    def _drop_leap(self) -> None:
        """Forget where the clock went to: the next one did not come from there."""
        if self._leap is not None and self._told is not None:
            self._remark(ClockDisbelieved(self._told, self._leap))
        self._leap = None

    def _remark(self, remark: QuadError) -> None:
        if len(self.remarks) < _MOST_REMARKS:
            self.remarks.append(remark)


def _follows(told: float, before: float) -> bool:
    """Return whether a time is one that a clock tells soon after another one."""
    return -_BACK <= told - before <= _FORWARD
