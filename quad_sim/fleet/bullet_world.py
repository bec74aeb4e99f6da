"""
Several robots in PyBullet's physics: many bodies in one client.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.bullet_body import SOLVER_ITERATIONS
from quad_sim.engines.bullet_ground import lay_ground
from quad_sim.engines.bullet_obstacles import BulletObstacles, build_walls
from quad_sim.engines.bullet_robot import BulletRobot
from quad_sim.engines.bullet_simulator import open_client
from quad_sim.engines.simulator import GROUND, OBSTACLE, Simulator, robot_contact
from quad_sim.fleet.world_handle import WorldHandle
from quad_sim.world.world import OF_WORLD, Obstacle, World

Array = NDArray[np.float64]


class _Handle(BulletRobot, WorldHandle):
    """A robot whose commands wait for the world's step."""

    def __init__(self, shared: BulletWorld, robot: Robot) -> None:
        BulletRobot.__init__(
            self, shared.client, robot, shared.world, shared.time_step, shared.name_of
        )
        WorldHandle.__init__(self, shared)

    def close(self) -> None:
        """Do nothing: the world is released as a whole."""


class BulletWorld:
    """
    A world of Bullet with any number of robots; see :class:`~.shared_world.SharedWorld`.

    Parameters
    ----------
    world : World
        Ground and obstacles.
    time_step : float
        Fixed step [s].
    """

    def __init__(self, world: World, time_step: float) -> None:
        self.time_step = time_step
        self.world = world
        """Ground and obstacles at first."""
        self.client = open_client(time_step)
        """The world in Bullet."""
        self._steps = 0
        self._grounds = lay_ground(self.client, world)
        build_walls(self.client, world)
        self._obstacles = BulletObstacles(self.client, world)
        for index, obstacle in enumerate(world.obstacles):
            self._obstacles.put((OF_WORLD, index), obstacle)
        self._robots: dict[str, _Handle] = {}
        self._names: dict[int, str] = {}

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""
        return self._steps * self.time_step

    def spawn(self, robots: Mapping[str, tuple[Robot, Pose2D]]) -> dict[str, Simulator]:
        """Put robots into the world; see :meth:`SharedWorld.spawn`."""
        made: dict[str, Simulator] = {}
        for name, (robot, pose) in robots.items():
            handle = self._robots[name] = _Handle(self, robot)
            self._names[handle.number] = robot_contact(name)
            handle.reset(pose)
            made[name] = handle
        self._set_iterations()
        return made

    def remove(self, name: str) -> None:
        """Take a robot out of the world; the others go on."""
        number = self._robots.pop(name).number
        del self._names[number]
        self.client.removeBody(number)
        self._set_iterations()

    def step(self) -> None:
        """Advance by one time step."""
        self.client.stepSimulation()
        self._steps += 1

    def name_of(self, body: int) -> str:
        """Return what a body of Bullet is, for :attr:`Contact.other`."""
        if body in self._grounds:
            return GROUND
        return self._names.get(body, OBSTACLE)

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""
        return self._obstacles.standing

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""
        self._obstacles.put(name, obstacle)

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        self._obstacles.remove(name)

    def close(self) -> None:
        """Disconnect from the physics server."""
        if self.client.isConnected():
            self.client.disconnect()

    def _set_iterations(self) -> None:
        """Let the solver do as many iterations as the robot needs that needs most."""
        needed = max([robot.iterations for robot in self._robots.values()], default=0)
        self.client.setPhysicsEngineParameter(numSolverIterations=max(needed, SOLVER_ITERATIONS))
