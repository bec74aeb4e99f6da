"""
By which factor a path through a cell costs more than its length: one interface for all reasons.

A layer gives each cell a factor of at least 1. Factors of several layers are multiplied.
Where the robot must not be is another matter: that is the inflated map's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_common.maps.occupancy_grid import FREE
from quad_planner.costs.ground_difficulty import difficulty
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.potential.map_potential import boundary_distances

Floats = NDArray[np.float64]

LARGEST_FACTOR = 250.0
"""Costs of paths are compared as whole numbers, which must not become too large."""


MOST_COST = 99
"""Value of a costmap's cells, on the topics of Nav2, in which the robot's center would collide."""


class CostLayer(Protocol):
    """A reason why paths through some cells cost more than their length."""

    def factors(self, safety: InflatedMap) -> Floats:
        """Return a factor for each cell, shape (height, width), at least 1."""


@dataclass(frozen=True)
class UnknownCost:
    """
    Makes paths through unknown cells cost more than their length.

    Raises
    ------
    ParameterError
        If the factor is not from 1 to `LARGEST_FACTOR`.
    """

    factor: float
    """Factor by which a path through unknown cells costs more."""

    def __post_init__(self) -> None:
        """Check the factor."""
        _check_factor(self.factor)

    def factors(self, safety: InflatedMap) -> Floats:
        """Return the factor in unknown cells, and 1 elsewhere."""
        return np.where(safety.grid.unknown(), self.factor, 1.0)


@dataclass(frozen=True)
class ClearanceCost:
    """
    Makes paths near the safety boundary cost more than their length, most at the boundary.

    Raises
    ------
    ParameterError
        If the factor is not from 1 to `LARGEST_FACTOR`, or the distance not above 0.
    """

    factor: float
    """Factor at the boundary."""
    distance: float
    """Distance from the boundary beyond which the factor is 1 [m]."""

    def __post_init__(self) -> None:
        """Check the numbers."""
        _check_factor(self.factor)
        if not (math.isfinite(self.distance) and self.distance > 0.0):
            raise ParameterError('distance', self.distance, 'a finite length above 0 m')

    def factors(self, safety: InflatedMap) -> Floats:
        """Return factors that fall in proportion to the distance from the boundary."""
        away = boundary_distances(
            safety.blocked_bits,
            safety.clearance_radius,
            safety.grid.resolution,
            farthest=self.distance,
        )
        nearness = np.clip(1.0 - away / self.distance, 0.0, 1.0)
        factors: Floats = 1.0 + (self.factor - 1.0) * nearness
        return factors


@dataclass(frozen=True)
class MapCost:
    """
    Makes paths through cells with a value cost more, as costmaps mean it.

    Raises
    ------
    ParameterError
        If the factor is not from 1 to `LARGEST_FACTOR`.
    """

    factor: float
    """Factor at `MOST_COST`; less in proportion below it, and 1 where the value is 0 or unknown."""

    def __post_init__(self) -> None:
        """Check the factor."""
        _check_factor(self.factor)

    def factors(self, safety: InflatedMap) -> Floats:
        """Return factors that rise in proportion to the values of the map."""
        values = np.clip(safety.grid.cells, FREE, MOST_COST)
        factors: Floats = 1.0 + (self.factor - 1.0) * values / MOST_COST
        return factors


@dataclass(frozen=True)
class GroundCost:
    """
    Makes paths over rough and steep ground cost more than their length.

    Raises
    ------
    ParameterError
        If a factor is not from 1 to `LARGEST_FACTOR`.
    """

    roughness: float
    """Factor on ground as rough as a step of the step height; less, where it is smoother."""
    slope: float
    """Factor on ground of the largest slope that is walked on; less, where it is more level."""

    needs_ground: ClassVar[bool] = True
    """Whether the layer asks for the ground under the map."""

    def __post_init__(self) -> None:
        """Check the factors."""
        _check_factor(self.roughness)
        _check_factor(self.slope)

    def factors(self, safety: InflatedMap) -> Floats:
        """Return factors that rise in proportion to roughness and slope; 1 on unknown ground."""
        ground = difficulty(safety.grid)
        if ground is None:
            return np.ones(safety.grid.cells.shape)
        factors = np.empty(ground.slope.shape)
        # Row by row, without arrays as large between.
        for row, rough, steep in zip(factors, ground.roughness, ground.slope):
            row[:] = 1.0 + (self.roughness - 1.0) * rough.astype(np.float64)
            row *= 1.0 + (self.slope - 1.0) * steep.astype(np.float64)
        return factors


def cell_costs(layers: Sequence[CostLayer], safety: InflatedMap) -> Floats | None:
    """
    Multiply the factors of layers.

    Parameters
    ----------
    layers : sequence of CostLayer
        The reasons.
    safety : InflatedMap
        The map.

    Returns
    -------
    ndarray, shape (height, width), or None
        None if there is no layer: every path costs its length.

    Raises
    ------
    ParameterError
        If a layer has a factor below 1, or the product is above `LARGEST_FACTOR`.
    """
    if not layers:
        return None
    product = np.ones((safety.grid.height, safety.grid.width))
    for layer in layers:
        product *= layer.factors(safety)
    for extreme in (float(product.min()), float(product.max())):
        _check_factor(extreme)
    return product


def _check_factor(factor: float) -> None:
    if not 1.0 <= factor <= LARGEST_FACTOR:
        raise ParameterError('factor', factor, f'from 1 to {LARGEST_FACTOR:g}')
