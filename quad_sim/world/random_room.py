"""
Rooms with obstacles at random, in which a robot finds a path from a start to a goal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_sim.world.world import Obstacle, World

FEWEST, MOST = 3, 12
"""Obstacles of a room whose number is drawn."""

_FOOTPRINTS = (0.3, 1.0)
"""Least and largest length, width or diameter of an obstacle [m]."""

_HEIGHTS = (0.2, 1.0)
"""Least and largest height of obstacles [m]."""

_WIDEST_GAP = 0.8
"""Largest excess of the narrowest gap over what the robot needs [m]."""

_MARGIN = 0.3
"""Least distance of an obstacle from the robot at the start or the goal [m]."""

_TRIES = 100
"""Tries for a room, and for an obstacle in it, before the gap is made narrower."""


@dataclass(frozen=True)
class Room:
    """A world in a square whose lower left corner is the origin."""

    world: World
    size: float
    """Side of the square [m]."""
    start: Pose2D
    goal: Pose2D
    gap: float
    """Least distance between any two obstacles [m]."""

    @property
    def bounds(self) -> tuple[float, float, float, float]:
        """The square: x_min, y_min, x_max, y_max [m]."""
        return 0.0, 0.0, self.size, self.size


def random_room(
    seed: int,
    count: int | None = None,
    start: Pose2D | None = None,
    size: float = 8.0,
    clearance: float = 0.5,
    friction: float = 0.8,
) -> Room:
    """
    Draw a room.

    A disc that is as large as the robot's clearance finds a path from the start to the goal: no two
    obstacles are nearer to each other than its diameter, and none bars a corner of the room.
    Grown by the clearance, the obstacles are then convex, apart, and each meets one side of
    what the disc's center may reach at most, so that what is left hangs together.

    Parameters
    ----------
    seed : int
        One seed, one room.
    count : int, optional
        Number of obstacles; drawn from :data:`FEWEST` to :data:`MOST` if not given.
    start : Pose2D, optional
        Pose of the robot at first; drawn if not given.
    size : float
        Side of the room [m].
    clearance : float
        Radius of the disc that is to find a path [m].
    friction : float
        Coulomb friction between feet and ground.

    Returns
    -------
    Room
        Without walls; all obstacles lie within it.

    Raises
    ------
    ParameterError
        If the start is not in the room, or so many obstacles do not fit into it.
    """
    rng = np.random.default_rng(seed)
    number = int(rng.integers(FEWEST, MOST + 1)) if count is None else count
    keep = clearance + 0.1
    _check(number, start, size, keep)
    narrowest = 2.0 * clearance + 0.1
    drawn = rng.uniform(narrowest, narrowest + _WIDEST_GAP)
    for attempt in range(_TRIES):
        gap = narrowest + (drawn - narrowest) * (1.0 - attempt / (_TRIES - 1))
        begin = _free_pose(rng, size, keep) if start is None else start
        goal = _goal_for(begin, size, keep, rng)
        obstacles = _furnish(rng, number, size, gap, clearance, (begin, goal))
        if obstacles is not None:
            world = World(np.empty((0, 4, 2)), friction=friction, obstacles=obstacles)
            return Room(world, size, begin, goal, gap)
    raise ParameterError(
        'count',
        number,
        f'smaller: they do not fit into a room of {size:g} m with gaps of {narrowest:.2f} m',
    )


def _check(number: int, start: Pose2D | None, size: float, keep: float) -> None:
    if number < 0:
        raise ParameterError('count', number, 'at least 0')
    if start is None or keep <= min(start.x, start.y) <= max(start.x, start.y) <= size - keep:
        return
    raise ParameterError(
        'start_pose', [start.x, start.y], f'from {keep:.2f} to {size - keep:.2f} m in x and y'
    )


def _goal_for(start: Pose2D, size: float, keep: float, rng: np.random.Generator) -> Pose2D:
    goal = _free_pose(rng, size, keep)
    if start.distance_to(goal) < 0.5 * size:
        # Nearer to each other they would make a short walk.
        return _farthest_corner(start, size, keep, rng)
    return goal


def _free_pose(rng: np.random.Generator, size: float, keep: float) -> Pose2D:
    x, y = rng.uniform(keep, size - keep, 2)
    return Pose2D(float(x), float(y), float(rng.uniform(-math.pi, math.pi)))


def _farthest_corner(start: Pose2D, size: float, keep: float, rng: np.random.Generator) -> Pose2D:
    """Draw a pose in that quarter of the room which is opposite to the start."""
    x, y = (
        float(
            rng.uniform(0.75 * size, size - keep)
            if v < size / 2
            else rng.uniform(keep, 0.25 * size)
        )
        for v in (start.x, start.y)
    )
    return Pose2D(x, y, float(rng.uniform(-math.pi, math.pi)))


def _furnish(
    rng: np.random.Generator,
    count: int,
    size: float,
    gap: float,
    clearance: float,
    kept_clear: tuple[Pose2D, ...],
) -> tuple[Obstacle, ...] | None:
    """Place obstacles one after the other; None if one finds no place."""
    placed: list[Obstacle] = []
    for _ in range(count):
        for _ in range(_TRIES):
            one = _draw(rng, size)
            fits = (
                not _bars_a_corner(one, size, 2.0 * clearance)
                and all(_apart(one, other) >= gap for other in placed)
                and all(
                    one.pose.distance_to(pose) - one.outer_radius >= clearance + _MARGIN
                    for pose in kept_clear
                )
            )
            if fits:
                placed.append(one)
                break
        else:
            return None
    return tuple(placed)


def _draw(rng: np.random.Generator, size: float) -> Obstacle:
    """Draw an obstacle that lies within the room."""
    length, width = (float(v) for v in rng.uniform(*_FOOTPRINTS, 2))
    height = float(rng.uniform(*_HEIGHTS))
    yaw = float(rng.uniform(-math.pi, math.pi))
    is_box = bool(rng.random() < 0.5)
    place = rng.uniform(0.0, 1.0, 2)
    around = math.hypot(length, width) / 2.0 if is_box else length / 2.0
    x, y = (float(v) for v in around + place * (size - 2.0 * around))
    if is_box:
        return Obstacle.box(Pose2D(x, y, yaw), length, width, height)
    return Obstacle.cylinder(x, y, length / 2.0, height)


def _apart(a: Obstacle, b: Obstacle) -> float:
    """Distance between the circles around two obstacles: they are that far apart or farther."""
    return a.pose.distance_to(b.pose) - a.outer_radius - b.outer_radius


def _bars_a_corner(one: Obstacle, size: float, passage: float) -> bool:
    """Tell whether an obstacle is too near to two sides to be passed on either."""
    from_sides = (min(v, size - v) - one.outer_radius for v in (one.pose.x, one.pose.y))
    return all(distance < passage for distance in from_sides)
