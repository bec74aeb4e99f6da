"""
S1's potential functions on a map: attraction to the goal, repulsion from what is nearest.

The obstacle of S1 eqs. 3 and 4 is the safety boundary: there the potential has no bound,
so the descent keeps the clearance. The distance to it is that to the nearest obstacle, by
an exact distance transform, less the clearance: the cells of the forbidden zone, as an
approximation of the boundary, would make a rougher potential, with more local minima. It
changes linearly between the centers of cells.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_common.compiled import compiled_loop, compiled_part
from quad_common.errors import ParameterError
from quad_planner.grid.array_types import Points
from quad_planner.grid.bit_grid import BitMask, Bits
from quad_planner.grid.line_of_sight import sees
from quad_planner.potential.potential_field import critical_point

Floats = NDArray[np.float64]

_STEP = 0.5
"""Longest step of the descent [cells]."""
_SHORTEST = 1.0 / 128.0
"""Shortest step down the gradient that is tried [cells]."""
_DIRECTIONS = 16
"""Number of directions in which the descent looks before it rests."""
_LOWER = 1.0 - 1e-9
"""Factor below which a potential counts as lower, and not as rounded."""
_PATIENCE = 400
"""Number of steps that must lead farther than one does, or it is at rest as well."""
_LEAST_DISTANCE = 0.02
"""Distance from the boundary within which the potential rises evenly [cells]."""

_UNDER_WAY, _ARRIVED, _AT_REST = range(3)


class Gains(NamedTuple):
    """The constants of S1 table I, and its values."""

    repulsion: float = 0.1
    """eta"""
    attraction: float = 1.0
    """zeta"""
    influence: float = 1.5
    """Distance from the safety boundary beyond which nothing repels, Q* [m]."""
    goal_distance: float = 10.0
    """Distance from the goal beyond which the attraction does not grow, d*_goal [m]."""

    def check(self) -> None:
        """Raise `ParameterError` if one is not positive and finite."""
        for name, value in self._asdict().items():
            if not 0.0 < value < math.inf:
                raise ParameterError(name, value, 'positive and finite')


def boundary_distances(
    blocked: BitMask, clearance_radius: float, resolution: float, farthest: float = math.inf
) -> Floats:
    """
    Measure how far the center of each cell is from the safety boundary, up to a distance.

    Parameters
    ----------
    blocked : BitMask
        The blocked cells.
    clearance_radius : float
        Distance from blocked cells to the boundary, >= 0 [m].
    resolution : float
        Side of a cell [m].
    farthest : float
        Cells that are farther are at this distance [m].

    Returns
    -------
    ndarray, shape (height, width)
        Distances from the middle of the nearest blocked cell's side, less the radius [m].
    """
    # Imported late: other methods can do without.
    import cv2

    mask = blocked.unpacked()
    if not mask.any():
        return np.full(mask.shape, farthest)
    free = (~mask).astype(np.uint8)
    centers = cv2.distanceTransform(free, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
    distances: Floats = np.multiply(centers, resolution, dtype=np.float64)
    distances -= 0.5 * resolution + clearance_radius
    np.minimum(distances, farthest, out=distances)
    return distances


def boundary_distances_anew(
    distances: Floats,
    blocked: BitMask,
    clearance_radius: float,
    resolution: float,
    farthest: float,
    changed: tuple[int, int],
) -> Floats:
    """
    Measure them again where blocked cells have changed.

    Parameters
    ----------
    distances : ndarray, shape (height, width)
        Distances that :func:`boundary_distances` found for the cells as they were [m].
    blocked, clearance_radius, resolution, farthest
        As for :func:`boundary_distances`.
    changed : tuple of int
        Rows in which cells have changed: from the first up to, but without, the second.

    Returns
    -------
    ndarray, shape (height, width)
        Distances that :func:`boundary_distances` would find.
    """
    far = math.ceil((farthest + clearance_radius) / resolution + 0.5)
    first, last = max(changed[0] - far, 0), min(changed[1] + far, blocked.height)
    below, above = max(first - far, 0), min(last + far, blocked.height)
    band = BitMask(blocked.words[below:above], blocked.width)
    near = boundary_distances(band, clearance_radius, resolution, farthest)
    renewed = distances.copy()
    renewed[first:last] = near[first - below : last - below]
    return renewed


@dataclass(frozen=True, eq=False)
class MapPotential:
    """U = U_att + U_rep on a map (S1 eqs. 2 to 7), with the nearest obstacle alone."""

    forbidden: BitMask
    """Cells where the robot's center must not be."""
    distances: Floats
    """Distances from :func:`boundary_distances` [m]."""
    resolution: float
    """Side of a cell [m]."""
    goal: Points
    """Place of the goal, shape (2,) [cells]."""
    gains: Gains = field(default_factory=Gains)
    """Gains of attraction and repulsion."""

    @cached_property
    def _arguments(self) -> tuple[Floats, float, float, float, Gains]:
        x, y = self.goal.tolist()
        return self.distances, self.resolution, x, y, self.gains

    def potential(self, point: Points) -> float:
        """
        Return U at a point (S1 eqs. 2, 3, 5 and 6).

        Parameters
        ----------
        point : ndarray, shape (2,)
            On the map [cells].

        Returns
        -------
        float
            Finite everywhere; it falls evenly out of the forbidden zone.
        """
        return float(_potential(*self._arguments, float(point[0]), float(point[1])))

    def gradient(self, point: Points) -> Floats:
        """
        Return grad U at a point (S1 eqs. 4, 5 and 7).

        Parameters
        ----------
        point : ndarray, shape (2,)
            On the map [cells].

        Returns
        -------
        ndarray, shape (2,)
            Pointing uphill, along the map's axes [1/m].
        """
        return np.array(_gradient(*self._arguments, float(point[0]), float(point[1])))

    def hessian(self, point: Points) -> Floats:
        """
        Return the second derivatives of U about a point, by differences over a cell.

        Parameters
        ----------
        point : ndarray, shape (2,)
            On the map [cells].

        Returns
        -------
        ndarray, shape (2, 2)
            Symmetric, along the map's axes [1/m^2].
        """
        columns = []
        for axis in (np.array([0.5, 0.0]), np.array([0.0, 0.5])):
            rise = self.gradient(point + axis) - self.gradient(point - axis)
            columns.append(rise / self.resolution)
        slopes = np.array(columns)
        return np.asarray(0.5 * (slopes + slopes.T))

    def critical_point(self, point: Points) -> tuple[str, tuple[float, float]]:
        """Tell the kind of a critical point, as :func:`potential_field.critical_point`."""
        return critical_point(self.hessian(point))

    def descend(
        self, start: Points, check: Callable[[], None] = lambda: None
    ) -> tuple[Points, bool]:
        """
        Follow the falling gradient (S1 eq. 8, with its condition mended).

        U falls with every step: one that would lead up, or out of the allowed cells, is
        halved until it does not. Distances to squares have kinks, where no step down the
        gradient may be left: there it looks around before it rests.

        Parameters
        ----------
        start : ndarray, shape (2,)
            In an allowed cell [cells].
        check : callable
            Called again and again; raises to end the descent.

        Returns
        -------
        points : ndarray, shape (n, 2)
            From the start to the goal, or to where the descent comes to rest [cells].
        has_arrived : bool
            Whether it is the goal.
        """
        points = np.empty((4096, 2))
        points[0] = start
        parts, outcome = [], _UNDER_WAY
        while outcome == _UNDER_WAY:
            count, outcome = _descend(*self._arguments, self.forbidden.words, points)
            parts.append(points[: count - 1].copy())
            points[0] = points[count - 1]
            check()
        return np.concatenate([*parts, points[:1]]), outcome == _ARRIVED


