"""
Where each foot of a robot may stand, cell by cell of a lattice over a height map.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from quad_common.footing.foothold_criterion import FootholdCriterion, FootholdImages
from quad_common.maps.height_map import HeightMap
from quad_common.robot.robot import Robot
from quad_gait.footsteps.foothold_choice import keep_best
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.search_values import MOST_CELLS, Lattice
from quad_gait.uneven.uneven_options import UnevenOptions

Array = NDArray[np.float64]

Foothold = tuple[int, float, float]
"""Leg, and x and y of where its foot stands [m]."""


class FootholdMap:
    """
    Tells where feet may stand: on even ground, off edges, foot and shin free.

    Parameters
    ----------
    robot : Robot
        The robot.
    options : UnevenOptions
        How it walks.
    footsteps : FootstepOptions
        How footsteps are planned.
    heights : HeightMap
        Of the ground.
    """

    def __init__(
        self,
        robot: Robot,
        options: UnevenOptions,
        footsteps: FootstepOptions,
        heights: HeightMap,
    ) -> None:
        self._robot = robot
        self._footsteps = footsteps
        criterion = FootholdCriterion(
            options.foothold_reach, footsteps.radius, options.largest_step, options.shin_clearance
        )
        self._images = FootholdImages(robot, criterion, heights)
        self.shin_clearance = robot.relative_size * options.shin_clearance
        """Distance of shins from the ground [m]."""
        self.heights = heights
        """Of the ground."""
        self.blocked: list[Foothold] = []
        """Footholds that are kept out of all plans."""

    def is_fit(self, leg: int, points: Array, yaw: float) -> NDArray[np.bool_]:
        """
        Tell where a foot may stand.

        Parameters
        ----------
        leg : int
            Index of the leg.
        points : ndarray, shape (n, 2)
            Places on the ground [m].
        yaw : float
            Heading of the body [rad].

        Returns
        -------
        ndarray of bool, shape (n,)
            False where nothing is known, and off the map.
        """
        return self._images.is_fit(leg, points, yaw)

    def lattice(
        self,
        part: tuple[Array, Array],
        yaw: float,
        feet: Array,
        shift: float,
        block: int,
        without: Sequence[Foothold] = (),
    ) -> Lattice:
        """
        Lay a lattice over a part of the map.

        Parameters
        ----------
        part : pair of ndarray, shape (2,)
            Its lowest and its highest corner [m].
        yaw : float
            Heading of the body [rad].
        feet : ndarray, shape (4, 3)
            Centers of the feet at the start [m].
        shift : float
            Height that is added to the map's, so that it fits the feet [m].
        block : int
            Side of the squares of which each gives one foothold [cells].
        without : sequence of Foothold
            Footholds that are kept out of it, besides those that always are.

        Returns
        -------
        Lattice
            With cells as far apart as the options say; farther, where they would be too many.
        """
        side = self._robot.relative_size * self._footsteps.cell
        low, high = part
        area = float(np.prod(high - low))
        side = max(side, math.sqrt(area / (0.9 * MOST_CELLS)))
        # The same cells wherever the part begins: footholds stay where they are.
        first, last = np.floor(low / side).astype(int), np.ceil(high / side).astype(int)
        first -= first % block
        x, y = (side * np.arange(a, b + 1) for a, b in zip(first, last))
        points = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        fit = np.stack([self.is_fit(leg, points, yaw) for leg in range(4)]).astype(np.uint8)
        fit = fit.reshape(4, len(y), len(x))
        for leg, blocked_x, blocked_y in (*self.blocked, *without):
            near = np.hypot(points[:, 0] - blocked_x, points[:, 1] - blocked_y) < 1.5 * side
            fit[leg][near.reshape(fit[leg].shape)] = 0
        best = np.zeros_like(fit)
        keep_best(fit, block, best)
        z = np.nan_to_num(self.heights.height_at(points)) + shift + self._robot.foot_radius
        places = np.concatenate([np.column_stack([points, z]), feet])
        return Lattice(places, best, float(x[0]), float(y[0]), side)
