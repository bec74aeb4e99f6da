"""
What is known of the ground under a robot: the plane through its feet, and a height map.

Heights are measured from the feet that stand: so a map's own zero does not matter, nor
that of whoever says where the robot is.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap

Array = NDArray[np.float64]

_ALONG = 0.02
"""Distance between the points of a path at which a plane is evaluated [m]."""

_FLATTEST = 1e-3
"""Feet on a line give no plane: slopes across it are taken to be level; squared [m^2]."""


@dataclass(frozen=True)
class GroundModel:
    """
    Heights of the ground, relative to some level that its maker chose.

    A height map is believed where it knows a height, shifted so that it fits the feet;
    elsewhere the plane is.
    """

    center: Array
    """A point of the plane, shape (3,) [m]."""
    slope: Array
    """Rise of the plane along x and y, shape (2,)."""
    height_map: HeightMap | None = None
    """Height map of the ground; None if there is none."""
    shift: float = 0.0
    """Height that is added to the map's heights [m]."""
    map_error: float = 0.0
    """Distance by which the map may be off, along the ground [m]."""

    @classmethod
    def through(
        cls, points: Array, height_map: HeightMap | None = None, map_error: float = 0.0
    ) -> GroundModel:
        """
        Find the ground on which feet stand.

        Parameters
        ----------
        points : ndarray, shape (n, 3)
            Where they touch it, x and y in the map's frame, n > 0 [m].
        height_map : HeightMap, optional
            Of the ground.
        map_error : float
            Distance by which it may be off [m].

        Returns
        -------
        GroundModel
            With the plane that fits the points best, and the map shifted by the median of
            what it is off at them.
        """
        center = points.mean(axis=0)
        arms = points - center
        u, s, vt = np.linalg.svd(arms[:, :2], full_matrices=False)
        usable = s > np.sqrt(_FLATTEST)
        slope = vt[usable].T @ ((u[:, usable].T @ arms[:, 2]) / s[usable])
        shift = 0.0
        if height_map is not None:
            off = points[:, 2] - height_map.height_at(points[:, :2])
            known = off[np.isfinite(off)]
            if len(known):
                shift = float(np.median(known))
            else:
                height_map = None
        return cls(center, slope, height_map, shift, map_error)

    def height(self, points: Array) -> Array:
        """
        Return how high the ground is.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
            [m]

        Returns
        -------
        ndarray, shape (...)
            [m]
        """
        plane: Array = self.center[2] + (points - self.center[:2]) @ self.slope
        if self.height_map is None:
            return plane
        known = self.height_map.height_at(points) + self.shift
        return np.where(np.isnan(known), plane, known)

    def passage(self, start: Array, end: Array, radius: float) -> tuple[float, bool]:
        """
        Look along the straight path of a foot.

        Parameters
        ----------
        start, end : ndarray, shape (2,)
            From where to where it goes [m].
        radius : float
            Distance from the path within which the ground counts [m].

        Returns
        -------
        highest : float
            The largest height that the foot passes [m].
        is_known : bool
            Whether a map shows all of the path.
        """
        path, heights = self._path(start, end), self.height_map
        plane: Array = self.center[2] + (path - self.center[:2]) @ self.slope
        if heights is None:
            return float(np.max(plane)), False
        known = heights.height_at(path)
        is_unknown = np.isnan(known)
        highest = float(np.max(np.where(is_unknown, plane, known + self.shift)))
        reach = radius + self.map_error + heights.resolution / 2.0
        near = heights.highest_within(path, reach) + self.shift
        highest = max(highest, float(np.nanmax(near, initial=-np.inf)))
        return highest, not is_unknown.any()

    def highest_between(self, start: Array, end: Array, radius: float) -> float:
        """Return the largest height that a foot passes [m]; see :meth:`passage`."""
        return self.passage(start, end, radius)[0]

    def _path(self, start: Array, end: Array) -> Array:
        """Return points along a path, shape (n, 2) [m]."""
        # No farther apart than cells: a corner between two points is in the way all the same.
        apart = _ALONG if self.height_map is None else self.height_map.resolution
        count = 2 + int(np.hypot(*(end - start)) / apart)
        path: Array = start + np.linspace(0.0, 1.0, count)[:, None] * (end - start)
        return path

    def range_at(self, place: Array) -> tuple[float, float]:
        """
        Return between which heights the ground may be at a place.

        Parameters
        ----------
        place : ndarray, shape (2,)
            [m]

        Returns
        -------
        lowest, highest : float
            Its height twice where the map is not off; infinite where no map shows it [m].
        """
        heights = self.height_map
        height = np.nan if heights is None else float(heights.height_at(place)) + self.shift
        if heights is None or np.isnan(height):
            return -np.inf, np.inf
        if self.map_error == 0.0:
            return height, height
        lowest = float(heights.lowest_within(place, self.map_error)) + self.shift
        highest = float(heights.highest_within(place, self.map_error)) + self.shift
        return float(np.fmin(height, lowest)), float(np.fmax(height, highest))

    def best_foothold(self, wanted: Array, choice: FootholdChoice) -> Array:
        """
        Find the nearest place where a foot stands well: on no edge, in no hole, its shin free.

        Parameters
        ----------
        wanted : ndarray, shape (2,)
            Where it would stand on flat ground [m].
        choice : FootholdChoice
            How far to look, and for what.

        Returns
        -------
        ndarray, shape (2,)
            The place; the least rough one if none is good; the wanted one without a map.
        """
        heights = self.height_map
        if heights is None:
            return wanted
        offsets = choice.offsets
        places = wanted + offsets
        height = self.height(places)
        rough = heights.step_at(places, choice.radius + self.map_error)
        # What is not known is no good place, but for want of a better one.
        rough = np.where(np.isnan(rough), 2.0 * choice.largest_step, rough)
        off = np.abs(height - (self.center[2] + (places - self.center[:2]) @ self.slope))
        bad = np.maximum(rough - choice.largest_step, 0.0) + np.maximum(
            off - choice.largest_offset, 0.0
        )
        bad += _lack_of_room(heights, places, choice)
        order = np.lexsort((np.hypot(*offsets.T), np.round(bad, 4)))
        best: Array = places[order[0]]
        return best


