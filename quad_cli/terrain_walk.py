"""
Walks a robot over uneven ground in one process, without topics, and says how it went.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from quad_cli.direct_walk import DirectWalk
from quad_common.height_map import HeightMap
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D, distance_to_polyline
from quad_common.robot import Robot
from quad_gait.gait import load_gait, turning_gait_for
from quad_gait.uneven_stride import UnevenOptions
from quad_gait.walk_controller import Activity, ControllerOptions, WalkController
from quad_sim.simulator import Observation
from quad_sim.terrain_spec import make_terrain, specs_from_text
from quad_sim.world import World, world_from_map

HIP_HEIGHT = 0.243
"""Of TITAN-VIII, for which courses are given [m]; other robots walk them in proportion."""

COURSES = {
    'bumps': 'bumps:height=0.04',
    'slope': 'slope:angle=0.1745,length=1.2+noise:height=0.01',
    'cross_slope': 'cross_slope:angle=0.1396+noise:height=0.01',
    'kerb': 'kerb:height=0.05,length=2.0',
}
"""The ground of each course, in lengths of TITAN-VIII."""

LENGTH = 5.0
"""From the start to the goal [m], likewise."""

_HALF_WIDTH, _BEYOND = 1.5, 1.5
"""Of the ground beside and behind the way [m], likewise."""

_RESOLUTION = 0.02
"""Of the ground [m], likewise."""

_STRAY = 0.2
"""Starts are turned by up to this from the course's own direction [rad]."""

_STANDING = 1.0
"""A robot is left to settle for so long before it hears of its plan [s]."""

_TIMEOUT = 600.0
"""[s], simulated."""

_OVER = (Activity.ARRIVED, Activity.BLOCKED, Activity.STOPPED, Activity.FALLEN)


@dataclass(frozen=True)
class Course:
    """Ground, and a way over it."""

    world: World
    height_map: HeightMap
    plan: Plan

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
    """Largest distance from the planned way [m]."""


def make_course(robot: Robot, name: str, seed: int) -> Course:
    """
    Make a course in proportion to a robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    name : str
        One of :data:`COURSES`.
    seed : int
        Of the ground, and of the direction in which the robot crosses it.

    Returns
    -------
    Course
    """
    scale = robot.hip_height / HIP_HEIGHT
    turn = float(np.random.default_rng(seed).uniform(-_STRAY, _STRAY))
    start, end = Pose2D(0.0, 0.0, turn), Pose2D(0.0, 0.0, turn) @ Pose2D(scale * LENGTH, 0.0, 0.0)
    bounds = (
        -scale * _BEYOND,
        -scale * (_HALF_WIDTH + LENGTH * math.sin(_STRAY)),
        scale * (LENGTH + _BEYOND),
        scale * (_HALF_WIDTH + LENGTH * math.sin(_STRAY)),
    )
    specs = tuple(
        replace(
            spec,
            height=scale * spec.height,
            size=scale * spec.size,
            length=scale * spec.length,
            clear=scale * spec.clear,
            seed=seed,
        )
        for spec in specs_from_text(COURSES[name])
    )
    places = ((start.x, start.y), (end.x, end.y))
    terrain = make_terrain(
        specs, bounds, Pose2D(0.0, 0.0, 0.0), places, resolution=scale * _RESOLUTION
    )
    assert terrain is not None
    world = replace(world_from_map(None), terrain=terrain)
    return Course(world, terrain.height_map, Plan.through([places[0], places[1]], turn))


def walk_course(
    robot: Robot, course: Course, ground: str = 'uneven', sees: bool = True
) -> TerrainOutcome:
    """
    Walk a course in physics.

    Parameters
    ----------
    robot : Robot
        The robot.
    course : Course
        The ground, and the way over it.
    ground : str
        What the gait takes it for: ``uneven``, or ``flat``.
    sees : bool
        Whether the gait has the height map; without it the feet feel their way.

    Returns
    -------
    TerrainOutcome
        How it went.
    """
    gait = load_gait('crawl', robot)
    options = ControllerOptions(
        least_margin=-math.inf, uneven=UnevenOptions() if ground == 'uneven' else None
    )
    controller = WalkController(robot, gait, turning_gait_for(gait, robot), options)
    if sees:
        controller.set_height_map(course.height_map)
    walk = DirectWalk(robot, controller, world=course.world, start=course.start)
    contacts: set[str] = set()

    def note(seen: Observation) -> None:
        contacts.update(str(contact) for contact in seen.contacts)

    try:
        walk.run(_STANDING)
        walk.on_observation.append(note)
        controller.set_plan(course.plan)
        walk.run(_TIMEOUT, lambda: controller.activity in _OVER)
    finally:
        walk.close()
    record = walk.record
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
        off_plan=max(
            distance_to_polyline((pose.x, pose.y), corners) for pose in record.poses[since:]
        ),
    )
