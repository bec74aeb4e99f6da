"""
Controllers for walks without topics, put together as gait_node does it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from quad_common.robot.robot import Robot
from quad_gait.behaviours.options import SupervisorOptions
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait, turning_gait_for
from quad_gait.following.follower_options import FollowerOptions
from quad_gait.following.gait_pair import GaitPair
from quad_gait.following.slip_compensation import NO_SLIP, SlipCompensation
from quad_gait.supervisor import Supervisor
from quad_gait.uneven.uneven_options import UnevenOptions


@dataclass(frozen=True)
class LargestSpeed:
    """The most that a gait does in one direction."""

    scale: float
    """How many times the direction fits into a second [1/s]; 0 if the gait does none of it."""
    period: float
    """Duration of a cycle of the gait that does it [s]."""
    reason: str
    """Reason why more is not possible."""


def controller_for(
    robot: Robot,
    gait: Gait,
    options: SupervisorOptions | None = None,
    compensation: SlipCompensation = NO_SLIP,
) -> Supervisor:
    """
    Make the controller of a gait, and of the one that turns on the spot with it.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    options : SupervisorOptions, optional
        How it controls.
    compensation : SlipCompensation
        What is asked for more than is wanted.

    Returns
    -------
    Supervisor
    """
    turning = turning_gait_for(gait, robot)
    return Supervisor(robot, gait, turning, options or SupervisorOptions(), compensation)


def largest_speed(
    robot: Robot, gait: Gait, direction: BodyMotion, least_margin: float = 0.0
) -> LargestSpeed:
    """
    Find how fast a robot goes at most with a gait, and with the one that turns on the spot with it.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    direction : BodyMotion
        Direction of the motion; its size does not matter.
    least_margin : float
        That cycles must keep [m].
    """
    pair = GaitPair(robot, gait, turning_gait_for(gait, robot), least_margin)
    limits = pair.of_twist(direction.rate(1.0))
    scale = limits.largest_scale(direction)
    return LargestSpeed(scale / limits.period, limits.period, limits.reason(direction))


def for_uneven_ground(options: SupervisorOptions, footsteps: bool = False) -> SupervisorOptions:
    """Return options with which feet find uneven ground, and no margin is planned for."""
    uneven = UnevenOptions(plans_footsteps=footsteps)
    return replace(options, least_margin=-math.inf, uneven=uneven)


def measuring_controller(
    robot: Robot,
    gait: Gait,
    hold_course: bool = True,
    compensation: SlipCompensation = NO_SLIP,
    follower: FollowerOptions | None = None,
    least_margin: float = 0.005,
) -> Supervisor:
    """Make a controller for measuring: as gait_node does, with steering that never ends."""
    options = SupervisorOptions(
        least_margin=least_margin,
        settle_time=0.2,
        hold_course=hold_course,
        twist_timeout=math.inf,
        follower=follower or FollowerOptions(),
    )
    return controller_for(robot, gait, options, compensation)