@compiled_part
def _distance(distances: Floats, x: float, y: float) -> tuple[float, float, float]:
    """Return the distance between the centers [m], and its slopes along x and y [m/cell]."""
    height, width = distances.shape
    u, v = min(max(x - 0.5, 0.0), width - 1.0), min(max(y - 0.5, 0.0), height - 1.0)
    left, below = min(int(u), max(width - 2, 0)), min(int(v), max(height - 2, 0))
    right, above = min(left + 1, width - 1), min(below + 1, height - 1)
    a, b = distances[below, left], distances[below, right]
    c, d = distances[above, left], distances[above, right]
    if a == np.inf:
        return np.inf, 0.0, 0.0
    u -= left
    v -= below
    low, high = a + u * (b - a), c + u * (d - c)
    return low + v * (high - low), (1.0 - v) * (b - a) + v * (d - c), high - low


@compiled_loop
def _potential(
    distances: Floats,
    resolution: float,
    goal_x: float,
    goal_y: float,
    gains: Gains,
    x: float,
    y: float,
) -> float:
    """Return U at a point [cells]."""
    away = resolution * np.hypot(x - goal_x, y - goal_y)
    reach = gains.goal_distance
    if away <= reach:
        value = 0.5 * gains.attraction * away**2
    else:
        value = gains.attraction * reach * (away - 0.5 * reach)
    distance = _distance(distances, x, y)[0]
    if distance <= gains.influence:
        least = max(distance, _LEAST_DISTANCE * resolution)
        nearness = 1.0 / least - 1.0 / gains.influence
        value += 0.5 * gains.repulsion * nearness**2
        value += gains.repulsion * nearness / least**2 * (least - distance)
    return float(value)


