"""
The world around the robot: the ground, walls extruded from a map, and obstacles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MapBoundsUnusable, ParameterError
from quad_common.maps.occupancy_grid import MAX_CELLS, OCCUPIED, OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.vision.markers import Color, check_color
from quad_sim.world.terrain import Terrain

Array = NDArray[np.float64]

KINDS = ('box', 'cylinder')
"""Kinds of obstacles."""


OF_WORLD = 'room'
"""The namespace in the names of the obstacles that a world begins with."""


@dataclass(frozen=True)
class Obstacle:
    """
    A box or an upright cylinder that stands on the ground.

    Raises
    ------
    ParameterError
        If a field is not what its description says.
    """

    kind: str
    """One of :data:`KINDS`."""
    pose: Pose2D
    """Pose of its middle; the x axis is along its length."""
    length: float
    """Length of a box along x; a cylinder's diameter [m]."""
    width: float
    """Width of a box along y; a cylinder's diameter [m]."""
    height: float
    """Height above the ground at its middle [m]."""
    color: Color | None = None
    """That of all obstacles if None."""

    def __post_init__(self) -> None:
        """Check the fields."""
        if self.kind not in KINDS:
            raise ParameterError('kind', self.kind, f'one of {", ".join(KINDS)}')
        if not self.pose.is_finite():
            raise ParameterError('pose', self.pose, 'finite')
        for name in ('length', 'width', 'height'):
            value = getattr(self, name)
            if not (math.isfinite(value) and value > 0.0):
                raise ParameterError(name, value, 'a finite number of metres above 0')
        if self.kind == 'cylinder' and not math.isclose(self.length, self.width):
            raise ParameterError('width', self.width, f"the cylinder's length, {self.length}")
        if self.color is not None:
            check_color('color', self.color)

    @classmethod
    def box(
        cls, pose: Pose2D, length: float, width: float, height: float, color: Color | None = None
    ) -> Obstacle:
        """Make a box; sizes in metres."""
        return cls('box', pose, length, width, height, color)

    @classmethod
    def cylinder(
        cls, x: float, y: float, radius: float, height: float, color: Color | None = None
    ) -> Obstacle:
        """Make a cylinder; place and sizes in metres."""
        return cls('cylinder', Pose2D(x, y, 0.0), 2.0 * radius, 2.0 * radius, height, color)

    @property
    def outer_radius(self) -> float:
        """Radius of the circle around its middle that holds the footprint [m]."""
        if self.kind == 'cylinder':
            return self.length / 2.0
        return math.hypot(self.length, self.width) / 2.0

    def outline(self, sides: int = 48) -> Array:
        """
        Outline its footprint.

        Parameters
        ----------
        sides : int
            Of the polygon in place of a cylinder's circle.

        Returns
        -------
        ndarray, shape (n, 2)
            Corners in the world, counter-clockwise [m].
        """
        if self.kind == 'cylinder':
            angles = np.arange(sides) * (2.0 * math.pi / sides)
            corners = np.column_stack([np.cos(angles), np.sin(angles)])
        else:
            corners = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        return self.pose.transform(corners * (self.length / 2.0, self.width / 2.0))

    def distance_to(self, points: Array) -> Array:
        """
        Measure how far points are from its footprint.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
            In the world [m].

        Returns
        -------
        ndarray, shape (...)
            0 inside and on the edge [m].
        """
        local = self.pose.inverse().transform(np.asarray(points, dtype=float))
        if self.kind == 'cylinder':
            beyond = np.hypot(local[..., 0], local[..., 1]) - self.length / 2.0
            return np.maximum(beyond, 0.0)
        apart = np.maximum(np.abs(local) - (self.length / 2.0, self.width / 2.0), 0.0)
        distance: Array = np.hypot(apart[..., 0], apart[..., 1])
        return distance


@dataclass(frozen=True)
class World:
    """The ground, and what stands on it."""

    boxes: Array
    """Walls: corner points of each box's base, counter-clockwise, shape (n, 4, 2) [m]."""
    obstacle_height: float = 0.5
    """Height of the walls above the highest ground under each [m]."""
    friction: float = 0.8
    """Coulomb friction between feet and ground."""
    obstacles: tuple[Obstacle, ...] = ()
    """Besides the walls."""
    terrain: Terrain | None = None
    """The ground; level, at z = 0, if None."""

    def ground_at(self, points: Array) -> Array:
        """
        Return how high the ground is.

        Parameters
        ----------
        points : ndarray, shape (..., 2)
            x and y in the world [m].

        Returns
        -------
        ndarray, shape (...)
            [m]
        """
        if self.terrain is None:
            return np.zeros(np.shape(points)[:-1])
        return self.terrain.height_at(points)

    def span_of(self, obstacle: Obstacle) -> tuple[float, float]:
        """
        Return from which height to which an obstacle reaches.

        Parameters
        ----------
        obstacle : Obstacle
            It stands on the ground.

        Returns
        -------
        bottom, top : float
            The lowest ground under it, and its height above the ground at its middle [m].
        """
        if self.terrain is None:
            return 0.0, obstacle.height
        bottom, _ = self.terrain.span_under(obstacle.outline())
        middle = self.terrain.height_at([obstacle.pose.x, obstacle.pose.y])
        return bottom, float(middle) + obstacle.height

    def span_of_wall(self, outline: Array) -> tuple[float, float]:
        """
        Return from which height to which a wall reaches.

        Parameters
        ----------
        outline : ndarray, shape (4, 2)
            One of ``boxes`` [m].

        Returns
        -------
        bottom, top : float
            The lowest ground under it, and ``obstacle_height`` above the highest [m].
        """
        if self.terrain is None:
            return 0.0, self.obstacle_height
        bottom, highest = self.terrain.span_under(outline)
        return bottom, highest + self.obstacle_height


