"""
How much dearer a way through a cell is than its length: one interface for all reasons.

A layer gives each cell a factor of at least 1. Factors of several layers are multiplied.
Where the robot must not be is another matter: that is the safety map's.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import ParameterError
from quad_planner.grid.inflated_map import InflatedMap
from quad_planner.potential.map_potential import boundary_distances

Floats = NDArray[np.float64]

LARGEST_FACTOR = 250.0
"""Ways are compared in whole numbers, which must not become too large."""


class CostLayer(Protocol):
    """A reason why ways through some cells are dearer."""

    def factors(self, safety: InflatedMap) -> Floats:
        """Return a factor for each cell, shape (height, width), at least 1."""


@dataclass(frozen=True)
class UnknownCost:
    """
    A way through cells of which nothing is known is dearer.

    Raises
    ------
    ParameterError
        If the factor is not from 1 to `LARGEST_FACTOR`.
    """

    factor: float

    def __post_init__(self) -> None:
        """Check the factor."""
        _check_factor(self.factor)

    def factors(self, safety: InflatedMap) -> Floats:
        """Return the factor in unknown cells, and 1 elsewhere."""
        return np.where(safety.grid.unknown(), self.factor, 1.0)


@dataclass(frozen=True)
class ClearanceCost:
    """
    A way beside the safety boundary is dearer: most at the boundary, less farther away.

    Raises
    ------
    ParameterError
        If the factor is not from 1 to `LARGEST_FACTOR`, or the distance not above 0.
    """

    factor: float
    """At the boundary."""
    distance: float
    """Farther from the boundary nothing is dearer [m]."""

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
        None if there is no layer: every way costs its length.

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