@compiled_loop
def _gradient(
    distances: Floats,
    resolution: float,
    goal_x: float,
    goal_y: float,
    gains: Gains,
    x: float,
    y: float,
) -> tuple[float, float]:
    """Return grad U at a point [cells], along x and y [1/m]."""
    along, across = resolution * (x - goal_x), resolution * (y - goal_y)
    away = np.hypot(along, across)
    pull = gains.attraction
    if away > gains.goal_distance:
        pull *= gains.goal_distance / away
    distance, slope_x, slope_y = _distance(distances, x, y)
    push = 0.0
    if distance <= gains.influence:
        least = max(distance, _LEAST_DISTANCE * resolution)
        push = gains.repulsion * (1.0 / gains.influence - 1.0 / least) / least**2 / resolution
    return pull * along + push * slope_x, pull * across + push * slope_y


@compiled_part
def _lower(
    distances: Floats,
    resolution: float,
    goal_x: float,
    goal_y: float,
    gains: Gains,
    forbidden: Bits,
    x: float,
    y: float,
    new_x: float,
    new_y: float,
) -> float:
    """Return U at a point to which one may step, else infinity [cells]."""
    height, width = distances.shape
    if not (0.0 <= new_x <= width and 0.0 <= new_y <= height):
        return np.inf
    if not sees(forbidden, width, x, y, new_x, new_y):
        return np.inf
    return _potential(distances, resolution, goal_x, goal_y, gains, new_x, new_y)


@compiled_loop
def _descend(
    distances: Floats,
    resolution: float,
    goal_x: float,
    goal_y: float,
    gains: Gains,
    forbidden: Bits,
    points: Points,
) -> tuple[int, int]:
    """Go on from the first point, fill in others; return how many there are, and why it ends."""
    width = distances.shape[1]
    x, y = points[0]
    value = _potential(distances, resolution, goal_x, goal_y, gains, x, y)
    for count in range(1, len(points)):
        is_near = np.hypot(goal_x - x, goal_y - y) <= 2.0 * _STEP
        if is_near and sees(forbidden, width, x, y, goal_x, goal_y):
            points[count] = goal_x, goal_y
            return count + 1, _ARRIVED
        slope_x, slope_y = _gradient(distances, resolution, goal_x, goal_y, gains, x, y)
        angle = np.arctan2(-slope_y, -slope_x)
        lower, new_x, new_y = value, x, y
        # Down the gradient; where the potential has a kink, down the best direction around.
        step = _STEP
        while lower >= value and step >= _SHORTEST:
            new_x, new_y = x + step * np.cos(angle), y + step * np.sin(angle)
            lower = _lower(
                distances, resolution, goal_x, goal_y, gains, forbidden, x, y, new_x, new_y
            )
            step *= 0.5
        if lower >= value:
            for k in range(2 * _DIRECTIONS):
                step = _STEP if k < _DIRECTIONS else 2.0 * _STEP
                angle = 2.0 * np.pi * k / _DIRECTIONS
                u, v = x + step * np.cos(angle), y + step * np.sin(angle)
                there = _lower(distances, resolution, goal_x, goal_y, gains, forbidden, x, y, u, v)
                if there < min(lower, value * _LOWER):
                    lower, new_x, new_y = there, u, v
        if lower >= value:
            return count, _AT_REST
        x, y, value = new_x, new_y, lower
        points[count] = x, y
        before = points[max(count - _PATIENCE, 0)]
        if count >= _PATIENCE and np.hypot(x - before[0], y - before[1]) < _STEP:
            return count + 1, _AT_REST
    return len(points), _UNDER_WAY
