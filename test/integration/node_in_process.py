"""A gait node and a simulation in one process: messages are handed on, not sent."""

from __future__ import annotations

import numpy as np
from geometry_msgs.msg import Twist

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_common.ros.pose_conversions import time_from_seconds
from quad_gait.gait_node import GaitNode
from quad_sim.engines.registry import make_simulator
from quad_sim.parameters import SimParameters
from quad_sim.ros_conversions import (
    imu_message,
    joint_state_message,
    odometry_message,
    trajectory_from_message,
)
from quad_sim.simulation import Simulation

ROBOT = load_robot('titan_viii')
PERIOD = 0.02


class NodeInProcess:
    """What the node is told, and what becomes of its trajectories."""

    def __init__(self, node: GaitNode, backend: str = 'kinematic') -> None:
        self.node = node
        self.simulation = Simulation(
            make_simulator(backend, ROBOT, None), ROBOT, Pose2D(0.0, 0.0, 0.0)
        )
        self.has_imu = True
        self.said: list[tuple[bytes, str]] = []
        self.callbacks = {s.topic_name.lstrip('/'): s.callback for s in node.subscriptions}
        self._rng = np.random.default_rng(0)
        node._topics._trajectories.publish = lambda message: self.simulation.accept(
            trajectory_from_message(message)
        )
        node.report = lambda level, message, **_: self.said.append((level, message))

    def tell(self, topic: str, message: object) -> None:
        self.callbacks[topic](message)

    def run(self, seconds: float, twist: Twist | None = None) -> None:
        """Go on for a time, steered or not; in the end the node says what it does."""
        parameters = SimParameters()
        end = self.simulation.time + seconds
        while self.simulation.time < end:
            seen = self.simulation.observe()
            stamp = time_from_seconds(seen.time)
            if twist is not None:
                self.tell('cmd_vel', twist)
            if self.has_imu:
                noise = self._rng.standard_normal((2, 3))
                self.tell('imu', imu_message(seen, parameters, noise, stamp))
            self.tell('joint_states', joint_state_message(seen, ROBOT.joint_names, stamp))
            odometry = odometry_message(seen, parameters, np.zeros(4), stamp)
            self.tell('odom', odometry)
            for _ in range(round(PERIOD / self.simulation.time_step)):
                self.simulation.step()
        self.node.update_status()

    @property
    def yaw(self) -> float:
        return self.simulation.observe().pose.yaw
