"""
Shapes of ground: bumps, slopes, kerbs, noise and low boxes, the same for the same seed.

Each is laid over the cells of a level height map. Fields are added up; blocks are put upon them.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_sim.world.terrain import Block

Array = NDArray[np.float64]

Places = tuple[tuple[float, float], ...]
"""x and y of points in the world [m]."""

_TRIES = 30
"""Tries for each thing that is placed at random."""

_SIZES = (0.6, 1.4)
"""Sizes of bumps and boxes, as fractions of the size that was requested."""

_LEAST = 0.4
"""Height of the lowest bumps and boxes, as a fraction of the height that was requested."""

_BLEND = 0.5
"""Over which noise grows around a level place [m]."""

_SPREAD = 0.5
"""Standard deviation of the bell with which noise is smoothed, of its length."""


@dataclass(frozen=True)
class Scatter:
    """How things are scattered over the ground."""

    size: float = 0.4
    """Mean of their diameters, which are from 0.6 to 1.4 of it [m]."""
    cover: float = 0.25
    """Part of the ground that they cover at most."""
    level_at: Places = ()
    """Places where there are none."""
    clear: float = 0.8
    """Radius around those places [m]."""
    gap: float = 0.05
    """Least distance between any two of them [m]."""


def bumps(cells: HeightMap, rng: np.random.Generator, height: float, scatter: Scatter) -> HeightMap:
    """
    Scatter smooth round bumps.

    Parameters
    ----------
    cells : HeightMap
        Its cells are filled.
    rng : numpy.random.Generator
        Draws places, sizes and heights.
    height : float
        Height of the highest bumps; the lowest have 0.4 of it [m].
    scatter : Scatter
        How they lie. They do not overlap: about half of the ground is what there is place for.

    Returns
    -------
    HeightMap
        Heights (1 - (d / radius)^2)^2 at the distance d from a bump's middle; 0 between them.
    """
    heights = np.zeros_like(cells.heights)
    for x, y, radius, part in _places(cells, rng, scatter, _disc_area):
        window, squared = _around(cells, x, y, radius)
        profile = np.maximum(1.0 - squared / radius**2, 0.0) ** 2
        heights[window] += height * part * profile
    return cells.with_heights(heights)


def slope(
    cells: HeightMap, start: Pose2D, angle: float, length: float = 1.5, clear: float = 0.8
) -> HeightMap:
    """
    Lay a ramp across the path: up, level, and down again.

    Parameters
    ----------
    cells : HeightMap
        Its cells are filled.
    start : Pose2D
        It rises in this heading.
    angle : float
        Angle between ramp and level; negative: a hollow in place of a hill [rad].
    length : float
        Length of each of the three parts, on the level [m].
    clear : float
        Distance from the start to its foot [m].

    Returns
    -------
    HeightMap
        0 before and behind it.
    """
    ahead = _ahead_of(cells, start)[..., 0] - clear
    up = np.clip(ahead, 0.0, length)
    down = np.clip(ahead - 2.0 * length, 0.0, length)
    return cells.with_heights(math.tan(angle) * (up - down))


def cross_slope(cells: HeightMap, start: Pose2D, angle: float) -> HeightMap:
    """
    Tilt the ground sideways, so that who walks ahead walks along a contour.

    Parameters
    ----------
    cells : HeightMap
        Its cells are filled.
    start : Pose2D
        The contour at z = 0 goes through it in its heading.
    angle : float
        Angle by which the ground rises to the left [rad].

    Returns
    -------
    HeightMap
        A plane.
    """
    return cells.with_heights(math.tan(angle) * _ahead_of(cells, start)[..., 1])


def noise(
    cells: HeightMap,
    rng: np.random.Generator,
    height: float,
    size: float = 0.4,
    level_at: Places = (),
    clear: float = 0.8,
) -> HeightMap:
    """
    Make rolling ground of smoothed noise.

    Parameters
    ----------
    cells : HeightMap
        Its cells are filled.
    rng : numpy.random.Generator
        Draws it.
    height : float
        Distance of the highest or lowest point from z = 0 [m].
    size : float
        Length over which heights are alike: their correlation is 1/e at this distance [m].
    level_at : tuple of (float, float)
        Where it is level, at z = 0.
    clear : float
        Radius around those places; beyond it the noise grows over 0.5 m [m].

    Returns
    -------
    HeightMap
        Above and below z = 0.
    """
    # A bell of deviation s makes heights with correlation exp(-d^2 / (4 s^2)).
    deviation = _SPREAD * size / cells.resolution
    # Imported late: it takes a third of a node's start, and other ground needs none of it.
    from scipy import ndimage

    heights = ndimage.gaussian_filter(rng.standard_normal(cells.heights.shape), deviation)
    for x, y in level_at:
        distance = np.hypot(*np.moveaxis(cells.centers - (x, y), -1, 0))
        part = np.clip((distance - clear) / _BLEND, 0.0, 1.0)
        heights *= part**2 * (3.0 - 2.0 * part)
    largest = float(np.abs(heights).max())
    return cells.with_heights(heights * (height / largest if largest > 0.0 else 0.0))


def kerb(
    cells: HeightMap, start: Pose2D, height: float, length: float = 1.5, clear: float = 0.8
) -> Block:
    """
    Lay a low platform across the path: a step up, and farther on a step down.

    Parameters
    ----------
    cells : HeightMap
        It is as wide as these at any heading.
    start : Pose2D
        It lies ahead of this heading.
    height : float
        Height of the steps [m].
    length : float
        Distance between them [m].
    clear : float
        Distance from the start to the first one [m].

    Returns
    -------
    Block
        Platform with upright sides.
    """
    x_min, y_min, x_max, y_max = cells.bounds
    width = 2.0 * math.hypot(x_max - x_min, y_max - y_min)
    return Block(start @ Pose2D(clear + length / 2.0, 0.0, 0.0), length, width, height)


def boxes(
    cells: HeightMap, rng: np.random.Generator, height: float, scatter: Scatter
) -> tuple[Block, ...]:
    """
    Scatter low boxes.

    Parameters
    ----------
    cells : HeightMap
        They stand within these, on this ground.
    rng : numpy.random.Generator
        Draws places, headings, sizes and heights.
    height : float
        Height of the highest boxes above the ground at their middle; the lowest have 0.4 of it [m].
    scatter : Scatter
        How they stand; their diagonals are its diameters.

    Returns
    -------
    tuple of Block
        Boxes with upright sides and level tops.
    """
    placed = []
    for x, y, radius, part in _places(cells, rng, scatter, _box_area):
        yaw, half = rng.uniform(-math.pi, math.pi), rng.uniform(0.5, 0.9)
        top = float(cells.height_at([x, y])) + height * part
        length, width = 2.0 * radius * math.cos(half), 2.0 * radius * math.sin(half)
        placed.append(Block(Pose2D(x, y, float(yaw)), length, width, top))
    return tuple(placed)


def _disc_area(radius: float) -> float:
    return math.pi * radius**2


def _box_area(radius: float) -> float:
    """Area of a square within a circle."""
    return 2.0 * radius**2


def _places(
    cells: HeightMap,
    rng: np.random.Generator,
    scatter: Scatter,
    area: Callable[[float], float],
) -> list[tuple[float, float, float, float]]:
    """
    Place circles apart from each other and from level places.

    Returns
    -------
    list of (float, float, float, float)
        x, y and radius [m], and a part of the height, from 0.4 to 1.
    """
    x_min, y_min, x_max, y_max = cells.bounds
    wanted = scatter.cover * (x_max - x_min) * (y_max - y_min)
    tries = _TRIES * math.ceil(wanted / area(scatter.size / 2.0))
    kept = np.array([(x, y, scatter.clear) for x, y in scatter.level_at]).reshape(-1, 3)
    found: list[tuple[float, float, float, float]] = []
    taken = np.empty((tries + len(kept), 3))
    taken[: len(kept)] = kept
    count, covered = len(kept), 0.0
    for u, v, s, h in rng.random((tries, 4)):
        radius = 0.5 * scatter.size * (_SIZES[0] + s * (_SIZES[1] - _SIZES[0]))
        x, y = x_min + u * (x_max - x_min), y_min + v * (y_max - y_min)
        others = taken[:count]
        apart = np.hypot(others[:, 0] - x, others[:, 1] - y) - others[:, 2] - radius
        inside = radius <= min(x - x_min, x_max - x, y - y_min, y_max - y)
        if covered + area(radius) <= wanted and inside and (apart >= scatter.gap).all():
            taken[count] = x, y, radius
            count, covered = count + 1, covered + area(radius)
            found.append((float(x), float(y), float(radius), float(_LEAST + h * (1.0 - _LEAST))))
    return found


def _around(
    cells: HeightMap, x: float, y: float, radius: float
) -> tuple[tuple[slice, slice], Array]:
    """Return the cells around a point, and the square of their distances from it [m^2]."""
    low = (np.array([x, y]) - radius - cells.origin) / cells.resolution
    high = (np.array([x, y]) + radius - cells.origin) / cells.resolution
    first = np.maximum(np.floor(low).astype(int), 0)
    last = np.minimum(np.ceil(high).astype(int), (cells.columns, cells.rows))
    columns, rows = (np.arange(a, b) + 0.5 for a, b in zip(first, last))
    dx = cells.origin[0] + columns * cells.resolution - x
    dy = cells.origin[1] + rows * cells.resolution - y
    window = (slice(first[1], last[1]), slice(first[0], last[0]))
    return window, dx**2 + dy[:, None] ** 2


def _ahead_of(cells: HeightMap, start: Pose2D) -> Array:
    """How far the centers are ahead and to the left of a pose, shape (rows, columns, 2) [m]."""
    return start.inverse().transform(cells.centers)
