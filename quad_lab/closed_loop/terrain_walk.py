"""
Walks a robot over uneven ground in one process, without topics, and says how it went.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from quad_common.errors import ParameterError, PlannerError
from quad_common.maps.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_common.robot.robot import Robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.traversability import Ground
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_for
from quad_sim.engines.simulator import Observation
from quad_sim.world.terrain import Block, Terrain
from quad_sim.world.terrain_shapes import Scatter, boxes
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import Obstacle, World, occupancy_of, world_from_map

GROUNDS = {
    'bumps': 'bumps:height=0.04',
    'slope': 'slope:angle=0.1745,length=1.2+noise:height=0.01',
    'cross_slope': 'cross_slope:angle=0.1396+noise:height=0.01',
    'kerb': 'kerb:height=0.05,length=2.0',
}
"""The ground of the straight courses, in lengths of TITAN-VIII."""

COURSES = (*GROUNDS, 'boxes')
"""Ground to walk over, straight on; and a field of low boxes among large obstacles."""

LENGTH = 5.0
"""Distance from the start to the goal [m, of TITAN-VIII]."""

_HALF_WIDTH, _BEYOND = 1.5, 1.5
"""Extent of the ground beside the path, and beyond its ends [m, of TITAN-VIII]."""

_RESOLUTION = 0.02
"""Side of the cells of the ground [m, of TITAN-VIII]."""

_LOW_BOXES, _LOW = 20, 0.05
"""Number of low boxes, and height of the highest [m, of TITAN-VIII]."""

_PILLARS, _PLATFORMS = 3, 2
"""Large obstacles, which the map shows, and high blocks, which only the height map shows."""

_PILLAR, _PLATFORM = 0.5, 0.15
"""Their heights [m, of TITAN-VIII]."""

_AROUND_LARGE = 0.2
"""Distance of the first large one's middle from the straight path, at most [m, of TITAN-VIII]."""

_CLEAR = 0.9
"""Nothing large is so near to start and goal [m, of TITAN-VIII]."""

_GRID = 0.05
"""Side of the planner's cells [m, of TITAN-VIII]."""

_TRIES = 200

_STRAY = 0.2
"""Starts are turned by up to this from the course's own direction [rad]."""

_STANDING = 1.0
"""A robot is left to settle for so long before it receives its plan [s]."""

_TIMEOUT = 600.0
"""[s], simulated."""


@dataclass(frozen=True)
class Course:
    """Ground, and a path over it."""

    world: World
    height_map: HeightMap
    plan: Plan
    large_blocks: tuple[Block, ...] = ()
    """Blocks of the ground that no foot should touch."""
    low_boxes: int = 0
    """Number of those on which feet may come to stand along the path."""

    @property
    def start(self) -> Pose2D:
        """Where the robot stands at first."""
        return self.plan.poses[0]


@dataclass(frozen=True)
class TerrainOutcome:
    """Of one walk."""

    arrived: bool
    has_fallen: bool
    problem: str
    """Why it did not arrive."""
    duration: float
    """[s], simulated."""
    tilt_rms: float
    """Of the body while it walked [rad]."""
    largest_tilt: float
    """[rad]"""
    least_margin: float
    """Measured, static [m]."""
    contacts: tuple[str, ...]
    """Of anything but feet with the ground."""
    off_plan: float
    """Largest distance from the planned path [m]."""
    touches_large: bool
    """Whether it touched an obstacle, or a foot was over a large block."""


def make_course(robot: Robot, name: str, seed: int) -> Course:
    """
    Make a course in proportion to a robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    name : str
        One of :data:`COURSES`, or ground as :func:`~quad_sim.world.terrain_spec.specs_from_text`
        takes it, in lengths of TITAN-VIII.
    seed : int
        Of the ground, and of the direction in which the robot crosses it.

    Returns
    -------
    Course
    """
    if name == 'boxes':
        return _box_field(robot, seed)
    scale = robot.relative_size
    turn = float(np.random.default_rng(seed).uniform(-_STRAY, _STRAY))
    start, end = Pose2D(0.0, 0.0, turn), Pose2D(0.0, 0.0, turn) @ Pose2D(scale * LENGTH, 0.0, 0.0)
    bounds = (
        -scale * _BEYOND,
        -scale * (_HALF_WIDTH + LENGTH * math.sin(_STRAY)),
        scale * (LENGTH + _BEYOND),
        scale * (_HALF_WIDTH + LENGTH * math.sin(_STRAY)),
    )
    specs = tuple(spec.scaled(scale, seed) for spec in specs_from_text(GROUNDS.get(name, name)))
    places = ((start.x, start.y), (end.x, end.y))
    terrain = make_terrain(
        specs, bounds, Pose2D(0.0, 0.0, 0.0), places, resolution=scale * _RESOLUTION
    )
    assert terrain is not None
    world = replace(world_from_map(None), terrain=terrain)
    return Course(world, terrain.height_map, Plan.through([places[0], places[1]], turn))


