"""
Notices an imu that says the same over and over, though the robot moves.

A driver or a filter that hangs may go on to publish its last attitude, with new stamps: nothing
about it is impossible. But the attitude of a body that walks is not the same to the last digit for
long; but for an ideal one, as simulators without physics tell: that is level to the last digit, and
odometry tells nothing else.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.rotations import tilt_from_quaternion

Array = NDArray[np.float64]

_PATIENCE = 2.0
"""Time for which an attitude is the same that is stuck [s]: some are rounded."""

_TURNED = 0.2
"""Angle by which a joint must have turned meanwhile [rad]: a robot that stands still proves
nothing."""

_TILTED = math.radians(3.0)
"""Tilt of a body by its odometry that is not ideally level [rad]."""

_ROUNDING = 1e-6
"""Tilt by which an attitude that is level may be off [rad]."""


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

    def advance(self, time: float, joints: Array | None, odometry: Array) -> bool:
        """
        Let time go on.

        Parameters
        ----------
        time : float
            Now [s].
        joints : ndarray, shape (n,), or None
            Positions of the joints, if they are known [rad].
        odometry : ndarray, shape (4,)
            Attitude by odometry, quaternion xyzw.

        Returns
        -------
        bool
            Whether the imu is stuck.
        """
        if not self._is_same or joints is None or self._is_ideal(odometry):
            return False
        if math.isnan(self._since) or self._joints is None or time < self._since:
            self._since, self._joints, self._turned = time, joints, 0.0
        self._turned = max(self._turned, float(np.abs(joints - self._joints).max()))
        silence = time - self._since
        if silence >= _PATIENCE and self._turned > _TURNED:
            self.problem = (
                f'the imu has told the same attitude for {silence:.1f} s though joints turn'
            )
        return bool(self.problem)

    def _is_ideal(self, odometry: Array) -> bool:
        """Return whether the body is exactly level, and odometry does not say otherwise."""
        assert self._last is not None
        is_level = tilt_from_quaternion(self._last) < _ROUNDING
        return is_level and tilt_from_quaternion(odometry) < _TILTED
