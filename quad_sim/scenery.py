"""
What the parameters of ``sim_node`` say of the world and of the camera.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from quad_common.errors import ParameterError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot.robot import Robot
from quad_common.vision.camera import CameraModel
from quad_common.vision.color_parameters import color_from, markers_from
from quad_sim.engines.registry import ENGINES, resolved
from quad_sim.parameters import SimParameters
from quad_sim.simulation import check_start, start_from
from quad_sim.world.appearance import Appearance
from quad_sim.world.random_room import random_room
from quad_sim.world.simulated_camera import SimulatedCamera
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import World, occupancy_of, world_from_map

_SIZES = (16, 2048)
"""Least and largest side of a picture [pixels]."""

_CLEARANCE = 0.5
"""Radius of the disc that finds a path through a room, or that of a larger robot's feet [m]."""

_RESOLUTION = 0.05
"""Resolution of a room's map [m]."""

_MARGIN = 1.0
"""Distance by which uneven ground goes on beyond the map [m]."""

_AROUND = 5.0
"""Distance to which it goes from the start where there is no map [m]."""


@dataclass(frozen=True)
class Scenery:
    """What is in the world at first."""

    world: World
    grid: OccupancyGrid | None
    """Map of the world; None where it is not published."""
    start: Pose2D
    goal: Pose2D | None
    """Where the goal's marker lies at first; None: nowhere, or there is nothing to see."""
    bounds: tuple[float, float, float, float] | None = None
    """Area of its map or its room: x_min, y_min, x_max, y_max [m]; None without one."""
    height_map: HeightMap | None = None
    """Heights of the ground; None where it is flat, or they are not published."""


def scenery_from(parameters: SimParameters, robot: Robot) -> Scenery:
    """
    Read a map, or draw a room, and make the ground.

    Parameters
    ----------
    parameters : SimParameters
        Of the node.
    robot : Robot
        The robot, which needs room.

    Returns
    -------
    Scenery
        The world, its maps, the robot's start and, in a room, a goal.

    Raises
    ------
    ParameterError
        If parameters contradict each other, or the start is taken.
    MapError
        If a map file cannot be used.
    """
    return _with_terrain(_level_scenery(parameters, robot), parameters)


def _level_scenery(parameters: SimParameters, robot: Robot) -> Scenery:
    """Read a map, or draw a room."""
    p = parameters
    start = start_from('start_pose', p.start_pose)
    if p.room_seed >= 0:
        if p.map_file:
            raise ParameterError('room_seed', p.room_seed, f"-1 with 'map_file' {p.map_file!r}")
        room = random_room(
            p.room_seed,
            None if p.room_obstacles < 0 else p.room_obstacles,
            start,
            clearance=max(_CLEARANCE, robot.standing_radius),
            friction=p.friction,
        )
        grid = occupancy_of(room.world, _RESOLUTION, room.bounds)
        has_pictures = ENGINES[resolved(p.backend)].has_pictures
        goal = room.goal if has_pictures else None
        return Scenery(room.world, grid if p.publish_map else None, start, goal, room.bounds)
    if p.room_obstacles >= 0:
        raise ParameterError('room_obstacles', p.room_obstacles, "-1 without a 'room_seed'")
    walls = None if p.map_file == 'none' else load_map(p.map_file or sample_map())
    if walls is not None and ENGINES[resolved(p.backend)].has_world:
        check_start(robot, walls, start)
    world = world_from_map(walls, friction=p.friction)
    bounds = None if walls is None else walls.bounds()
    return Scenery(world, walls if p.publish_map else None, start, None, bounds)


def _with_terrain(scenery: Scenery, parameters: SimParameters) -> Scenery:
    """Make the ground of a scenery."""
    p = parameters
    specs = specs_from_text(
        p.terrain,
        height=p.terrain_height,
        angle=p.terrain_angle,
        size=p.terrain_size,
        length=p.terrain_length,
        clear=p.terrain_clear,
        seed=p.terrain_seed,
    )
    start, goal = scenery.start, scenery.goal
    level_at = tuple((pose.x, pose.y) for pose in (start, goal) if pose is not None)
    terrain = make_terrain(specs, _extent(scenery), start, level_at)
    if terrain is None:
        return scenery
    told = terrain.height_map if p.publish_height_map else None
    return replace(scenery, world=replace(scenery.world, terrain=terrain), height_map=told)


def _extent(scenery: Scenery) -> tuple[float, float, float, float]:
    """Return what uneven ground spans: x_min, y_min, x_max, y_max [m]."""
    start = scenery.start
    if scenery.bounds is None:
        return start.x - _AROUND, start.y - _AROUND, start.x + _AROUND, start.y + _AROUND
    x_min, y_min, x_max, y_max = scenery.bounds
    return x_min - _MARGIN, y_min - _MARGIN, x_max + _MARGIN, y_max + _MARGIN


def appearance_from(parameters: SimParameters, robot: Robot) -> Appearance:
    """Return colors and markers; ParameterError if a color is none."""
    robot_marker, goal_marker = markers_from(parameters, robot)
    return Appearance(
        floor_color=color_from(parameters, 'floor_color'),
        obstacle_color=color_from(parameters, 'obstacle_color'),
        checker_size=parameters.floor_checker,
        robot_marker=robot_marker,
        goal_marker=goal_marker,
    )


def camera_from(parameters: SimParameters) -> SimulatedCamera:
    """Return the camera; ParameterError if it cannot be made."""
    p = parameters
    low, high = _SIZES
    width, height = p.camera_size
    if not all(low <= side <= high and side == int(side) for side in (width, height)):
        raise ParameterError(
            'camera_size', p.camera_size, f'two whole numbers from {low} to {high} pixels'
        )
    model = CameraModel.looking_down(
        p.camera_position,
        p.camera_yaw,
        p.camera_field_of_view,
        (int(width), int(height)),
        p.camera_distortion,
    )
    if not model.position[2] > 0.0:
        raise ParameterError('camera_position', p.camera_position, 'above the floor')
    return SimulatedCamera(model, p.camera_noise, p.camera_brightness)
