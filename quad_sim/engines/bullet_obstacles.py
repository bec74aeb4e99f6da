"""
What stands in a Bullet world: walls, which are static meshes, and obstacles that come and go.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Hashable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.process.temporary_folder import temporary_folder
from quad_sim.engines.bullet_ground import add_static
from quad_sim.world.world import Obstacle, World

Array = NDArray[np.float64]

_TILE = 4.0
"""Side of the squares of the floor whose walls make one mesh, so that far ones cost nothing [m]."""


class BulletObstacles:
    """
    The obstacles that stand in a world, besides its walls.

    Parameters
    ----------
    client : BulletClient
        The world in Bullet.
    world : World
        What they stand on.
    """

    def __init__(self, client: Any, world: World) -> None:
        self._client = client
        self._world = world
        self._placed: dict[Hashable, tuple[Obstacle, int]] = {}

    @property
    def standing(self) -> dict[Hashable, Obstacle]:
        """Obstacles by their names."""
        return {name: obstacle for name, (obstacle, _) in self._placed.items()}

    def put(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""
        self.remove(name)
        client = self._client
        bottom, top = self._world.span_of(obstacle)
        half = (obstacle.length / 2.0, obstacle.width / 2.0, (top - bottom) / 2.0)
        if obstacle.kind == 'box':
            shape = client.createCollisionShape(client.GEOM_BOX, halfExtents=half)
        else:
            shape = client.createCollisionShape(
                client.GEOM_CYLINDER, radius=half[0], height=top - bottom
            )
        pose = obstacle.pose
        turned = client.getQuaternionFromEuler((0.0, 0.0, pose.yaw))
        place = (pose.x, pose.y, bottom + half[2])
        body = add_static(client, shape, place, turned)
        self._placed[name] = obstacle, body

    def remove(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        if name in self._placed:
            self._client.removeBody(self._placed.pop(name)[1])


def build_walls(client: Any, world: World) -> None:
    """Build the boxes as one static mesh per tile of the floor."""
    tiles: dict[tuple[int, int], list[Array]] = defaultdict(list)
    for box in world.boxes:
        column, row = np.floor(box.mean(axis=0) / _TILE).astype(int)
        tiles[column, row].append(box)
    with temporary_folder() as folder:
        for index, boxes in enumerate(tiles.values()):
            path = folder / f'{index}.obj'
            spans = [world.span_of_wall(box) for box in boxes]
            path.write_text(_mesh_of_boxes(boxes, spans), encoding='ascii')
            shape = client.createCollisionShape(
                client.GEOM_MESH,
                fileName=str(path),
                flags=client.GEOM_FORCE_CONCAVE_TRIMESH,
            )
            add_static(client, shape)


def _mesh_of_boxes(boxes: list[Array], spans: list[tuple[float, float]]) -> str:
    """
    Write boxes as a Wavefront mesh.

    Each is given by the four corners of its base, counter-clockwise, and the heights of its
    bottom and its top.
    """
    lines = []
    faces = []
    for index, (base, span) in enumerate(zip(boxes, spans)):
        first = 8 * index + 1
        for z in span:
            lines += [f'v {x:.6f} {y:.6f} {z:.6f}' for x, y in base]
        for a, b, c, d in (
            (4, 5, 6, 7),
            (0, 1, 5, 4),
            (1, 2, 6, 5),
            (2, 3, 7, 6),
            (3, 0, 4, 7),
        ):
            faces.append(f'f {first + a} {first + b} {first + c}')
            faces.append(f'f {first + a} {first + c} {first + d}')
    return '\n'.join(lines + faces) + '\n'
