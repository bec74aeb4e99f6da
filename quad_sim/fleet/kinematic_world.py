"""
Several robots without physics: each is moved by its commands alone, and nothing stops it.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import NotSimulated
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.engines.registry import engines_with
from quad_sim.engines.simulator import Simulator
from quad_sim.world.world import Obstacle, World

Array = NDArray[np.float64]


class _Handle(KinematicSimulator):
    """A robot whose commands wait for the world's step."""

    def __init__(self, robot: Robot, time_step: float, begun: int) -> None:
        super().__init__(robot, time_step)
        self._steps = begun
        self._commanded = (self._joints, self._joint_velocities)

    def reset(self, pose: Pose2D) -> None:
        super().reset(pose)
        self._commanded = (self._joints, self._joint_velocities)

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        self._commanded = (joint_positions, joint_velocities)

    def advance(self) -> None:
        """Follow the last command."""
        super().step(*self._commanded)


class KinematicWorld:
    """
    A flat, empty floor for any number of robots.

    Parameters
    ----------
    world : World
        Not used: there is nothing to touch.
    time_step : float
        Fixed step [s].
    """

    def __init__(self, world: World, time_step: float) -> None:
        self.time_step = time_step
        self._steps = 0
        self._robots: dict[str, _Handle] = {}

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""
        return self._steps * self.time_step

    def spawn(self, robots: Mapping[str, tuple[Robot, Pose2D]]) -> dict[str, Simulator]:
        """Put robots into the world; see :meth:`SharedWorld.spawn`."""
        made: dict[str, Simulator] = {}
        for name, (robot, pose) in robots.items():
            made[name] = self._robots[name] = _Handle(robot, self.time_step, self._steps)
            made[name].reset(pose)
        return made

    def remove(self, name: str) -> None:
        """Take a robot out of the world."""
        del self._robots[name]

    def step(self) -> None:
        """Advance by one time step."""
        for robot in self._robots.values():
            robot.advance()
        self._steps += 1

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Obstacles in the world: none."""
        return {}

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Raise NotSimulated: there is nothing to touch."""
        raise NotSimulated('an obstacle', engines_with('has_world'))

    def remove_obstacle(self, name: Hashable) -> None:
        """Do nothing: there are none."""

    def close(self) -> None:
        """Nothing to release."""
