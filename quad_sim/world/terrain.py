"""
Ground that is not flat: a height field, and blocks with upright sides that stand in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import GroundUnknown, ParameterError
from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D

Array = NDArray[np.float64]

_EDGE = 1e-9
"""The edge of a block belongs to it [m]."""


@dataclass(frozen=True)
class Block:
    """
    A box with a level top, reaching down into the ground.

    Raises
    ------
    ParameterError
        If a field is not what its description says.
    """

    pose: Pose2D
    """Pose of its middle; the x axis is along its length."""
    length: float
    """Length along x [m]."""
    width: float
    """Width along y [m]."""
    top: float
    """Height of its top in the world [m]."""

    def __post_init__(self) -> None:
        """Check the fields."""
        if not self.pose.is_finite():
            raise ParameterError('pose', self.pose, 'finite')
        for name in ('length', 'width'):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, 'a finite number of metres above 0')
        if not math.isfinite(self.top):
            raise ParameterError('top', self.top, 'a finite number of metres')

    @property
    def outline(self) -> Array:
        """Corners in the world, counter-clockwise, shape (4, 2) [m]."""
        corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
        return self.pose.transform(corners * (self.length, self.width))

    def covers(self, points: Array) -> NDArray[np.bool_]:
        """Tell which points (..., 2) of the world are on the block or on its edge."""
        local = np.abs(self.pose.inverse().transform(points))
        inside: NDArray[np.bool_] = np.all(
            local <= (self.length / 2.0 + _EDGE, self.width / 2.0 + _EDGE), axis=-1
        )
        return inside


@dataclass(frozen=True)
class Terrain:
    """
    A height field and blocks; beyond the field the ground is level, at z = 0.

    Raises
    ------
    MapError
        If the field is not known everywhere.
    """

    field: HeightMap
    """The ground without blocks, known everywhere."""
    blocks: tuple[Block, ...] = ()

    def __post_init__(self) -> None:
        """Check the field."""
        unknown = int(np.isnan(self.field.heights).sum())
        if unknown:
            raise GroundUnknown(unknown, self.field.heights.size)

    @property
    def is_level(self) -> bool:
        """Whether there is nothing but blocks on a level floor at z = 0."""
        return not self.field.heights.any()

    @property
    def lowest(self) -> float:
        """Height of the lowest ground, beyond the field too [m]."""
        return min(0.0, float(self.field.heights.min()))

    @property
    def highest(self) -> float:
        """Height of the highest ground, beyond the field too [m]."""
        tops = (block.top for block in self.blocks)
        return max(0.0, float(self.field.heights.max()), *tops)

    @cached_property
    def height_map(self) -> HeightMap:
        """
        The ground as it is seen from above.

        A cell has the height of what is at its center, so that the upright side of a block lies
        between two cells, and is off by half a cell at most.
        """
        heights = self.field.heights.copy()
        x_min, y_min, _, _ = self.field.bounds
        resolution = self.field.resolution
        centers = self.field.centers
        shape = (self.field.columns, self.field.rows)
        for block in self.blocks:
            cells = (block.outline - (x_min, y_min)) / resolution
            low = np.clip(np.floor(cells.min(axis=0)).astype(int), 0, shape)
            high = np.clip(np.ceil(cells.max(axis=0)).astype(int), 0, shape)
            window = (slice(low[1], high[1]), slice(low[0], high[0]))
            covered = block.covers(centers[window])
            part = heights[window]
            part[covered] = np.maximum(part[covered], block.top)
        return self.field.with_heights(heights)

    def height_at(self, points: ArrayLike) -> Array:
        """
        Return how high the ground is, with the blocks' true edges.

        Parameters
        ----------
        points : array_like, shape (..., 2)
            x and y in the world [m].

        Returns
        -------
        ndarray, shape (...)
            [m]
        """
        points = np.asarray(points, dtype=float)
        heights = self.field.height_at(points, beyond=0.0)
        for block in self._blocks_near(points):
            heights = np.where(block.covers(points), np.maximum(heights, block.top), heights)
        return heights

    @cached_property
    def _circles(self) -> Array:
        """Around the blocks: x, y and radius, shape (n, 3) [m]."""
        return np.array(
            [(b.pose.x, b.pose.y, math.hypot(b.length, b.width) / 2.0) for b in self.blocks]
        ).reshape(-1, 3)

    def _blocks_near(self, points: Array) -> list[Block]:
        """Return the blocks that may be under one of the points."""
        if not self.blocks or points.size == 0:
            return []
        flat = points.reshape(-1, 2)
        low, high = flat.min(axis=0), flat.max(axis=0)
        middles, radii = self._circles[:, :2], self._circles[:, 2:] + _EDGE
        near = np.all((middles >= low - radii) & (middles <= high + radii), axis=1)
        return [self.blocks[index] for index in np.flatnonzero(near)]

    def span_under(self, outline: Array) -> tuple[float, float]:
        """
        Return the lowest and the highest ground under something that stands there.

        Parameters
        ----------
        outline : ndarray, shape (n, 2)
            Of its footprint [m].

        Returns
        -------
        lowest, highest : float
            Within the upright box around the footprint [m].
        """
        low, high = outline.min(axis=0), outline.max(axis=0)
        count = np.ceil((high - low) / self.field.resolution).astype(int) + 1
        x, y = (np.linspace(a, b, int(n)) for a, b, n in zip(low, high, count))
        heights = self.height_map.height_at(np.stack(np.meshgrid(x, y), axis=-1), beyond=0.0)
        return float(heights.min()), float(heights.max())
