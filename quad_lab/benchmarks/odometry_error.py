"""
How far leg odometry goes astray, measured in physics.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.robot import Robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait
from quad_gait.state.leg_odometry import LegOdometry
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import measuring_controller
from quad_lab.closed_loop.loop_record import Record
from quad_sim.engines.simulator import Observation

Array = NDArray[np.float64]


def leg_odometry_error(
    robot: Robot, gait: Gait, direction: BodyMotion, duration: float
) -> tuple[float, float]:
    """
    Compare leg odometry with where the robot really went.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    direction : BodyMotion
        Direction in which it is steered, at 60 % of the most.
    duration : float
        [s]

    Returns
    -------
    tuple of float
        Error of the position over the distance walked, and of the heading [rad] over the
        turns made, or over one turn if there were fewer.
    """
    controller = measuring_controller(robot, gait)
    walk = ClosedLoop(robot, controller)
    odometry = LegOdometry(robot)
    turned = [0.0]

    def listen(seen: Observation) -> None:
        # Without the imu's absolute heading: its rate alone, as a cheap imu gives it.
        rate = float(seen.angular_velocity_base_in_base[2])
        odometry.update(seen.time, seen.joint_positions, None, None, rate)
        turned[0] += rate * 0.02

    walk.on_observation.append(listen)
    try:
        walk.run(0.1)
        gear = controller.gait_pair.of_twist(direction.rate(1.0))
        asked = direction.scaled(0.6 * gear.largest_scale(direction))
        controller.set_twist(asked.rate(gear.period))
        walk.run(duration)
        last = walk.record.poses[-1]
        # The controller's own record of the path, not the straight line: turns come back.
        distance = float(np.linalg.norm(np.diff(_smoothed(walk.record), axis=0), axis=1).sum())
        error = odometry.pose.inverse() @ last
        turns = max(abs(turned[0]) / (2.0 * math.pi), 1.0)
        return math.hypot(error.x, error.y) / max(distance, 0.1), abs(error.yaw) / turns
    finally:
        walk.close()


def _smoothed(record: Record) -> Array:
    """Positions once in a second: the path without the body's sway."""
    return record.positions[::50]
