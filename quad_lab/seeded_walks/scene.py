"""
Scene of a walk to a goal, drawn by a seed: map, ground, start and goal.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from quad_common.errors import ParameterError, PlannerError, QuadError
from quad_common.files.bounded_file import is_file, user_path
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot.robot import Robot
from quad_lab.seeded_walks.walk_settings import Walk, WalkSettings
from quad_planner.methods.planner import Planner
from quad_planner.planner_setup import planner_from_parameters
from quad_sim.world.random_room import random_room
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import World, occupancy_of, world_from_map

RANDOM = 'random'
"""Name of the map that is drawn."""

_RESOLUTION = 0.05
"""Side of the cells of a random room's map [m]."""

_CLEARANCE = 0.5
"""Radius of the disc that finds a path through a random room, at least [m]."""

_BEYOND = 1.0
"""Ground around the map [m]."""

_TRIES = 20_000
"""Pairs of poses that are drawn before it is given up."""

# Each kind of draw has a stream of its own: what one draws does not change what others draw.
_POSES, _ROOM, _GROUND, _NOISE = range(4)


@dataclass(eq=False, repr=False)
class NoWalkFound(QuadError):
    """No pair of poses that was drawn has a plan of the wanted length."""

    map_name: str
    """Name of the map."""
    tries: int
    """Number of pairs that were drawn."""
    lengths: tuple[float, float]
    """Least and largest length of the plan [m]."""

    def sentence(self) -> str:
        """Say which lengths were wanted."""
        shortest, longest = self.lengths
        return (
            f'of {self.tries} pairs of poses on map {self.map_name} none has a plan of '
            f'{shortest:g} to {longest:g} m'
        )


@dataclass(frozen=True)
class Scene:
    """Where a walk takes place."""

    world: World
    """World of the simulator."""
    grid: OccupancyGrid
    """Map of the planner."""
    start: Pose2D
    """Start of the robot, in the map."""
    goal: Pose2D
    """Goal, in the map."""


def noise_generator(seed: int) -> np.random.Generator:
    """Return the generator of the sensors' noise of a walk."""
    return _stream(seed, _NOISE)


def draw_scene(walk: Walk, robot: Robot, seed: int) -> Scene:
    """
    Draw where a walk begins and ends, and what lies between.

    Parameters
    ----------
    walk : Walk
        What is wanted.
    robot : Robot
        The robot, for which there must be a path.
    seed : int
        One seed, one scene.

    Returns
    -------
    Scene
        A pair of poses between which planner_node with these parameters plans a path of the
        wanted length, on level ground.

    Raises
    ------
    NoWalkFound
        If no such pair is found.
    QuadError
        If the map, the room or the ground cannot be made.
    """
    settings = walk.settings
    world, grid = _level_world(settings, robot, seed)
    planner = planner_from_parameters(walk.planner_node, robot)
    planner.set_map(grid)
    start, goal = _draw_pair(planner, grid, settings, _stream(seed, _POSES))
    x_min, y_min, x_max, y_max = grid.bounds()
    extent = (x_min - _BEYOND, y_min - _BEYOND, x_max + _BEYOND, y_max + _BEYOND)
    ends = ((start.x, start.y), (goal.x, goal.y))
    specs = specs_from_text(settings.terrain, seed=ground_seed(seed))
    terrain = make_terrain(specs, extent, start, ends)
    return Scene(replace(world, terrain=terrain), grid, start, goal)


def ground_seed(seed: int) -> int:
    """Return the seed of the ground of a walk."""
    return int(_stream(seed, _GROUND).integers(2**31))


def map_path(name: str) -> Path:
    """Return the file of a map that is named or given by its path; raise ParameterError."""
    for path in (user_path(name, 'map file'), sample_map(name)):
        if is_file(path):
            return path
    raise ParameterError('map', name, f'{RANDOM}, a sample map (room, office) or a Nav2 map file')


def _level_world(settings: WalkSettings, robot: Robot, seed: int) -> tuple[World, OccupancyGrid]:
    """Read a map, or draw a room."""
    if settings.map != RANDOM:
        grid = load_map(map_path(settings.map))
        return world_from_map(grid, friction=settings.friction), grid
    room = random_room(
        int(_stream(seed, _ROOM).integers(2**31)),
        clearance=max(_CLEARANCE, robot.standing_radius),
        friction=settings.friction,
    )
    return room.world, occupancy_of(room.world, _RESOLUTION, room.bounds)


def _draw_pair(
    planner: Planner[Any], grid: OccupancyGrid, settings: WalkSettings, rng: np.random.Generator
) -> tuple[Pose2D, Pose2D]:
    shortest, longest = settings.shortest, settings.longest
    for _ in range(_TRIES):
        cell = rng.uniform((0.0, 0.0), (grid.width, grid.height))
        x, y = (round(v, 3) for v in grid.map_to_world(cell).tolist())
        # Not far as the crow flies either: most of a large map need not be tried.
        distance, direction = rng.uniform(0.5 * shortest, longest), rng.uniform(-math.pi, math.pi)
        start_yaw, goal_yaw = rng.uniform(-math.pi, math.pi, 2).tolist()
        start = Pose2D(x, y, start_yaw)
        goal = Pose2D(
            round(x + distance * math.cos(direction), 3),
            round(y + distance * math.sin(direction), 3),
            goal_yaw,
        )
        try:
            length = planner.plan(start, goal).length
        except PlannerError:
            continue
        if shortest <= length <= longest:
            return start, goal
    raise NoWalkFound(settings.map, _TRIES, (shortest, longest))


def _stream(seed: int, kind: int) -> np.random.Generator:
    return np.random.default_rng((seed, kind))
