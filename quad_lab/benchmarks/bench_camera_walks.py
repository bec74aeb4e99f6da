"""
Part of ``quadwalk bench camera``: whole walks by the camera alone, in physics.
"""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from rich.console import Console

from quad_common.errors import PlannerError
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.camera_walk import CameraWalk, CameraWalkOptions
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_planner.parameters import PlannerParameters
from quad_planner.planner_setup import planner_for
from quad_sim.world.obstacle_changes import ObstacleChange
from quad_sim.world.random_room import Room, random_room
from quad_sim.world.world import Obstacle, occupancy_of

_ROBOT = 'titan_viii'
_START = Pose2D(1.0, 1.0, 0.0)

_ROOMS, _DROPS = 20, 10

_LATENCIES = (0.0, 0.2, 0.5, 1.0)
"""Of pictures, for walks through one room [s]; the other walks have the usual one."""

_DROP_AT = 20.0
"""When an obstacle is dropped [s]."""
_DROP_AHEAD = 1.5
"""It is dropped at least so far from robot and goal [m]."""
_DROP_RADIUS, _DROP_HEIGHT = 0.15, 0.5
"""[m]"""

_RESOLUTION = 0.05
"""Of the true map [m]."""

_TIMEOUT = 900.0
"""A walk that takes longer has failed [s], simulated."""


@dataclass(frozen=True)
class _CameraWalkOutcome:
    """Of one walk."""

    room: int
    """Its seed."""
    arrived: bool
    problem: str
    """Why it did not arrive."""
    duration: float
    """[s], simulated"""
    contacts: int
    largest_error: float
    """Of the fused pose [m]."""
    rms_error: float
    """[m]"""
    dropped: bool
    """Whether an obstacle was dropped."""
    latency: float
    """From a picture to what is known of it [s]."""


@dataclass(frozen=True)
class _Job:
    """A walk."""

    seed: int
    """Of the room."""
    with_drop: bool = False
    """Whether an obstacle is dropped on the path."""
    latency: float = CameraWalkOptions.latency
    """[s]"""


def walk_bars(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], list[dict[str, Any]]]:
    """
    Walk through random rooms, some with an obstacle dropped on the path, one with late pictures.

    Parameters
    ----------
    console : Console
        Where progress is said.
    quick : bool
        No walk: they take too long.
    seed : int
        Of the first room.

    Returns
    -------
    bars : list of Criterion
        Not measured if there is no time for it.
    walks : list of dict
        How each walk went.
    """
    if quick:
        return [figure('walks by the camera alone: in the full run only', None, '')], []
    jobs = [_Job(seed + k) for k in range(_ROOMS)]
    jobs += [_Job(seed + 100 + k, with_drop=True) for k in range(_DROPS)]
    jobs += [_Job(seed + 1, latency=latency) for latency in _LATENCIES]
    outcomes: list[_CameraWalkOutcome] = []
    with worker_pool() as pool:
        for outcome in pool.map(_walk, jobs):
            end = 'arrived' if outcome.arrived else outcome.problem
            console.print(f'walk {len(outcomes) + 1} of {len(jobs)}, room {outcome.room}: {end}')
            outcomes.append(outcome)
    plain, drops = outcomes[:_ROOMS], outcomes[_ROOMS : _ROOMS + _DROPS]
    dropped = sum(outcome.dropped for outcome in drops)
    bars = [figure('obstacles dropped on the path', float(dropped), '')]
    for name, group in (('rooms', plain), ('rooms with an obstacle dropped', drops)):
        arrived = sum(outcome.arrived for outcome in group)
        contacts = sum(outcome.contacts for outcome in group)
        bars += [
            at_least(f'{name}: walks that arrived, of {len(group)}', arrived, '', len(group)),
            at_most(f'{name}: kinds of contact', contacts, '', 0.0),
        ]
    usual = plain + drops
    rms = math.sqrt(float(np.mean([outcome.rms_error**2 for outcome in usual])))
    bars += [
        at_most(
            'fused pose while walking, largest error',
            max(outcome.largest_error for outcome in usual),
            'm',
            0.03,
        ),
        figure('fused pose while walking, rms', rms, 'm'),
    ]
    bars += [bar for outcome in outcomes[len(usual) :] for bar in _late_bars(outcome)]
    return bars, [asdict(outcome) for outcome in outcomes]


def _late_bars(outcome: _CameraWalkOutcome) -> list[Criterion]:
    name = f'pictures {outcome.latency:.1f} s late: fused pose'
    return [
        at_most(f'{name}, largest error', outcome.largest_error, 'm', 0.03),
        figure(f'{name}, rms', outcome.rms_error, 'm'),
    ]


def _walk(job: _Job) -> _CameraWalkOutcome:
    room = random_room(job.seed, start=_START)
    options = CameraWalkOptions(
        method='shortest', picture_period=1.0, latency=job.latency, noise=4.0, seed=job.seed
    )
    walk = CameraWalk(load_robot(_ROBOT), room, options)
    has_dropped = False

    def drop(walk: CameraWalk) -> None:
        nonlocal has_dropped
        if job.with_drop and not has_dropped and walk.simulation.time > _DROP_AT:
            has_dropped = _drop_on_path(walk, room)

    try:
        record = walk.run(_TIMEOUT, drop)
    finally:
        walk.close()
    errors = np.array(record.pose_errors or [math.inf])
    return _CameraWalkOutcome(
        job.seed,
        record.arrived,
        record.problem,
        record.duration,
        len(record.contacts),
        float(errors.max()),
        float(np.sqrt(np.mean(errors**2))),
        has_dropped,
        job.latency,
    )


def _drop_on_path(walk: CameraWalk, room: Room) -> bool:
    """Put a pillar on the plan, ahead of the robot; return whether there is a place for it."""
    pose = walk.watch.fusion.pose
    if pose is None or walk.plan is None:
        return False
    corners = walk.plan.corners
    for a, b in pairwise(corners):
        for x, y in np.linspace(a, b, 8).tolist():
            place = Pose2D(x, y, 0.0)
            if min(place.distance_to(pose), place.distance_to(room.goal)) > _DROP_AHEAD:
                pillar = Obstacle.cylinder(x, y, _DROP_RADIUS, _DROP_HEIGHT)
                if _leaves_a_path(room, pillar, pose):
                    walk.simulation.change_obstacles([ObstacleChange('dropped', pillar)])
                    return True
    return False


def _leaves_a_path(room: Room, pillar: Obstacle, pose: Pose2D) -> bool:
    """Return whether the robot still gets from a pose to the goal, by the true map."""
    world = replace(room.world, obstacles=(*room.world.obstacles, pillar))
    robot = load_robot(_ROBOT)
    safety = PlannerParameters().safety_distance
    planner = planner_for(robot, 'shortest', safety, start_tolerance=safety)
    planner.set_map(occupancy_of(world, _RESOLUTION, room.bounds))
    try:
        planner.plan(pose, room.goal)
    except PlannerError:
        return False
    return True
