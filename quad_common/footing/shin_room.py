"""
Whether shins have room over a map of the ground, wherever body and feet are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ShinTooNear
from quad_common.footing.shin import points_on_shins
from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS

Array = NDArray[np.float64]


class ShinRoom:
    """
    Looks at shins over the ground.

    Parameters
    ----------
    robot : Robot
        The robot.
    clearance : float
        Distance of shins from the ground [m].
    heights : HeightMap
        Of the ground.
    shift : float
        Height that is added to the map's [m].
    """

    def __init__(
        self, robot: Robot, clearance: float, heights: HeightMap, shift: float = 0.0
    ) -> None:
        self._robot, self._heights, self._shift = robot, heights, shift
        self._near = robot.foot_radius + clearance + heights.resolution / 2.0

    def points(self, positions: Array, rotations: Array, feet: Array) -> Array:
        """
        Place points on all shins.

        Parameters
        ----------
        positions : ndarray, shape (n, 3)
            Where the body is [m].
        rotations : ndarray, shape (n, 3, 3)
            From its axes to the frame's.
        feet : ndarray, shape (n, 4, 3)
            Centers of the feet [m].

        Returns
        -------
        ndarray, shape (n, 4, m, 3)
            Foot first [m]; NaN beyond a leg's reach.
        """
        arms = np.einsum('nji,nkj->nki', rotations, feet - positions[:, None])
        points = np.einsum('nij,nkmj->nkmi', rotations, points_on_shins(self._robot, arms))
        placed: Array = points + positions[:, None, None]
        return placed

    def check(self, position: Array, rotation: Array, stances: Array) -> None:
        """
        Raise ShinTooNear if a shin is nearer to the ground than the clearance in any stance.

        Parameters
        ----------
        position : ndarray, shape (3,)
            Where the body is [m].
        rotation : ndarray, shape (3, 3)
            From its axes to the frame's.
        stances : ndarray, shape (n, 4, 3)
            Centers of the feet [m].
        """
        positions = np.broadcast_to(position, (len(stances), 3))
        rotations = np.broadcast_to(rotation, (len(stances), 3, 3))
        touched = self.touched(self.points(positions, rotations, stances)).any(axis=0)
        if touched.any():
            raise ShinTooNear(LEGS[int(np.argmax(touched))])

    def touched(self, points: Array) -> NDArray[np.bool_]:
        """
        Tell which shins touch the ground.

        Parameters
        ----------
        points : ndarray, shape (n, 4, m, 3)
            As :meth:`points` places them [m].

        Returns
        -------
        ndarray of bool, shape (n, 4)
            False where nothing is known of the ground, and beyond a leg's reach.
        """
        is_there: NDArray[np.bool_] = np.all(np.isfinite(points), axis=(2, 3))
        places = np.where(is_there[..., None, None], points[..., :2], 0.0)
        ground = self._heights.highest_within(places, self._near) + self._shift
        touched: NDArray[np.bool_] = np.any(ground > points[..., 2], axis=2) & is_there
        return touched
