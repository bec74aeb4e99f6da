"""
A walk on an open floor with plans that change at any moment, in any direction.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import SENSOR_PERIOD, ClosedLoop
from quad_lab.closed_loop.controllers import measuring_controller

DURATION = 20.0
"""Time that is walked [s], simulated."""

_KEPT = (0.3, 4.0)
"""Shortest and longest time for which a plan counts [s]."""

_NEAR, _FAR = 0.08, 0.8
"""Largest distance of goals that ask for a turn, a little aside, and of others [m]."""


@dataclass(frozen=True)
class ChangedWalk:
    """How such a walk went."""

    robot: str
    """Name of the robot."""
    seed: int
    """Seed of its plans."""
    fell_at: float | None
    """Time at which it fell [s]; None if it did not."""
    largest_tilt: float
    """Largest tilt of the body [rad]."""
    arrived: int
    """Number of goals that were reached before the next plan came."""


def walk_changing_plans(
    robot: str, seed: int, backend: str, gait: str = 'trot', duration: float = DURATION
) -> ChangedWalk:
    """
    Give a robot one plan after the other, most of them before the last one is walked.

    Half of the goals are within 8 cm, with any heading: turns on the spot, to either side, while
    the place is corrected. The others are up to 0.8 m away.

    Parameters
    ----------
    robot : str
        Name of the robot.
    seed : int
        Of goals and moments.
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    gait : str
        Name of the gait.
    duration : float
        Time that is walked, if the robot does not fall [s].

    Returns
    -------
    ChangedWalk
        How it went.
    """
    rng = np.random.default_rng((seed, 77))
    model = load_robot(robot)
    controller = measuring_controller(model, load_gait(gait, model))
    loop = ClosedLoop(model, controller, backend)
    next_plan, arrived, has_goal = 0.5, 0, False
    try:
        while loop.time < duration and controller.activity is not Activity.FALLEN:
            if loop.time >= next_plan:
                controller.set_plan(_drawn(loop.simulation.observe().pose, rng))
                next_plan = loop.time + float(rng.uniform(*_KEPT))
                has_goal = True
            loop.run(SENSOR_PERIOD)
            if has_goal and controller.activity is Activity.ARRIVED:
                arrived, has_goal = arrived + 1, False
        fell = controller.activity is Activity.FALLEN
        tilt = float(np.max(loop.record.tilts))
        return ChangedWalk(robot, seed, loop.time if fell else None, tilt, arrived)
    finally:
        loop.close()


def _drawn(pose: Pose2D, rng: np.random.Generator) -> Plan:
    """Draw a plan from a pose: a turn with a correction, or a straight line and a turn."""
    is_near = rng.random() < 0.5
    distance = float(rng.uniform(0.0, _NEAR if is_near else _FAR))
    course, heading = (float(angle) for angle in rng.uniform(-math.pi, math.pi, 2))
    there = pose @ Pose2D(distance * math.cos(course), distance * math.sin(course), 0.0)
    goal = Pose2D(there.x, there.y, heading)
    if is_near:
        return Plan((Pose2D(there.x, there.y, pose.yaw), goal))
    return Plan((Pose2D(pose.x, pose.y, pose.yaw + course), goal))
