"""
S1's potential functions: attraction to the goal, repulsion from round obstacles.

On maps they are in :mod:`quad_planner.potential.map_potential`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import DescentStuck, NoPathFound, ParameterError

Array = NDArray[np.float64]

_FLAT = 1e-6
"""An eigenvalue is 0 if it is less than this part of the other, or of 1 / m^2."""


@dataclass(frozen=True)
class RoundObstacle:
    """A disc on the floor."""

    x: float
    """Coordinate x of the center [m]."""
    y: float
    """Coordinate y of the center [m]."""
    radius: float
    """Radius [m]."""


@dataclass(frozen=True)
class PotentialField:
    """
    U = U_att + U_rep (S1 eqs. 2 to 7); the defaults are those of S1 table I.

    Parameters
    ----------
    goal : tuple of float
        x and y [m].
    obstacles : sequence of RoundObstacle
        Obstacles that repel.
    """

    goal: tuple[float, float]
    """Coordinates of the goal [m]."""
    obstacles: Sequence[RoundObstacle]
    """Obstacles that repel."""
    repulsion: float = 0.1
    """eta"""
    attraction: float = 1.0
    """zeta"""
    influence: float = 1.5
    """Obstacles farther away do not repel, Q* [m]."""
    goal_distance: float = 10.0
    """Distance from the goal beyond which the attraction does not grow, d*_goal [m]."""

    def __post_init__(self) -> None:
        for name in ('repulsion', 'attraction', 'influence', 'goal_distance'):
            if not getattr(self, name) > 0.0:
                raise ParameterError(name, getattr(self, name), 'positive')
        if not np.all(np.isfinite(self.goal)):
            raise ParameterError('goal', self.goal, 'two finite numbers')

    def potential(self, point: Array) -> float:
        """
        Return U at a point (S1 eqs. 2, 3, 5 and 6).

        Parameters
        ----------
        point : ndarray, shape (2,)
            [m]

        Returns
        -------
        float
            Infinite within an obstacle.
        """
        away = float(np.hypot(*(point - self.goal)))
        reach = self.goal_distance
        if away <= reach:
            value = 0.5 * self.attraction * away**2
        else:
            value = reach * self.attraction * away - 0.5 * self.attraction * reach**2
        for obstacle in self.obstacles:
            distance = self._distance(point, obstacle)
            if distance <= 0.0:
                return np.inf
            if distance <= self.influence:
                value += 0.5 * self.repulsion * (1.0 / distance - 1.0 / self.influence) ** 2
        return value

    def gradient(self, point: Array) -> Array:
        """
        Return grad U at a point outside the obstacles (S1 eqs. 4, 5 and 7).

        Parameters
        ----------
        point : ndarray, shape (2,)
            [m]

        Returns
        -------
        ndarray, shape (2,)
            Pointing uphill.
        """
        from_goal = point - self.goal
        away = float(np.hypot(*from_goal))
        gradient: Array = self.attraction * from_goal
        if away > self.goal_distance:
            gradient = gradient * (self.goal_distance / away)
        for obstacle in self.obstacles:
            distance = self._distance(point, obstacle)
            if 0.0 < distance <= self.influence:
                outward = point - (obstacle.x, obstacle.y)
                outward = outward / np.hypot(*outward)
                push = self.repulsion * (1.0 / self.influence - 1.0 / distance) / distance**2
                gradient = gradient + push * outward
        return gradient

    def hessian(self, point: Array) -> Array:
        """
        Return the second derivatives of U at a point outside the obstacles.

        Parameters
        ----------
        point : ndarray, shape (2,)
            [m]

        Returns
        -------
        ndarray, shape (2, 2)
            Symmetric [1/m^2].
        """
        from_goal = point - self.goal
        away = float(np.hypot(*from_goal))
        hessian: Array = self.attraction * np.eye(2)
        if away > self.goal_distance:
            ray = from_goal / away
            hessian = (self.goal_distance / away) * (hessian - self.attraction * np.outer(ray, ray))
        eta, reach = self.repulsion, self.influence
        for obstacle in self.obstacles:
            distance = self._distance(point, obstacle)
            if 0.0 < distance <= reach:
                outward = point - (obstacle.x, obstacle.y)
                from_center = float(np.hypot(*outward))
                along = np.outer(outward, outward) / from_center**2
                # Derivatives of S1 eq. 3 by the distance, whose own Hessian is the circle's.
                slope = eta * (1.0 / reach - 1.0 / distance) / distance**2
                bend = eta * (3.0 / distance - 2.0 / reach) / distance**3
                hessian = hessian + bend * along + slope / from_center * (np.eye(2) - along)
        return hessian

    def descend(
        self,
        start: tuple[float, float],
        step: float = 0.02,
        tolerance: float = 0.02,
        longest: float = 100.0,
    ) -> Array:
        """
        Follow the falling gradient to the goal (S1 eq. 8, with its condition mended).

        Every step has the same length: S1 sec. IV.A cuts the path into steps of one
        length, and near obstacles a step in proportion to the gradient would jump.

        Parameters
        ----------
        start : tuple of float
            x and y [m].
        step : float
            Length of a step, S1's r [m].
        tolerance : float
            The goal is reached when it is this near [m].
        longest : float
            Longer paths are given up [m].

        Returns
        -------
        ndarray, shape (n, 2)
            From the start to the goal [m].

        Raises
        ------
        DescentStuck
            If the descent comes to rest elsewhere; it says where, and why.
        NoPathFound
            If the descent begins within an obstacle, or is too long.
        ParameterError
            If a length is not positive.
        """
        for name, value in (('step', step), ('tolerance', tolerance), ('longest', longest)):
            if not 0.0 < value < np.inf:
                raise ParameterError(name, value, 'positive and finite')
        point = np.array(start, dtype=float)
        if not self.potential(point) < np.inf:
            raise NoPathFound(start, self.goal, 'the start is within an obstacle')
        points = [point]
        goal = np.array(self.goal, dtype=float)
        for _ in range(int(np.ceil(longest / step))):
            if np.hypot(*(goal - point)) <= max(tolerance, step):
                points.append(goal)
                return np.array(points)
            gradient = self.gradient(point)
            size = float(np.hypot(*gradient))
            if size < 1e-6 or self._has_turned_back(points, step):
                kind, eigenvalues = critical_point(self.hessian(point))
                raise DescentStuck(start, self.goal, (point[0], point[1]), kind, eigenvalues)
            point = point - step * gradient / size
            points.append(point)
        raise NoPathFound(
            start, self.goal, f'the descent of the potential is longer than {longest:g} m'
        )

    @staticmethod
    def _has_turned_back(points: list[Array], step: float) -> bool:
        """Whether the last steps have led nowhere."""
        # An odd number of points: to and fro, an even number of steps leads nowhere.
        count = 21
        return len(points) > count and float(np.hypot(*(points[-1] - points[-count]))) < step

    @staticmethod
    def _distance(point: Array, obstacle: RoundObstacle) -> float:
        return float(np.hypot(point[0] - obstacle.x, point[1] - obstacle.y)) - obstacle.radius


def critical_point(hessian: Array) -> tuple[str, tuple[float, float]]:
    """
    Tell the kind of a critical point (S1 part II.C).

    Parameters
    ----------
    hessian : ndarray, shape (2, 2)
        Symmetric.

    Returns
    -------
    kind : str
        With its article.
    eigenvalues : tuple of float
        The smaller one first.
    """
    low, high = (float(value) for value in np.linalg.eigvalsh(hessian))
    flat = _FLAT * max(abs(low), abs(high), 1.0)
    if min(abs(low), abs(high)) <= flat:
        kind = 'a degenerate critical point'
    elif low > 0.0:
        kind = 'a local minimum'
    elif high < 0.0:
        kind = 'a local maximum'
    else:
        kind = 'a saddle point'
    return kind, (low, high)
