"""
Walks between random places of a map over random ground, as a user would ask for them.

The courses of :mod:`~quad_lab.closed_loop.terrain_walk` lead straight on. Here the planner decides
where the robot turns, and start and goal lie wherever they were drawn.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from quad_common.errors import PlannerError
from quad_common.maps.height_map import HeightMap
from quad_common.maps.map_file import load_map
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.resources import sample_map
from quad_common.robot.robot import Robot
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait, resting
from quad_gait.uneven.ways_out import WayOut
from quad_lab.closed_loop.closed_loop import ClosedLoop, Place
from quad_lab.closed_loop.controllers import controller_for, for_uneven_ground
from quad_lab.closed_loop.guided_end import GuidedEnd
from quad_lab.closed_loop.planner_in_loop import PlannerInLoop
from quad_lab.closed_loop.random_goals import NoGoalFound
from quad_planner.grid.ground_limits import GroundLimits
from quad_planner.grid.traversability import Ground
from quad_planner.methods.planner import Planner
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_from_parameters
from quad_sim.engines.registry import AUTO
from quad_sim.engines.simulator import Observation
from quad_sim.simulated_localisation import LocalisationOptions, SimulatedLocalisation
from quad_sim.world.terrain import Terrain
from quad_sim.world.terrain_spec import make_terrain, specs_from_text
from quad_sim.world.world import World, world_from_map

TERRAINS = {
    'noise': 'noise:height=0.05',
    'bumps': 'bumps:height=0.05',
    'boxes': 'boxes:height=0.05',
    'noise+boxes': 'noise:height=0.05+boxes:height=0.05',
    'kerb': 'kerb:height=0.05',
    'slope': 'slope',
}
"""Kinds of ground, in lengths of TITAN-VIII, as sim_node's parameter ``terrain``."""

MAPS = ('room', 'office')
"""Sample maps on which starts and goals are drawn."""

_SHORTEST, _LONGEST = 1.0, 4.0
"""Lengths of plans [m, of TITAN-VIII]."""

_RESOLUTION = 0.02
"""Side of the cells of the ground [m, of TITAN-VIII]."""

_MARGIN = 1.0
"""Distance by which the ground goes on beyond where plans lead [m, of TITAN-VIII]."""

_STARTS, _GOALS = 500, 60
"""Starts that are drawn before it is given up, and goals for each that is free."""

_ANYWHERE = Pose2D(0.0, 0.0, 0.0)

_STANDING = 1.0
"""A robot is left to settle for so long before it receives its goal [s]."""

_TIMEOUT = 1500.0
"""[s], simulated."""

_WAYS = tuple(way.value for way in WayOut)
"""What begins a sentence that says which way out is tried."""

_EXACT = LocalisationOptions()
"""Odometry that does not drift."""

_ALARMS = frozenset({Activity.LAME, Activity.NOT_EXECUTED, Activity.FALLEN, Activity.BLOCKED})
"""Activities with which a sound robot raises a false alarm."""


@dataclass(frozen=True)
class Scene:
    """Ground on a map, and what the robot is asked for."""

    terrain: str
    """One of :data:`TERRAINS`."""
    map_name: str
    """One of :data:`MAPS`."""
    seed: int
    """Seed of everything that was drawn."""
    world: World
    """World with walls and ground."""
    grid: OccupancyGrid
    """Map that the planner receives."""
    start: Pose2D
    """Pose of the robot at first."""
    goal: Pose2D
    """Goal; there is a plan that leads to it."""

    @property
    def height_map(self) -> HeightMap:
        """Heights that planner and gait receive."""
        assert self.world.terrain is not None
        return self.world.terrain.height_map


@dataclass(frozen=True)
class GroundOutcome:
    """What became of one walk."""

    arrived: bool
    has_fallen: bool
    problem: str
    """Why it did not arrive; empty if it did."""
    duration: float
    """[s], simulated."""
    distance: float
    """Distance from the goal at the end [m]."""
    turn: float
    """Angle from the goal's heading at the end [rad]."""
    contacts: tuple[str, ...]
    """Contacts of anything but feet."""
    alarms: tuple[str, ...]
    """What the robot said to be wrong with itself, though it is sound."""
    ways_out: tuple[str, ...]
    """Ways out that it tried, in order."""
    plans: int
    """Number of plans."""
    largest_tilt: float
    """Of the body while it walked [rad]."""

    @property
    def is_good(self) -> bool:
        """Whether it arrived, on its feet alone, and raised no alarm."""
        return self.arrived and not (self.has_fallen or self.contacts or self.alarms)


