"""
The ground in PyBullet: a plane, or a height field with level ground around it, and blocks.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_sim.world.terrain import Terrain
from quad_sim.world.world import World

_AROUND = 100.0
"""Width of the level ground around a height field [m]."""

_DEEP = 1.0
"""Depth to which the ground around a field, and blocks, reach down [m]."""


def lay_ground(client: Any, world: World) -> frozenset[int]:
    """
    Make the ground.

    Parameters
    ----------
    client : BulletClient
        The physics.
    world : World
        Whose ground it is.

    Returns
    -------
    frozenset of int
        The bodies that it is made of.
    """
    terrain = world.terrain
    if terrain is None or terrain.is_level:
        plane = client.createCollisionShape(client.GEOM_PLANE)
        bodies = [client.createMultiBody(0, plane)]
    else:
        bodies = [_add_field(client, terrain), *_add_surroundings(client, terrain)]
    if terrain is not None:
        bodies += _add_blocks(client, terrain)
    for body in bodies:
        # Bullet multiplies the two surfaces' frictions: the feet keep 1.
        client.changeDynamics(body, -1, lateralFriction=world.friction, restitution=0.0)
    return frozenset(bodies)


def _add_field(client: Any, terrain: Terrain) -> int:
    """Add the height field, and return its body."""
    field = terrain.field
    # Bullet's surface ends at the outermost points: with one more cell on each side it reaches
    # half a cell beyond the border, as high as the last center, and leaves no gap there.
    heights: NDArray[np.float64] = np.pad(field.heights, 1, mode='edge')
    rows, columns = heights.shape
    shape = client.createCollisionShape(
        client.GEOM_HEIGHTFIELD,
        meshScale=[field.resolution, field.resolution, 1.0],
        heightfieldData=heights.ravel().tolist(),
        # Bullet's rows are what lies along x.
        numHeightfieldRows=columns,
        numHeightfieldColumns=rows,
    )
    x_min, y_min, x_max, y_max = field.bounds
    # Bullet puts the middle of the box around the field at the body's origin.
    middle = (float(heights.min()) + float(heights.max())) / 2.0
    place = ((x_min + x_max) / 2.0, (y_min + y_max) / 2.0, middle)
    body: int = client.createMultiBody(0, shape, -1, place)
    return body


def _add_surroundings(client: Any, terrain: Terrain) -> list[int]:
    """Add four boxes around the field with their tops at z = 0, and return their bodies."""
    x_min, y_min, x_max, y_max = terrain.field.bounds
    west, south, east, north = x_min - _AROUND, y_min - _AROUND, x_max + _AROUND, y_max + _AROUND
    depth = _DEEP - terrain.lowest
    bodies = []
    for x0, y0, x1, y1 in (
        (west, south, x_min, north),
        (x_max, south, east, north),
        (x_min, south, x_max, y_min),
        (x_min, y_max, x_max, north),
    ):
        half = ((x1 - x0) / 2.0, (y1 - y0) / 2.0, depth / 2.0)
        place = ((x0 + x1) / 2.0, (y0 + y1) / 2.0, -depth / 2.0)
        bodies.append(_add_box(client, half, place, (0.0, 0.0, 0.0, 1.0)))
    return bodies


def _add_blocks(client: Any, terrain: Terrain) -> list[int]:
    """Add the blocks, and return their bodies."""
    bottom = terrain.lowest - _DEEP
    bodies = []
    for block in terrain.blocks:
        half = (block.length / 2.0, block.width / 2.0, (block.top - bottom) / 2.0)
        place = (block.pose.x, block.pose.y, block.top - half[2])
        turned = client.getQuaternionFromEuler((0.0, 0.0, block.pose.yaw))
        bodies.append(_add_box(client, half, place, turned))
    return bodies


def _add_box(
    client: Any,
    half: tuple[float, float, float],
    place: tuple[float, float, float],
    turned: tuple[float, float, float, float],
) -> int:
    shape = client.createCollisionShape(client.GEOM_BOX, halfExtents=half)
    body: int = client.createMultiBody(0, shape, -1, place, turned)
    return body
