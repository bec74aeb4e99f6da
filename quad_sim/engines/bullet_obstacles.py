"""
Obstacles that come and go in a Bullet world.
"""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

from quad_sim.world.world import Obstacle, World


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
        body = client.createMultiBody(0, shape, -1, place, turned)
        self._placed[name] = obstacle, body

    def remove(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        if name in self._placed:
            self._client.removeBody(self._placed.pop(name)[1])