def make_scene(robot: Robot, terrain: str, seed: int) -> Scene:
    """
    Draw a map, a start, the ground and a goal.

    Parameters
    ----------
    robot : Robot
        The robot; lengths of the ground and of the plan are in proportion to it.
    terrain : str
        One of :data:`TERRAINS`.
    seed : int
        Of everything that is drawn.

    Returns
    -------
    Scene

    Raises
    ------
    NoGoalFound
        If none of many goals has a plan.
    """
    rng = np.random.default_rng((seed, list(TERRAINS).index(terrain)))
    map_name = str(rng.choice(MAPS))
    grid = load_map(sample_map(map_name))
    parameters = PlannerParameters(robot=robot.name)
    lengths = robot.relative_size * _SHORTEST, robot.relative_size * _LONGEST
    on_floor = planner_from_parameters(parameters, robot)
    on_floor.set_map(grid)
    start = _ANYWHERE
    for _ in range(_STARTS):
        start = _drawn_pose(rng, grid.bounds())
        if _plan_length(on_floor, start, start) is None:
            continue
        world = replace(world_from_map(grid), terrain=_ground(robot, terrain, seed, start))
        assert world.terrain is not None
        scene = Scene(terrain, map_name, seed, world, grid, start, start)
        planner = planner_from_parameters(parameters, robot)
        planner.set_map(Ground(scene.height_map, GroundLimits.of(robot)).added_to(grid))
        for _ in range(_GOALS):
            goal = _drawn_goal(rng, start, lengths[1])
            length = _plan_length(planner, start, goal)
            if length is not None and lengths[0] <= length <= lengths[1]:
                return replace(scene, goal=goal)
    raise NoGoalFound(_STARTS * _GOALS, lengths, start)


def _ground(robot: Robot, terrain: str, seed: int, start: Pose2D) -> Terrain | None:
    """Make the ground around a start, in proportion to the robot; level beneath it, as a demo's."""
    scale = robot.relative_size
    # As far as plans lead, and no farther: a small robot's ground has small cells.
    around = scale * (_LONGEST + _MARGIN)
    bounds = start.x - around, start.y - around, start.x + around, start.y + around
    specs = tuple(spec.scaled(scale, seed) for spec in specs_from_text(TERRAINS[terrain]))
    return make_terrain(specs, bounds, start, ((start.x, start.y),), scale * _RESOLUTION)


def _drawn_pose(rng: np.random.Generator, bounds: tuple[float, float, float, float]) -> Pose2D:
    x, y = rng.uniform(bounds[:2], bounds[2:])
    return Pose2D(round(float(x), 3), round(float(y), 3), float(rng.uniform(-math.pi, math.pi)))


def _drawn_goal(rng: np.random.Generator, start: Pose2D, farthest: float) -> Pose2D:
    low = np.array([start.x, start.y]) - farthest
    return _drawn_pose(rng, (*low, *(low + 2.0 * farthest)))


def _plan_length(planner: Planner[Any], start: Pose2D, goal: Pose2D) -> float | None:
    """Return the length of the plan [m]; None if there is none."""
    try:
        return planner.plan(start, goal).length
    except PlannerError:
        return None


@dataclass(frozen=True)
class Knowledge:
    """What a robot is told of the ground and of its place."""

    height_map: HeightMap | None
    """Heights of the ground; None if there is no map of it."""
    localisation: LocalisationOptions = _EXACT
    """Odometry, and what corrects it; exact if not given."""


