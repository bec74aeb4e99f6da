"""
Ground that asks for footholds: staircases, stepping stones, gaps and beams.

They lie across the robot's path, as wide as the ground, and are made of blocks with upright sides;
a pit is a part of the height field.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.maps.height_map import HeightMap
from quad_common.planar_pose import Pose2D
from quad_sim.world.terrain import Block
from quad_sim.world.terrain_shapes import Places

_OVERLAP = 0.02
"""Length by which a beam lies on the ground before and behind its pit [m]."""


@dataclass(frozen=True)
class Stairs:
    """A staircase up, a landing, and a staircase down."""

    height: float
    """Height of each stair [m]."""
    tread: float
    """Depth of a stair, from edge to edge [m]."""
    count: int
    """Number of stairs up, and of those down."""
    landing: float
    """Length of the level ground on top [m]."""


@dataclass(frozen=True)
class Stones:
    """Rows of square stepping stones."""

    side: float
    """Side of a stone [m]."""
    gap: float
    """Distance from stone to stone [m]."""
    height: float
    """Their tops are so far below the ground at most [m]."""
    length: float
    """Length of the path over them; as many rows as fit, one at least [m]."""

    @property
    def rows(self) -> int:
        """Number of rows across the path."""
        return max(1, math.floor((self.length - self.gap) / (self.side + self.gap) + 1e-9))

    @property
    def whole_length(self) -> float:
        """Length of the rows with a gap before each, and one behind the last [m]."""
        return self.rows * (self.side + self.gap) + self.gap


@dataclass(frozen=True)
class Pit:
    """A pit across the path."""

    length: float
    """Length along the path [m]."""
    depth: float
    """Depth [m]."""
    level_at: Places
    """Places that the pit leaves level, for example the goal."""
    clear: float
    """Radius around those places, and distance from the start to the pit [m]."""


def staircase(
    cells: HeightMap, start: Pose2D, stairs: Stairs, clear: float = 0.8
) -> tuple[Block, ...]:
    """
    Lay a staircase across the path.

    Parameters
    ----------
    cells : HeightMap
        The stairs are as wide as these at any heading.
    start : Pose2D
        They rise in this heading.
    stairs : Stairs
        Their measures.
    clear : float
        Distance from the start to the first riser [m].

    Returns
    -------
    tuple of Block
        One on the other, the lowest and longest first.
    """
    width = _width_across(cells)
    whole = 2.0 * (stairs.count - 1) * stairs.tread + stairs.landing
    middle = start @ Pose2D(clear + whole / 2.0, 0.0, 0.0)
    return tuple(
        Block(middle, whole - 2.0 * k * stairs.tread, width, (k + 1) * stairs.height)
        for k in range(stairs.count)
    )


def pit(cells: HeightMap, start: Pose2D, pit: Pit) -> HeightMap:
    """
    Dig a pit across the path.

    Parameters
    ----------
    cells : HeightMap
        Its cells are filled.
    start : Pose2D
        The pit lies ahead of it.
    pit : Pit
        Its measures.

    Returns
    -------
    HeightMap
        0 beside it; its sides are a cell wide.
    """
    ahead = start.inverse().transform(cells.centers)[..., 0] - pit.clear
    inside = (ahead > 0.0) & (ahead < pit.length)
    for x, y in pit.level_at:
        inside &= np.hypot(*np.moveaxis(cells.centers - (x, y), -1, 0)) > pit.clear
    return cells.with_heights(np.where(inside, -pit.depth, 0.0))


def stones(
    cells: HeightMap, start: Pose2D, rng: np.random.Generator, stones: Stones, clear: float = 0.8
) -> tuple[Block, ...]:
    """
    Lay rows of stepping stones across the path.

    Parameters
    ----------
    cells : HeightMap
        The rows are as wide as these at any heading.
    start : Pose2D
        The rows lie ahead of it.
    rng : numpy.random.Generator
        Draws how far each row is shifted sideways, and the height of each stone.
    stones : Stones
        Their measures.
    clear : float
        Distance from the start to the gap before the first row [m].

    Returns
    -------
    tuple of Block
        Their tops are below z = 0.
    """
    pitch = stones.side + stones.gap
    half = math.ceil(_width_across(cells) / 2.0 / pitch)
    placed = []
    for row in range(stones.rows):
        ahead = clear + stones.gap + row * pitch + stones.side / 2.0
        aside = rng.uniform(-0.5, 0.5) * pitch
        for column, fraction in zip(range(-half, half + 1), rng.random(2 * half + 1)):
            pose = start @ Pose2D(ahead, aside + column * pitch, 0.0)
            top = -stones.height * float(fraction)
            if cells.contains([pose.x, pose.y]):
                placed.append(Block(pose, stones.side, stones.side, top))
    return tuple(placed)


def beam(start: Pose2D, width: float, length: float, clear: float = 0.8) -> Block:
    """
    Lay a beam over a pit, along the path.

    Parameters
    ----------
    start : Pose2D
        The beam lies ahead of it.
    width, length : float
        Width of the beam, and length of the pit [m].
    clear : float
        Distance from the start to the pit [m].

    Returns
    -------
    Block
        With its top at z = 0.
    """
    middle = start @ Pose2D(clear + length / 2.0, 0.0, 0.0)
    return Block(middle, length + 2.0 * _OVERLAP, width, 0.0)


def _width_across(cells: HeightMap) -> float:
    """Return a width with which something crosses the cells at any heading [m]."""
    x_min, y_min, x_max, y_max = cells.bounds
    return 2.0 * math.hypot(x_max - x_min, y_max - y_min)
