"""
Tells whether joints are at rest, by where they have been for a while.

A velocity alone says little: a joint that trembles about its place, as one without torque does
under a leg that stands, is measured at half a radian per second and gets nowhere. So joints are
at rest if their velocities are small, or if they have stayed where they are.
"""

from __future__ import annotations

from collections import deque

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

_WINDOW = 0.3
"""Time over which joints must have stayed where they are [s]."""

_LEAST_COUNT = 4
"""Number of measurements in it, at least."""


class RestCheck:
    """
    Remembers where the joints were of late.

    Parameters
    ----------
    robot : Robot
        The robot.
    rest_speed : float
        Joints slower than this are at rest, measured or by their displacement over a while [rad/s].
    """

    def __init__(self, robot: Robot, rest_speed: float) -> None:
        self._names = robot.joint_names
        self._rest_speed = rest_speed
        self._seen: deque[tuple[float, Array]] = deque()

    def forget(self) -> None:
        """Know nothing of the joints."""
        self._seen.clear()

    def take(self, time: float, positions: Array) -> None:
        """
        Take a measurement; one with the time of the last says nothing new.

        Parameters
        ----------
        time : float
            When it was taken [s].
        positions : ndarray, shape (12,)
            [rad]
        """
        seen = self._seen
        if seen and time < seen[-1][0]:
            seen.clear()
        if seen and time == seen[-1][0]:
            return
        seen.append((time, positions))
        # One is kept that is as old as the window, for it to be full.
        while len(seen) > 1 and seen[1][0] <= time - _WINDOW + 1e-9:
            seen.popleft()

    def is_at_rest(self, velocities: Array | None) -> bool:
        """
        Return whether the joints are at rest.

        Parameters
        ----------
        velocities : ndarray, shape (12,), or None
            As measured last [rad/s]; None if they are not measured.
        """
        if velocities is None or bool((np.abs(velocities) < self._rest_speed).all()):
            return True
        seen = self._seen
        if len(seen) < _LEAST_COUNT or seen[-1][0] - seen[0][0] < _WINDOW - 1e-9:
            return False
        return bool((self._displacements() < self._rest_speed * _WINDOW).all())

    def what_moves(self, velocities: Array | None) -> str:
        """Say which joint moves most, with its numbers, as measured last [rad/s]."""
        displacements = self._displacements()
        has_moved = bool(displacements.any())
        joint = int(
            np.argmax(displacements if velocities is None or has_moved else np.abs(velocities))
        )
        speed = '' if velocities is None else f', with {abs(velocities[joint]):.2f} rad/s now'
        return f'{self._names[joint]} by {displacements[joint]:.3f} rad within {_WINDOW:g} s{speed}'

    def _displacements(self) -> Array:
        """Return the range of each joint over the window, shape (12,) [rad]."""
        if not self._seen:
            return np.zeros(len(self._names))
        positions = np.array([positions for _, positions in self._seen])
        displacements: Array = np.ptp(positions, axis=0)
        return displacements
