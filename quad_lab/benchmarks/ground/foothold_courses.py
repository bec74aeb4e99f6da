"""
Walks over staircases and stepping stones, and plans of footsteps over them, without topics.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, replace

import numpy as np

from quad_common.errors import GaitError
from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_gait.footsteps.foothold_map import FootholdMap
from quad_gait.footsteps.footstep_options import FootstepOptions
from quad_gait.footsteps.footstep_planner import FootstepPlanner
from quad_gait.uneven.uneven_options import UnevenOptions
from quad_lab.closed_loop.terrain_walk import Course
from quad_sim.world.terrain_spec import TerrainSpec, make_terrain
from quad_sim.world.world import world_from_map

COURSES = ('stairs', 'stones')
"""Ground that asks for footholds."""

_TREAD, _LANDING, _STAIRS = 0.3, 1.0, 10
"""Depth of the treads and length of the landing [m, of TITAN-VIII], and number of stairs."""

_STONE, _PATH = 0.2, 2.0
"""Side of the stones, and length of the path over them [m, of TITAN-VIII]."""

_LOWER = 0.02
"""Stones are so much lower than the ground at most [m, of TITAN-VIII]."""

_CLEAR, _HALF_WIDTH = 0.8, 1.2
"""Level ground around start and goal, and extent beside the path [m, of TITAN-VIII]."""

_STRAY = 0.1
"""Stairs and rows of stones are off the right angle to the path by up to this [rad]."""

_RESOLUTION = 0.02
"""Side of the cells of the ground [m, of TITAN-VIII]."""

_FAR = 2.2
"""Distance to which footsteps are planned [m, of TITAN-VIII]."""


@dataclass(frozen=True)
class PlannedFootsteps:
    """What it took to plan footsteps."""

    steps: int
    """Number of footsteps; 0 if none were found."""
    duration: float
    """Time that it took, footholds included [s]."""
    expansions: int
    """Number of stances from which steps were looked for."""


def foothold_course(robot: Robot, name: str, seed: int) -> Course:
    """
    Make a course in proportion to a robot.

    Parameters
    ----------
    robot : Robot
        The robot.
    name : str
        One of :data:`COURSES`: ten stairs of half the robot's step height, up and down; or stepping
        stones with gaps of a quarter of a leg.
    seed : int
        Of the stones, and of the direction in which the robot crosses them.

    Returns
    -------
    Course
    """
    scale = robot.relative_size
    spec = _spec(robot, name)
    turn = float(np.random.default_rng(seed).uniform(-_STRAY, _STRAY))
    ahead = 2.0 * (spec.count - 1) * spec.size + spec.length if name == 'stairs' else spec.length
    length = ahead + 2.5 * spec.clear
    side = scale * _HALF_WIDTH
    bounds = (-scale, -side, length + scale, side)
    goal = Pose2D(length, 0.0, 0.0)
    spec = replace(spec, seed=seed)
    terrain = make_terrain(
        (spec,), bounds, Pose2D(0.0, 0.0, turn), ((0.0, 0.0), (length, 0.0)), scale * _RESOLUTION
    )
    assert terrain is not None
    world = replace(world_from_map(None), terrain=terrain)
    return Course(world, terrain.height_map, Plan.through([(0.0, 0.0), (goal.x, goal.y)], 0.0))


def _spec(robot: Robot, name: str) -> TerrainSpec:
    scale = robot.relative_size
    clear = scale * _CLEAR
    if name == 'stairs':
        return TerrainSpec(
            'stairs',
            height=0.5 * robot.step_height,
            size=scale * _TREAD,
            length=scale * _LANDING,
            clear=clear,
            count=_STAIRS,
        )
    leg = float(robot.legs[0].thigh_length + robot.legs[0].calf_length)
    return TerrainSpec(
        'stones',
        height=scale * _LOWER,
        size=scale * _STONE,
        length=scale * _PATH,
        clear=clear,
        gap=0.25 * leg,
        depth=0.3 * scale,
    )


def plan_footsteps(robot: Robot, seed: int) -> PlannedFootsteps:
    """
    Plan footsteps from the ground before stepping stones onto them.

    Parameters
    ----------
    robot : Robot
        The robot.
    seed : int
        Of the stones.

    Returns
    -------
    PlannedFootsteps
        The second of two plans: the first also makes tables, and loads what is compiled.
    """
    options, scale = FootstepOptions(), robot.relative_size
    course = foothold_course(robot, 'stones', seed)
    ground = FootholdMap(robot, UnevenOptions(), options, course.height_map)
    planner = FootstepPlanner(robot, options)
    feet = robot.neutral_feet + np.array([0.1 * scale, 0.0, 0.0])
    feet[:, 2] = course.height_map.height_at(feet[:, :2]) + robot.foot_radius
    target = Pose2D(0.1 * scale + scale * _FAR, 0.0, 0.0)
    planned = PlannedFootsteps(0, math.nan, 0)
    for _ in range(2):
        begun = time.perf_counter()
        try:
            plan = planner.plan(feet, target, ground)
        except GaitError:
            continue
        duration = time.perf_counter() - begun
        planned = PlannedFootsteps(len(plan.steps), duration, plan.expansions)
    return planned
