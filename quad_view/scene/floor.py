"""
The floor: an occupancy grid as a picture, a height map as a surface, and where a ray meets it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.maps.occupancy_grid import OCCUPIED_THRESHOLD, UNKNOWN, OccupancyGrid
from quad_common.planar_pose import Pose2D

Array = NDArray[np.float64]

_FREE, _WALL, _UNKNOWN = (236, 238, 240), (70, 74, 82), (176, 180, 186)

_MOST_PIXELS = 1024
"""On the longer side of a floor's picture."""

_MOST_VERTICES = 40_000
"""Of a surface."""


@dataclass(frozen=True, eq=False)
class FloorPicture:
    """A map from above."""

    pixels: NDArray[np.uint8]
    """Red, green, blue, shape (height, width, 3); the first row is the map's top."""
    size: tuple[float, float]
    """Width and height [m]."""
    center: Pose2D
    """Its middle, and the direction of its rows, on the map."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A height map as triangles."""

    vertices: Array
    """Corners, shape (n, 3) [m]."""
    faces: NDArray[np.int64]
    """Corners of the triangles, counter-clockwise from above, shape (m, 3)."""
    colors: NDArray[np.uint8]
    """Color of each corner, shape (n, 3)."""
    shape: tuple[int, int]
    """Rows and columns of its corners, which are a grid, row by row."""

    def height_at(self, points: Array) -> Array:
        """Return the ground's height at points, shape (n, 2) [m]; beside it that of its rim."""
        rows, columns = self.shape
        corners = self.vertices.reshape(rows, columns, 3)
        row = np.searchsorted(_between(corners[:, 0, 1]), points[:, 1])
        column = np.searchsorted(_between(corners[0, :, 0]), points[:, 0])
        height: Array = corners[row, column, 2]
        return height


_FINE = 0.05
"""Length between two points of a line that lies on the ground [m]."""


def _between(places: Array) -> Array:
    """Return the middles between places."""
    middles: Array = 0.5 * (places[:-1] + places[1:])
    return middles


def laid_on(surface: Surface | None, points: Array, above: float) -> Array:
    """
    Lay a line on the ground.

    Parameters
    ----------
    surface : Surface or None
        The ground; flat at 0 if None.
    points : ndarray, shape (n, 2)
        Corners of the line [m].
    above : float
        Height above the ground [m].

    Returns
    -------
    ndarray, shape (m, 3)
        Its points; on uneven ground more than there were corners [m].
    """
    if surface is None or len(points) < 1:
        return np.column_stack([points, np.full(len(points), above)])
    length = np.concatenate([[0.0], np.hypot(*np.diff(points, axis=0).T).cumsum()])
    count = min(max(len(points), math.ceil(length[-1] / _FINE) + 1), _MOST_VERTICES)
    places = np.union1d(length, np.linspace(0.0, length[-1], count))
    fine = np.column_stack([np.interp(places, length, points[:, k]) for k in range(2)])
    return np.column_stack([fine, surface.height_at(fine) + above])


def floor_picture(grid: OccupancyGrid) -> FloorPicture:
    """
    Draw a map from above.

    Parameters
    ----------
    grid : OccupancyGrid
        The map.

    Returns
    -------
    FloorPicture
        Free, occupied and unknown cells; of a large map cells are drawn together, and walls stay
        visible.
    """
    step = max(1, math.ceil(max(grid.width, grid.height) / _MOST_PIXELS))
    rows, columns = (math.ceil(n / step) for n in (grid.height, grid.width))
    cells = np.full((rows * step, columns * step), UNKNOWN, dtype=np.int8)
    cells[: grid.height, : grid.width] = grid.cells
    # The highest of the cells that are drawn together, so that thin walls do not vanish.
    cells = cells.reshape(rows, step, columns, step).max(axis=(1, 3))
    pixels = np.empty((rows, columns, 3), dtype=np.uint8)
    pixels[:] = _FREE
    pixels[cells == UNKNOWN] = _UNKNOWN
    pixels[cells >= OCCUPIED_THRESHOLD] = _WALL
    side = grid.resolution * step
    center = grid.origin @ Pose2D(0.5 * columns * side, 0.5 * rows * side, 0.0)
    return FloorPicture(pixels[::-1].copy(), (columns * side, rows * side), center)