class GroundWalk:
    """
    A robot in a scene, its planner's session and its gait.

    Parameters
    ----------
    robot : Robot
        The robot.
    scene : Scene
        The scene.
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    knowledge : Knowledge, optional
        What it is told of the scene; the truth if not given.
    gait_name : str
        Name of its gait.
    """

    def __init__(
        self,
        robot: Robot,
        scene: Scene,
        backend: str = AUTO,
        knowledge: Knowledge | None = None,
        gait_name: str = 'crawl',
    ) -> None:
        self.scene = scene
        """What is walked."""
        knowledge = knowledge or Knowledge(scene.height_map)
        self._localisation = SimulatedLocalisation(knowledge.localisation)
        gait = resting(load_gait(gait_name, robot))
        self.controller = controller_for(robot, gait, for_uneven_ground(SupervisorOptions()))
        """What moves the robot."""
        self.loop = ClosedLoop(robot, self.controller, backend, scene.world, scene.start)
        """The closed loop."""
        self.loop.locate = self._locate
        self.planner = PlannerInLoop(robot, self.controller, PlannerParameters(robot=robot.name))
        """What plans."""
        session, frame = self.planner.session, self.planner.frame.name
        session.take_grid(scene.grid, frame)
        if knowledge.height_map is not None:
            self.controller.set_height_map(knowledge.height_map)
            session.take_heights(knowledge.height_map, frame)
        self._is_given = False
        self._contacts: set[str] = set()
        self._alarms: set[str] = set()
        self._ways_out: list[str] = []
        self._said = ''

    def run(self, timeout: float = _TIMEOUT) -> GroundOutcome:
        """Walk until the robot has arrived or given up; at most so long [s], simulated."""
        loop, controller, goal = self.loop, self.controller, self.scene.goal
        loop.run(_STANDING)
        loop.on_observation.append(self._note)
        self.planner.session.give_goal(self.planner.frame.name, goal)
        self._is_given = True
        end = GuidedEnd()
        is_over = loop.run(timeout, lambda: end.is_over(loop.time, controller.activity))
        pose = loop.simulation.observe().pose
        arrived = controller.activity is Activity.ARRIVED
        problem = '' if arrived else f'{controller.activity.value}: {controller.reason}'
        if not is_over:
            problem = f'not there within {timeout:g} s: {problem}'
        return GroundOutcome(
            arrived=arrived,
            has_fallen=loop.record.has_fallen or controller.activity is Activity.FALLEN,
            problem=self.planner.problem or problem,
            duration=loop.time - _STANDING,
            distance=pose.distance_to(goal),
            turn=abs(wrap_angle(pose.yaw - goal.yaw)),
            contacts=tuple(sorted(self._contacts)),
            alarms=tuple(sorted(self._alarms)),
            ways_out=tuple(self._ways_out),
            plans=self.planner.plans,
            largest_tilt=float(loop.record.tilts.max()),
        )

    def close(self) -> None:
        """Release the simulator."""
        self.loop.close()

    def _note(self, seen: Observation) -> None:
        self._contacts.update(str(contact) for contact in seen.contacts)
        if self.controller.activity in _ALARMS:
            self._alarms.add(f'{self.controller.activity.value}: {self.controller.reason}')
        limit = self.controller.limit
        if limit.startswith(_WAYS) and limit != self._said:
            self._ways_out.append(limit)
        self._said = limit

    def _locate(self, seen: Observation) -> Place:
        """Return where the robot takes itself to be, and tell the planner."""
        pose = self._localisation.observe(seen).pose
        if self._is_given:
            self.planner.take_pose(seen.time, pose)
        return pose, pose


def walk_scene(
    robot: Robot,
    scene: Scene,
    backend: str = AUTO,
    knowledge: Knowledge | None = None,
    gait_name: str = 'crawl',
) -> GroundOutcome:
    """
    Walk in a scene.

    Parameters
    ----------
    robot : Robot
        The robot.
    scene : Scene
        As :func:`make_scene` draws it.
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    knowledge : Knowledge, optional
        What the robot is told of the scene; the truth if not given.
    gait_name : str
        Name of its gait.

    Returns
    -------
    GroundOutcome
        How it went.
    """
    walk = GroundWalk(robot, scene, backend, knowledge, gait_name)
    try:
        return walk.run()
    finally:
        walk.close()
