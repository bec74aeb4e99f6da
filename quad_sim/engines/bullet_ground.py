"""
What stands fast in PyBullet: bodies as such, and the ground.

That is a plane, or a height field with level ground around it, and blocks.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from quad_sim.world.terrain import Terrain
from quad_sim.world.world import World

_AROUND = 100.0
"""Width of the level ground around a height field [m]."""

_DEEP = 1.0
"""Depth to which the ground around a field, and blocks, reach down [m]."""

_MOST_SHAPES = 16
"""Number of shapes that PyBullet puts into one body, at most."""


class StaticBox(NamedTuple):
    """A box that stands fast."""

    half: Sequence[float]
    """Half of its length, width and height [m]."""
    place: Sequence[float]
    """Its middle in the world [m]."""
    turned: Sequence[float] = (0.0, 0.0, 0.0, 1.0)
    """Its orientation, quaternion xyzw."""


def add_static(
    client: Any,
    shape: int,
    place: Sequence[float] = (0.0, 0.0, 0.0),
    turned: Sequence[float] = (0.0, 0.0, 0.0, 1.0),
) -> int:
    """
    Make a body that stands fast, and return its number.

    It is a plain rigid body. Bullet goes over each multibody in every step, even over those that
    stand fast and that nothing is near.

    Parameters
    ----------
    client : BulletClient
        The world.
    shape : int
        Its shape, as Bullet numbers it.
    place : sequence of float
        Where its middle is [m].
    turned : sequence of float
        Its orientation, quaternion xyzw.

    Returns
    -------
    int
    """
    body: int = client.createMultiBody(0, shape, -1, place, turned, useMaximalCoordinates=1)
    return body


def add_boxes(client: Any, boxes: Iterable[StaticBox]) -> list[int]:
    """
    Make boxes that stand fast, and return the numbers of their bodies.

    Those that are near to each other share a body: Bullet takes time for each one, and looks into
    one only where something is near it.

    Parameters
    ----------
    client : BulletClient
        The world.
    boxes : iterable of StaticBox
        The boxes.

    Returns
    -------
    list of int
    """
    # Along x in strips one metre wide, and along y in each.
    ordered = sorted(boxes, key=lambda box: (round(box.place[0]), box.place[1]))
    bodies = []
    for first in range(0, len(ordered), _MOST_SHAPES):
        part = ordered[first : first + _MOST_SHAPES]
        shape = client.createCollisionShapeArray(
            shapeTypes=len(part) * [client.GEOM_BOX],
            halfExtents=[box.half for box in part],
            collisionFramePositions=[box.place for box in part],
            collisionFrameOrientations=[box.turned for box in part],
        )
        bodies.append(add_static(client, shape))
    return bodies


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
        bodies = [add_static(client, plane)]
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
    return add_static(client, shape, place)


def _add_surroundings(client: Any, terrain: Terrain) -> list[int]:
    """Add four boxes around the field with their tops at z = 0, and return their bodies."""
    x_min, y_min, x_max, y_max = terrain.field.bounds
    west, south, east, north = x_min - _AROUND, y_min - _AROUND, x_max + _AROUND, y_max + _AROUND
    depth = _DEEP - terrain.lowest
    boxes = []
    for x0, y0, x1, y1 in (
        (west, south, x_min, north),
        (x_max, south, east, north),
        (x_min, south, x_max, y_min),
        (x_min, y_max, x_max, north),
    ):
        half = ((x1 - x0) / 2.0, (y1 - y0) / 2.0, depth / 2.0)
        boxes.append(StaticBox(half, ((x0 + x1) / 2.0, (y0 + y1) / 2.0, -depth / 2.0)))
    return add_boxes(client, boxes)


def _add_blocks(client: Any, terrain: Terrain) -> list[int]:
    """Add the blocks, and return their bodies."""
    bottom = terrain.lowest - _DEEP
    boxes = []
    for block in terrain.blocks:
        half = (block.length / 2.0, block.width / 2.0, (block.top - bottom) / 2.0)
        place = (block.pose.x, block.pose.y, block.top - half[2])
        turned = client.getQuaternionFromEuler((0.0, 0.0, block.pose.yaw))
        boxes.append(StaticBox(half, place, turned))
    return add_boxes(client, boxes)