def _lack_of_room(heights: HeightMap, places: Array, choice: FootholdChoice) -> Array:
    """Return by how much edges are too high, or too deep, so near to foot and shin, (n,) [m]."""
    if not len(choice.shin):
        return np.zeros(len(places))
    # Cells as they are: between them heights are interpolated, which hides edges.
    own = heights.highest_within(places, 0.0)
    near = choice.shin_radius + heights.resolution / 2.0
    beside = places[:, None] + choice.shin[:, :2]
    room = own[:, None] + choice.shin[:, 2] - heights.highest_within(beside, near)
    drop = np.nan_to_num(own - heights.lowest_within(places, near))
    too_deep = np.maximum(drop - choice.shin[:, 2].min(), 0.0)
    lack: Array = too_deep - np.nanmin(room, axis=1, initial=0.0)
    return lack


@dataclass(frozen=True)
class FootholdChoice:
    """Where a foot may stand."""

    reach: float
    """Distance from where it would stand on flat ground, at most [m]."""
    radius: float
    """Radius of the ground around it that counts [m]."""
    largest_step: float
    """Heights around it may differ by so much [m]."""
    largest_offset: float
    """Distance from the plane through the feet, at most [m]."""
    shin: Array = field(default_factory=lambda: np.empty((0, 3)))
    """
    Points on the middle of foot and shin while the foot stands, in all postures, from the point
    below the foot, shape (n, 3) [m].
    """
    shin_radius: float = 0.0
    """Ground so near to it must not be higher than it is [m]."""

    @property
    def offsets(self) -> Array:
        """Places to look at, relative to the wanted one, shape (n, 2) [m]."""
        side = np.linspace(-self.reach, self.reach, 9)
        grid = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
        inside: Array = grid[np.hypot(*grid.T) <= self.reach + 1e-12]
        return inside
