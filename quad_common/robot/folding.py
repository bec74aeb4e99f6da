"""
How far a leg's knee may bend before calf or foot come near the leg's own hip or thigh.

The first joint turns all of a leg's parts together, so this depends on pitch and knee alone: it
is worked out once, on a grid of both.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot_shape import RobotShape

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

_BENDS, _PITCHES = 60, 31
"""Numbers of angles of knee and pitch that are tried."""


class FoldingLimits:
    """
    Says whether legs may touch themselves, without measuring.

    Parameters
    ----------
    shape : RobotShape
        The robot's parts.
    lower, upper : ndarray, shape (4, 3)
        Limits of the joints [rad].
    least : float
        Distance between parts that is too near if it is not kept [m].
    """

    def __init__(self, shape: RobotShape, lower: Array, upper: Array, least: float) -> None:
        self._shape = shape
        self._least = least
        self._lower = lower
        self._step = (upper - lower) / np.array([1.0, _PITCHES - 1, _BENDS - 1])

    def may_touch_at_all(self, joint_angles: Array) -> Mask:
        """Return which legs may come too near to themselves, of angles (n, 4, 3): (4,)."""
        mask: Mask = self._shape.legs.bends(joint_angles).max(axis=0) > self._allowed.min(axis=0)
        return mask

    def may_touch(self, joint_angles: Array) -> Mask:
        """Return which legs may come too near to themselves, and when: (n, 4) of (n, 4, 3)."""
        place = np.rint((joint_angles[..., 1] - self._lower[:, 1]) / self._step[:, 1])
        index = np.clip(place, 0, _PITCHES - 1).astype(int)
        allowed = self._allowed[index, np.arange(index.shape[1])]
        mask: Mask = self._shape.legs.bends(joint_angles) > allowed
        return mask

    @cached_property
    def _allowed(self) -> Array:
        """Largest bends of the knees, by the pitch, shape (_PITCHES, 4) [rad]."""
        shape, legs = self._shape, self._shape.legs
        bends, pitches = np.arange(_BENDS)[:, None], np.arange(_PITCHES)[:, None]
        postures = np.zeros((_BENDS, _PITCHES, len(self._lower), 3))
        postures[..., 1] = self._lower[:, 1] + pitches * self._step[:, 1]
        postures[..., 2] = (self._lower[:, 2] + bends * self._step[:, 2])[:, None]
        segments = shape.segments(legs.chain(postures))
        bends_of = legs.bends(postures)
        # No point of a calf moves farther than this to the nearest of the angles.
        bend, pitch = 0.5 * self._step[:, 2].max(), 0.5 * self._step[:, 1].max()
        calf = float(np.max(legs.calf_length))
        slack = bend * calf + pitch * (float(np.max(legs.thigh_length)) + calf)
        allowed = np.full((_PITCHES, len(self._lower)), np.inf)
        for group in shape.groups:
            if group.with_body or len(group.legs) > 1:
                continue
            leg = group.legs[0]
            near = shape.group_clearances(group, segments).min(axis=-1) < self._least + slack
            allowed[:, leg] = np.where(near, bends_of[:, :, leg], np.inf).min(axis=0)
        return allowed