def _box_field(robot: Robot, seed: int) -> Course:
    """Mix low boxes with large obstacles, and plan a path with both maps."""
    scale, rng = robot.relative_size, np.random.default_rng(seed)
    bounds = (-scale * _BEYOND, -2.2 * scale, scale * (LENGTH + _BEYOND), 2.2 * scale)
    start, goal = Pose2D(0.0, 0.0, 0.0), Pose2D(scale * LENGTH, 0.0, 0.0)
    level = HeightMap.level(bounds, scale * _RESOLUTION)
    for _ in range(_TRIES):
        large = _large_places(rng, scale)
        pillars = tuple(
            Obstacle.cylinder(pose.x, pose.y, 0.15 * scale, scale * _PILLAR)
            for pose in large[:_PILLARS]
        )
        platforms = tuple(
            Block(pose, 0.4 * scale, 0.3 * scale, scale * _PLATFORM) for pose in large[_PILLARS:]
        )
        places = tuple((pose.x, pose.y) for pose in (start, goal, *large))
        scatter = Scatter(0.35 * scale, 0.3, places, clear=0.45 * scale)
        low = boxes(level, rng, scale * _LOW, scatter)
        world = replace(world_from_map(None), obstacles=pillars)
        try:
            plan = _planned(robot, _with_blocks(world, level, platforms), bounds, start, goal)
        except PlannerError:
            continue
        low = tuple(sorted(low, key=lambda block: _beside(block, plan))[:_LOW_BOXES])
        world = _with_blocks(world, level, platforms + low)
        plan = _planned(robot, world, bounds, start, goal)
        assert world.terrain is not None
        half = float(np.abs(robot.neutral_feet[:, 1]).max())
        crossed = sum(_beside(block, plan) < half for block in low)
        return Course(world, world.terrain.height_map, plan, platforms, crossed)
    raise ParameterError('seed', seed, 'one with which the large obstacles leave a path')


def _with_blocks(world: World, level: HeightMap, blocks: tuple[Block, ...]) -> World:
    return replace(world, terrain=Terrain(level, blocks))


def _beside(block: Block, plan: Plan) -> float:
    """How far the middle of a block is from a path [m]."""
    return distance_to_polyline((block.pose.x, block.pose.y), plan.corners)


def _planned(
    robot: Robot,
    world: World,
    bounds: tuple[float, float, float, float],
    start: Pose2D,
    goal: Pose2D,
) -> Plan:
    """Plan with both maps, as the planner node does."""
    scale = robot.relative_size
    safety = scale * PlannerParameters().safety_distance
    planner = planner_for(robot, 'shortest', safety, any_angle=True, start_tolerance=safety)
    assert world.terrain is not None
    ground = Ground(world.terrain.height_map, GroundLimits.of(robot))
    planner.set_map(ground.added_to(occupancy_of(world, scale * _GRID, bounds)))
    return planner.plan(start, goal)


def _large_places(rng: np.random.Generator, scale: float) -> list[Pose2D]:
    """Draw where large things stand: on and beside the straight path, apart from each other."""
    places: list[Pose2D] = []
    while len(places) < _PILLARS + _PLATFORMS:
        x = float(rng.uniform(_CLEAR, LENGTH - _CLEAR))
        y = float(rng.uniform(-1.6, 1.6)) if places else float(rng.uniform(-1, 1) * _AROUND_LARGE)
        pose = Pose2D(scale * x, scale * y, float(rng.uniform(-math.pi, math.pi)))
        if all(pose.distance_to(other) > 0.6 * scale for other in places):
            places.append(pose)
    return places


def walk_course(
    robot: Robot,
    course: Course,
    ground: str = 'uneven',
    sees: bool = True,
    footsteps: bool = False,
) -> TerrainOutcome:
    """
    Walk a course in physics.

    Parameters
    ----------
    robot : Robot
        The robot.
    course : Course
        The ground, and the path over it.
    ground : str
        What the gait takes it for: ``uneven``, or ``flat``.
    sees : bool
        Whether the gait has the height map; without it the feet feel their way.
    footsteps : bool
        Whether it plans footsteps where strides find no even ground.

    Returns
    -------
    TerrainOutcome
        How it went.
    """
    gait = load_gait('crawl', robot)
    options = SupervisorOptions(least_margin=-math.inf)
    if ground == 'uneven':
        options = for_uneven_ground(options, footsteps)
    controller = controller_for(robot, gait, options)
    if sees:
        controller.set_height_map(course.height_map)
    walk = ClosedLoop(robot, controller, world=course.world, start=course.start)
    contacts: set[str] = set()

    touched = [False]

    def note(seen: Observation) -> None:
        contacts.update(str(contact) for contact in seen.contacts)
        touched[0] |= any(contact.other == 'obstacle' for contact in seen.contacts)
        over = [block.covers(walk.feet[:, :2]).any() for block in course.large_blocks]
        touched[0] |= any(over)

    try:
        walk.run(_STANDING)
        walk.on_observation.append(note)
        controller.set_plan(course.plan)
        walk.run(_TIMEOUT, lambda: controller.activity.is_terminal)
    finally:
        walk.close()
    return _outcome(walk, course, contacts, touched[0])


def _outcome(
    walk: ClosedLoop, course: Course, contacts: set[str], touches_large: bool
) -> TerrainOutcome:
    controller, record = walk.controller, walk.record
    since = int(np.searchsorted(record.times, _STANDING))
    tilts = np.array(record.tilts[since:])
    arrived = controller.activity is Activity.ARRIVED
    corners = course.plan.corners
    return TerrainOutcome(
        arrived=arrived,
        has_fallen=record.has_fallen or controller.activity is Activity.FALLEN,
        problem='' if arrived else controller.reason,
        duration=walk.time - _STANDING,
        tilt_rms=float(np.sqrt(np.mean(tilts**2))),
        largest_tilt=float(tilts.max()),
        least_margin=min(record.margins[since:]),
        contacts=tuple(sorted(contacts)),
        touches_large=touches_large,
        off_plan=max(
            distance_to_polyline((pose.x, pose.y), corners) for pose in record.poses[since:]
        ),
    )
