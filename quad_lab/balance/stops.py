"""
A balanced trot along a plan with a corner: how far beyond its stops it goes, and what its legs say.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from quad_common.plan import Plan
from quad_common.planar_pose import Pose2D
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.behaviours.activity import Activity
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.gait import load_gait
from quad_lab.balance.balance_case import LATENCY, push_unit, trotting_robot
from quad_lab.closed_loop.balance_loop import BalanceLoop
from quad_lab.closed_loop.closed_loop import true_place
from quad_lab.closed_loop.controllers import controller_for

_AHEAD, _ASIDE = 2.0, 1.0
"""Length of the way to the corner, and from it to the goal, in units of sqrt(g h) times 1 s."""

_PATIENCE = 60.0
"""Time for the walk, at most [s]."""


@dataclass(frozen=True)
class StoppedWalk:
    """A walk straight on, a corner of 90 degrees to the left, and a shorter way to the goal."""

    robot: str
    """Name of the robot."""
    has_arrived: bool
    """Whether the robot says that it has."""
    beyond: float
    """Distance by which it went beyond the corner or the goal, at most [m]."""
    odometry_error: float
    """Distance by which it was elsewhere than its legs told, at most, per distance walked."""
    position_error: float
    """Distance to the goal at the end [m]."""
    duration: float
    """Time that it took [s]."""


def stopped_walk(name: str, period: float | None, seed: int = 0) -> StoppedWalk:
    """
    Trot along a plan with a corner, and stop at it and at its end.

    Parameters
    ----------
    name : str
        Name of the robot.
    period : float or None
        Period of its trot [s]; its own if None.
    seed : int
        Seed of its sensors' errors.

    Returns
    -------
    StoppedWalk
        The robot is told where it is; what its legs tell is only compared with that.
    """
    robot = trotting_robot(name, period)
    options = SupervisorOptions(least_margin=0.005, balance=BalanceOptions())
    controller = controller_for(robot, load_gait('trot', robot), options)
    loop = BalanceLoop(robot, controller, LATENCY, seed=seed)
    loop.locate = true_place
    unit = push_unit(robot)
    corner = Pose2D(_AHEAD * unit, 0.0, math.pi / 2.0)
    goal = Pose2D(corner.x, _ASIDE * unit, math.pi / 2.0)
    apart: list[float] = []
    try:
        loop.on_observation.append(
            lambda seen: apart.append(seen.pose.distance_to(loop.pose_by_legs))
        )
        loop.run(0.3)
        controller.set_plan(Plan((Pose2D(0.0, 0.0, 0.0), corner, goal)))
        arrived = loop.run(_PATIENCE, lambda: controller.activity is Activity.ARRIVED)
        places = np.array([(pose.x, pose.y) for pose in loop.record.poses])
        return StoppedWalk(
            name,
            arrived,
            float(np.max(places - (goal.x, goal.y))),
            max(apart) / ((_AHEAD + _ASIDE) * unit),
            loop.record.poses[-1].distance_to(goal),
            loop.time,
        )
    finally:
        loop.close()