def world_from_map(
    grid: OccupancyGrid | None, obstacle_height: float = 0.5, friction: float = 0.8
) -> World:
    """
    Extrude a map's occupied cells.

    Parameters
    ----------
    grid : OccupancyGrid or None
        The map; None for an empty floor. Unknown cells become no obstacles.
    obstacle_height : float
        Height of the obstacles [m].
    friction : float
        Coulomb friction between feet and ground.

    Returns
    -------
    World
        World with the occupied cells merged into as few boxes as rows of equal runs allow.
    """
    if grid is None:
        return World(np.empty((0, 4, 2)), obstacle_height, friction)
    cells = merge_cells(grid.occupied())
    x0, y0, x1, y1 = (cells[:, k].astype(float) for k in range(4))
    corners = np.stack(
        [np.stack(pair, axis=-1) for pair in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))], axis=1
    )
    return World(grid.map_to_world(corners), obstacle_height, friction)


def occupancy_of(
    world: World, resolution: float, bounds: tuple[float, float, float, float]
) -> OccupancyGrid:
    """
    Draw the true map of a world.

    Parameters
    ----------
    world : World
        Walls and obstacles.
    resolution : float
        Side of a cell [m].
    bounds : tuple of float
        What the map spans in the world: x_min, y_min, x_max, y_max [m].

    Returns
    -------
    OccupancyGrid
        Every cell whose center is in a footprint is occupied, all others are free: areas are
        right on the average, and what is narrower than a cell may be missed.

    Raises
    ------
    MapError
        If there would be no cells, or too many.
    """
    x_min, y_min, x_max, y_max = bounds
    width, height = ((b - a) / resolution for a, b in ((x_min, x_max), (y_min, y_max)))
    if not (width > 0.0 and height > 0.0 and width * height <= MAX_CELLS):
        raise MapBoundsUnusable('a map', bounds, resolution, MAX_CELLS, 'cannot be drawn')
    shape = (math.ceil(height - 1e-9), math.ceil(width - 1e-9))
    grid = OccupancyGrid(np.zeros(shape, np.int8), resolution, Pose2D(x_min, y_min, 0.0))
    cells = np.zeros(shape, np.int8)
    outlines = [*world.boxes, *(obstacle.outline(sides=96) for obstacle in world.obstacles)]
    for outline in outlines:
        corners = grid.world_to_map(outline)
        low = np.clip(np.floor(corners.min(axis=0)).astype(int), 0, shape[::-1])
        high = np.clip(np.ceil(corners.max(axis=0)).astype(int), 0, shape[::-1])
        columns, rows = (np.arange(a, b) + 0.5 for a, b in zip(low, high))
        centers = np.stack(np.meshgrid(columns, rows), axis=-1)
        cells[low[1] : high[1], low[0] : high[0]][_inside(corners, centers)] = OCCUPIED
    return OccupancyGrid(cells, resolution, grid.origin)


def _inside(corners: Array, points: Array) -> NDArray[np.bool_]:
    """Tell which points (..., 2) a convex polygon, counter-clockwise, holds."""
    inside = np.ones(points.shape[:-1], dtype=bool)
    for (ax, ay), (bx, by) in zip(corners, np.roll(corners, -1, axis=0)):
        inside &= (bx - ax) * (points[..., 1] - ay) >= (by - ay) * (points[..., 0] - ax)
    return inside


def merge_cells(occupied: NDArray[np.bool_]) -> NDArray[np.int64]:
    """
    Cover the true cells of a grid exactly with rectangles.

    Runs of cells in a row are merged with equal runs in the row above.

    Parameters
    ----------
    occupied : ndarray of bool, shape (height, width)
        The cells to cover.

    Returns
    -------
    ndarray of int, shape (n, 4)
        First column, first row, and the column and row after the last, of each rectangle.
    """
    padded = np.pad(occupied.astype(np.int8), ((0, 0), (1, 1)))
    edges = np.diff(padded, axis=1)
    starts = np.argwhere(edges == 1)
    ends = np.argwhere(edges == -1)
    rectangles: list[tuple[int, int, int, int]] = []
    growing: dict[tuple[int, int], int] = {}
    previous = -1
    rows, offsets = np.unique(starts[:, 0], return_index=True)
    for row, runs in zip(rows, np.split(np.column_stack([starts[:, 1], ends[:, 1]]), offsets[1:])):
        if row != previous + 1:
            rectangles += [(x0, y0, x1, previous + 1) for (x0, x1), y0 in growing.items()]
            growing = {}
        here = {(int(x0), int(x1)) for x0, x1 in runs}
        for run in [run for run in growing if run not in here]:
            rectangles.append((run[0], growing.pop(run), run[1], previous + 1))
        for run in here:
            growing.setdefault(run, int(row))
        previous = int(row)
    rectangles += [(x0, y0, x1, previous + 1) for (x0, x1), y0 in growing.items()]
    return np.array(sorted(rectangles), dtype=np.int64).reshape(-1, 4)
