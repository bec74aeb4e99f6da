"""
Whether stamps rise, as those of a sensor must, and what becomes of those that do not.
"""

from __future__ import annotations

import math

from quad_common.errors import InvalidMessage


class StampOrder:
    """
    Refuses messages whose stamps do not rise, and takes a clock that was set to another time.

    One message from the past, or from far in the future, says nothing of the clock. Several in a
    row that agree with one another do: a recording begins again, a driver was restarted.

    Parameters
    ----------
    what : str
        What is stamped, for the errors' sentence.
    largest_step : float
        Farther ahead of the last one a stamp is not believed [s].
    patience : int
        So many stamps in a row that rise among themselves are believed, whatever came before.
    """

    def __init__(self, what: str, largest_step: float = math.inf, patience: int = 5) -> None:
        self._what = what
        self._largest_step = largest_step
        self._patience = patience
        self._last: float | None = None
        self._other: float | None = None
        self._agreeing = 0

    def check(self, stamp: float) -> bool:
        """
        Take the stamp of a message.

        Parameters
        ----------
        stamp : float
            Of the message [s].

        Returns
        -------
        bool
            Whether time goes on elsewhere than it did: what was known before is void.

        Raises
        ------
        InvalidMessage
            If it does not follow the last one.
        """
        last = self._last
        if last is None or self._follows(stamp, last):
            self._take(stamp)
            return False
        agrees = self._other is not None and self._follows(stamp, self._other)
        self._agreeing = self._agreeing + 1 if agrees else 1
        self._other = stamp
        if self._agreeing >= self._patience:
            self._take(stamp)
            return True
        latest = last + self._largest_step
        until = '' if math.isinf(latest) else f' and not after {latest:.3f} s'
        raise InvalidMessage(
            self._what, f'its stamp is {stamp:.3f} s; it must be after {last:.3f} s{until}'
        )

    def _follows(self, stamp: float, last: float) -> bool:
        return 0.0 < stamp - last <= self._largest_step

    def _take(self, stamp: float) -> None:
        self._last, self._other, self._agreeing = stamp, None, 0