def surface_of(heights: HeightMap) -> Surface:
    """
    Make triangles of a height map.

    Parameters
    ----------
    heights : HeightMap
        Heights; cells that are not known are left out.

    Returns
    -------
    Surface
        Through the cells' centers, or fewer of them if there are many.
    """
    step = max(1, math.ceil(math.sqrt(heights.heights.size / _MOST_VERTICES)))
    z = heights.heights[::step, ::step]
    rows, columns = z.shape
    x = heights.origin[0] + (np.arange(columns) * step + 0.5) * heights.resolution
    y = heights.origin[1] + (np.arange(rows) * step + 0.5) * heights.resolution
    vertices = np.stack([*np.meshgrid(x, y), np.nan_to_num(z)], axis=-1).reshape(-1, 3)
    index = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = index[:-1, :-1], index[:-1, 1:], index[1:, 1:], index[1:, :-1]
    known = np.isfinite(z)
    whole = (known[:-1, :-1] & known[:-1, 1:] & known[1:, 1:] & known[1:, :-1]).ravel()
    triangles = [np.stack([p.ravel(), q.ravel(), r.ravel()], axis=-1) for p, q, r in
                 ((a, b, c), (a, c, d))]  # fmt: skip
    faces = np.concatenate([triangle[whole] for triangle in triangles])
    colors = _height_colors(vertices[:, 2], known.ravel())
    return Surface(vertices, faces, colors, (rows, columns))


def with_walls(surface: Surface, floor: FloorPicture) -> Surface:
    """
    Draw the walls of a map on the ground.

    Parameters
    ----------
    surface : Surface
        The ground.
    floor : FloorPicture
        The map.

    Returns
    -------
    Surface
        The same ground with the walls' color where the map is occupied.
    """
    height, width = floor.pixels.shape[:2]
    place = floor.center.inverse().transform(surface.vertices[:, :2])
    column = np.floor((place[:, 0] / floor.size[0] + 0.5) * width).astype(int)
    row = np.floor((0.5 - place[:, 1] / floor.size[1]) * height).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    is_wall = np.zeros(len(surface.vertices), dtype=bool)
    is_wall[inside] = (floor.pixels[row[inside], column[inside]] == _WALL).all(axis=1)
    colors = np.where(is_wall[:, None], _WALL, surface.colors)
    return replace(surface, colors=colors)


def _height_colors(z: Array, known: NDArray[np.bool_]) -> NDArray[np.uint8]:
    """Color heights from green, the lowest, over sand to white."""
    low, high = (float(z[known].min()), float(z[known].max())) if known.any() else (0.0, 0.0)
    part = (z - low) / max(high - low, 0.02)
    stops = np.array([[96, 150, 110], [214, 190, 140], [250, 248, 245]], dtype=float)
    colors = [np.interp(part, (0.0, 0.5, 1.0), stops[:, channel]) for channel in range(3)]
    return np.stack(colors, axis=-1).astype(np.uint8)


def floor_point(origin: Array, direction: Array, height: float = 0.0) -> tuple[float, float] | None:
    """
    Say where a ray meets the floor.

    Parameters
    ----------
    origin : ndarray, shape (3,)
        Where the ray begins [m].
    direction : ndarray, shape (3,)
        Its direction.
    height : float
        Of the floor [m].

    Returns
    -------
    tuple of float or None
        x and y [m]; None if it does not within a kilometre.
    """
    drop = float(direction[2])
    if abs(drop) < 1e-9:
        return None
    distance = (height - float(origin[2])) / drop
    x, y = (float(origin[k] + distance * direction[k]) for k in range(2))
    if not (distance > 0.0 and math.hypot(x - origin[0], y - origin[1]) < 1000.0):
        return None
    return x, y
