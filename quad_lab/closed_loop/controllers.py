"""
Controllers for walks without topics, put together as gait_node does it.
"""

from __future__ import annotations

import math
from dataclasses import replace

from quad_common.robot.robot import Robot
from quad_gait.behaviours.walk_controller import ControllerOptions, WalkController
from quad_gait.cycle.gait import Gait, turning_gait_for
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.slip_compensation import NO_SLIP, SlipCompensation
from quad_gait.uneven.uneven_options import UnevenOptions


def controller_for(
    robot: Robot,
    gait: Gait,
    options: ControllerOptions | None = None,
    compensation: SlipCompensation = NO_SLIP,
) -> WalkController:
    """
    Make the controller of a gait, and of the one that turns on the spot with it.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    options : ControllerOptions, optional
        How it controls.
    compensation : SlipCompensation
        What is asked for more than is wanted.

    Returns
    -------
    WalkController
    """
    turning = turning_gait_for(gait, robot)
    return WalkController(robot, gait, turning, options or ControllerOptions(), compensation)


def for_uneven_ground(options: ControllerOptions) -> ControllerOptions:
    """Return options with which feet find uneven ground, and no margin is planned for."""
    return replace(options, least_margin=-math.inf, uneven=UnevenOptions())


def measuring_controller(
    robot: Robot,
    gait: Gait,
    hold_course: bool = True,
    compensation: SlipCompensation = NO_SLIP,
    follower: FollowerOptions | None = None,
    least_margin: float = 0.005,
) -> WalkController:
    """Make a controller for measuring: as gait_node does, with steering that never ends."""
    options = ControllerOptions(
        least_margin=least_margin,
        settle_time=0.2,
        hold_course=hold_course,
        twist_timeout=math.inf,
        follower=follower or FollowerOptions(),
    )
    return controller_for(robot, gait, options, compensation)
