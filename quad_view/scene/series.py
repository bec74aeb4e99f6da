"""
What is plotted: the last seconds of some quantities.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Series:
    """
    Quantities over time, in a window that moves with it.

    Parameters
    ----------
    names : sequence of str
        Names of the quantities.
    span : float
        Width of the window [s].
    most : int
        Points that are kept.
    """

    def __init__(self, names: Sequence[str], span: float = 20.0, most: int = 200) -> None:
        self.names = tuple(names)
        self._span = span
        self._step = span / most
        self._rows: deque[tuple[float, ...]] = deque(maxlen=most)

    def add(self, time: float, values: Sequence[float]) -> None:
        """
        Note the quantities' values.

        Parameters
        ----------
        time : float
            Time of the measurement [s]; before the last one the plot begins anew.
        values : sequence of float
            One for each name; NaN where there is none.
        """
        if self._rows:
            last = self._rows[-1][0]
            if time < last:
                self._rows.clear()
            elif time - last < self._step:
                return
        self._rows.append((time, *values))
        while self._rows[0][0] < time - self._span:
            self._rows.popleft()

    def clear(self) -> None:
        """Begin anew."""
        self._rows.clear()

    def arrays(self) -> tuple[Array, ...]:
        """Return the times [s] and each quantity, arrays of one length; one point at least."""
        rows = self._rows or [(0.0, *(math.nan for _ in self.names))]
        return tuple(np.array(column) for column in zip(*rows, strict=True))
