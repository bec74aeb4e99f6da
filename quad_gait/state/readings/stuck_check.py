"""
Notices an imu that says the same over and over, though the robot moves.

A driver or a filter that hangs may go on to publish its last attitude, with new stamps: nothing
about it is impossible. But the attitude of a body that walks is not the same to the last digit for
long.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_PATIENCE = 2.0
"""Time for which an attitude is the same that is stuck [s]: some are rounded."""

_TURNED = 0.2
"""Angle by which a joint must have turned meanwhile [rad]: a robot that stands still proves
nothing."""


class StuckCheck:
    """Compares attitudes by an imu with one another, and with the joints."""

    def __init__(self) -> None:
        self._last: Array | None = None
        self._is_same = False
        self._since = math.nan
        self._joints: Array | None = None
        self._turned = 0.0
        self.problem = ''
        """That it is stuck, as a sentence; empty if it is not."""

    def take(self, orientation: Array | None) -> None:
        """Take an attitude, quaternion xyzw, shape (4,); None if the imu tells none."""
        last, self._last = self._last, orientation
        self._is_same = (
            orientation is not None and last is not None and np.array_equal(orientation, last)
        )
        if not self._is_same:
            self._since, self.problem = math.nan, ''

    def advance(self, time: float, joints: Array | None) -> bool:
        """Take joint positions, shape (n,) [rad], at a time [s]; return whether it is stuck."""
        if not self._is_same or joints is None:
            return False
        if math.isnan(self._since) or self._joints is None or time < self._since:
            self._since, self._joints, self._turned = time, joints, 0.0
        self._turned = max(self._turned, float(np.abs(joints - self._joints).max()))
        silence = time - self._since
        if silence >= _PATIENCE and self._turned > _TURNED:
            self.problem = (
                f'the imu has told the same attitude for {silence:.1f} s while joints turned by '
                f'{self._turned:.2f} rad'
            )
        return bool(self.problem)
