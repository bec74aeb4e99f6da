"""
A ball thrown at a robot, as one tries it with a real one.
"""

from __future__ import annotations

import math

import numpy as np

from quad_common.rotations import matrix_from_quaternion
from quad_gait.balance.foot_laws import GRAVITY
from quad_lab.balance.balance_case import BalanceWalk
from quad_lab.balance.pushes import catches_itself
from quad_sim.engines.simulator import Ball

BALL_MASS = 0.25
"""Mass of the ball, over that of the robot: a medicine ball."""

_RADIUS = 0.3
"""Radius of the ball, over the height of the robot's center of mass."""

_LOOK = 0.01
"""Time between two looks at the body's velocity [s]."""

_AFTER = 0.1
"""Time after which it is taken away, so that nobody treads on it [s]."""


def hit(walk: BalanceWalk, impulse: float, angle: float) -> tuple[bool, float]:
    """
    Throw a ball at a robot's body, from outside its feet.

    Parameters
    ----------
    walk : BalanceWalk
        The robot.
    impulse : float
        Of the ball beside the robot, over m sqrt(g h) with the robot's mass. The body takes up
        most of it: the ball does not rebound.
    angle : float
        Direction in which it flies, in the world [rad].

    Returns
    -------
    survives : bool
        Whether the robot catches itself.
    gained : float
        Velocity that its body gained at most, up to 0.1 s after the hit, over sqrt(g h).
    """
    robot, simulation = walk.robot, walk.loop.simulation
    seen = simulation.observe()
    radius = _RADIUS * robot.center_height
    distance = robot.footprint_radius + robot.foot_radius + radius
    speed = impulse * walk.unit / BALL_MASS
    # Thrown upward by so much that it is as high again when it has come to the trunk.
    flight = distance / speed
    to_world = matrix_from_quaternion(seen.orientation)
    along = np.array([math.cos(angle), math.sin(angle), 0.0])
    rise = np.array([0.0, 0.0, GRAVITY * flight / 2.0])
    carried = to_world @ seen.linear_velocity_base_in_base
    before = walk.velocity
    simulation.throw(
        Ball(
            BALL_MASS * robot.mass,
            radius,
            seen.position - distance * along,
            carried + speed * along + rise,
        )
    )
    gained, end = 0.0, walk.loop.time + flight + _AFTER
    while walk.loop.time < end:
        walk.loop.run(_LOOK)
        gained = max(gained, float(np.linalg.norm(walk.velocity - before)) / walk.unit)
    simulation.throw(None)
    return catches_itself(walk), gained
