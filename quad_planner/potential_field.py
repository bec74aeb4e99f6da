"""
S1's potential functions: attraction to the goal, repulsion from round obstacles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import NoPathFound, ParameterError

Array = NDArray[np.float64]


@dataclass(frozen=True)
class RoundObstacle:
    """A disc on the floor."""

    x: float
    """[m]"""
    y: float
    """[m]"""
    radius: float
    """[m]"""


@dataclass(frozen=True)
class PotentialField:
    """
    U = U_att + U_rep (S1 eqs. 2 to 7); the defaults are those of S1 table I.

    Parameters
    ----------
    goal : tuple of float
        x and y [m].
    obstacles : sequence of RoundObstacle
        What repels.
    """

    goal: tuple[float, float]
    obstacles: Sequence[RoundObstacle]
    repulsion: float = 0.1
    """eta"""
    attraction: float = 1.0
    """zeta"""
    influence: float = 1.5
    """Obstacles farther away do not repel, Q* [m]."""
    goal_distance: float = 10.0
    """Farther from the goal the attraction does not grow, d*_goal [m]."""

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
        NoPathFound
            If the descent begins within an obstacle, comes to rest elsewhere, in a local
            minimum, or is too long.
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
                x, y = point
                raise NoPathFound(
                    start,
                    self.goal,
                    f'the descent of the potential comes to rest at ({x:.2f}, {y:.2f}) m, '
                    f'where attraction and repulsion are equal',
                )
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
