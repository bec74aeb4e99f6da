"""
Tells measurements that belong together from those that do not.

A sensor's readings follow one another in time, and differ by no more than the robot moves
meanwhile. A reading that does not fit is refused. Where refused readings fit one another for a
while, it is the robot that was moved, or the clock that was set: they are the series from then on.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from quad_common.errors import InvalidMessage

Value = TypeVar('Value')

LONGEST_GAP = 5.0
"""Time between two readings of a series, at most [s]; many times faster than real time a short
pause of the machine is that long."""

LEAST_TIME = 0.2
"""Time that readings fit one another before they are a series of their own [s]."""

LEAST_COUNT = 5
"""Number of readings of such a series, at least."""


class Taken(enum.Enum):
    """What became of a reading."""

    FITS = 'fits'
    """It goes on with the series."""
    REPEATED = 'repeated'
    """It has the time of the one before: nothing new."""
    NEW_SERIES = 'new series'
    """With those before it, it replaces the series: the robot was moved, or the clock was set."""


@dataclass
class _Run(Generic[Value]):
    """Readings that fit one another."""

    began: float
    time: float
    value: Value
    count: int = 1


class SeriesCheck(Generic[Value]):
    """
    Refuses what does not fit a series.

    Parameters
    ----------
    what : str
        Name of the readings, for the sentence of a refusal.
    difference : callable
        Takes two values and the time between them [s]; returns what makes it impossible that
        one follows the other, as a clause, or nothing.
    """

    def __init__(self, what: str, difference: Callable[[Value, Value, float], str]) -> None:
        self._what = what
        self._difference = difference
        self._run: _Run[Value] | None = None
        self._rival: _Run[Value] | None = None

    @property
    def time(self) -> float | None:
        """When the last reading of the series was taken [s]; None before the first."""
        return None if self._run is None else self._run.time

    def take(self, time: float, value: Value) -> Taken:
        """
        Take a reading.

        Parameters
        ----------
        time : float
            When it was taken [s].
        value : Value
            What was read.

        Returns
        -------
        Taken
            What became of it.

        Raises
        ------
        InvalidMessage
            If it does not fit, and is left out.
        """
        run = self._run
        if run is None:
            self._run = _Run(time, time, value)
            return Taken.FITS
        if time == run.time:
            return Taken.REPEATED
        rival = self._rival
        problem = self._problem(run, run.time if rival is None else rival.time, time, value)
        if not problem:
            self._rival = None
            run.time, run.value = time, value
            return Taken.FITS
        if rival is None or (time != rival.time and self._problem(rival, rival.time, time, value)):
            self._rival = _Run(time, time, value)
        elif time != rival.time:
            rival.time, rival.value = time, value
            rival.count += 1
            if rival.count >= LEAST_COUNT and time - rival.began >= LEAST_TIME:
                self._run, self._rival = rival, None
                return Taken.NEW_SERIES
        raise InvalidMessage(self._what, problem)

    def _problem(self, run: _Run[Value], seen: float, time: float, value: Value) -> str:
        """
        Say why a reading does not follow the last one of a run.

        Only in silence it may have moved farther: readings that were refused since, the last one
        at the time ``seen``, are none.
        """
        dt = time - run.time
        if dt < 0.0:
            return f'its time {time:.3f} s is before that of the last one, {run.time:.3f} s'
        if dt > LONGEST_GAP:
            return (
                f'its time {time:.3f} s is {dt:.3g} s after that of the last one; readings are '
                f'{LONGEST_GAP:g} s apart at most, unless they go on like that for '
                f'{LEAST_TIME:g} s'
            )
        return self._difference(run.value, value, min(dt, abs(time - seen)))
