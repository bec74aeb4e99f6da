"""
Where the feet of a trotting robot stood lately.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap

Array = NDArray[np.float64]

_KEPT = 8
"""Number of footholds that are kept."""


class Footholds:
    """Where the feet of a trotting robot stood lately, against which a map is held."""

    def __init__(self) -> None:
        # Places as odometry had them, shifts onto the map by then, heights of the feet's centers.
        self._records: Array = np.full((_KEPT, 5), math.nan)
        self._oldest = 0
        self._of_leg = [-1] * 4

    def note(self, places: Array, shift: Array, heights: Array, bears: NDArray[np.bool_]) -> bool:
        """
        Take notice of feet.

        Parameters
        ----------
        places : ndarray, shape (4, 2)
            Where they are, by odometry [m].
        shift : ndarray, shape (2,)
            From there to where that is on the map [m].
        heights : ndarray, shape (4,)
            Of their centers [m].
        bears : ndarray of bool, shape (4,)
            Which of them stand and bear load.

        Returns
        -------
        bool
            Whether one has come to stand, or has left.
        """
        has_changed = False
        for leg, stands in enumerate(bears.tolist()):
            if not stands:
                has_changed |= self._of_leg[leg] >= 0
                self._of_leg[leg] = -1
                continue
            if self._of_leg[leg] < 0:
                has_changed = True
                if self._oldest in self._of_leg:
                    self._of_leg[self._of_leg.index(self._oldest)] = -1
                self._of_leg[leg] = self._oldest
                self._oldest = (self._oldest + 1) % _KEPT
            self._records[self._of_leg[leg]] = *places[leg], *shift, heights[leg]
        return has_changed

    def forget_shifts(self) -> None:
        """Take all of them for where odometry had them."""
        self._records[:, 2:4] = 0.0

    def off(self, heights: HeightMap, radius: float) -> tuple[Array, Array]:
        """
        Return how much higher than a map's ground the soles stood, and than level ground.

        Parameters
        ----------
        heights : HeightMap
            The map.
        radius : float
            Of a foot's ball [m].

        Returns
        -------
        tuple of ndarray, shape (n,)
            Of the n footholds that the map knows, heights over the map, and over their mean [m].
        """
        places = self._records[:, :2] + self._records[:, 2:4]
        ground, slope = heights.height_at(places), heights.slope_at(places)
        known = np.isfinite(ground) & np.isfinite(slope).all(axis=1)
        over = radius * np.sqrt(1.0 + (slope[known] ** 2).sum(axis=1))
        centers = self._records[known, 4]
        return centers - over - ground[known], centers - centers.sum() / max(len(centers), 1)
