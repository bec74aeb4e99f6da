"""
Obstacles that come, move and go while a world is simulated.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from quad_common.errors import TooManyObstacles
from quad_sim.world.world import Obstacle


class HasObstacles(Protocol):
    """A world in which obstacles come and go."""

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Those that stand there now, by name."""

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""


@dataclass(frozen=True)
class ObstacleChange:
    """An obstacle comes, moves or goes."""

    name: Hashable
    """None: all of them."""
    obstacle: Obstacle | None
    """None: it goes."""


def _count_after(changes: Iterable[ObstacleChange], standing: Iterable[Hashable]) -> int:
    """Return the number of obstacles once all changes are made."""
    names = set(standing)
    for change in changes:
        if change.obstacle is not None:
            names.add(change.name)
        elif change.name is None:
            names.clear()
        else:
            names.discard(change.name)
    return len(names)


def change_obstacles(
    world: HasObstacles, changes: Sequence[ObstacleChange], most: int | None = None
) -> None:
    """
    Put and remove obstacles, all or, if there is an error, none; robots are not looked at.

    Parameters
    ----------
    world : HasObstacles
        Where they stand.
    changes : sequence of ObstacleChange
        In order.
    most : int, optional
        So many obstacles may stand at once; any number if not given.

    Raises
    ------
    TooManyObstacles
        If there would be more.
    """
    count = _count_after(changes, world.obstacles)
    if most is not None and count > max(most, len(world.obstacles)):
        raise TooManyObstacles(count, most)
    _put_and_remove(changes, world)


def _put_and_remove(changes: Sequence[ObstacleChange], world: HasObstacles) -> None:
    for change in changes:
        if change.obstacle is not None:
            world.put_obstacle(change.name, change.obstacle)
        else:
            gone = list(world.obstacles) if change.name is None else [change.name]
            for name in gone:
                world.remove_obstacle(name)
