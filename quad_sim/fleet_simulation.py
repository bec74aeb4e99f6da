"""
Robots under their trajectory controllers in one world.
"""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Mapping, Sequence
from types import MappingProxyType

from quad_common.errors import RobotNameTaken, RobotNotFound, TooManyRobots
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.fleet.shared_world import SharedWorld
from quad_sim.fleet_text import check_apart
from quad_sim.simulation import Simulation, check_start
from quad_sim.world.obstacle_changes import ObstacleChange, change_obstacles
from quad_sim.world.world import Obstacle

MOST_ROBOTS = 32
"""Number of robots that may be in one world."""


class FleetSimulation:
    """
    Steps a world with the commands of every robot's current trajectory.

    Parameters
    ----------
    world : SharedWorld
        World without robots.
    grid : OccupancyGrid, optional
        Map of the world, in whose obstacles no robot may begin.
    """

    def __init__(self, world: SharedWorld, grid: OccupancyGrid | None = None) -> None:
        self._world = world
        self._grid = grid
        self._robots: dict[str, Simulation] = {}

    @property
    def robots(self) -> Mapping[str, Simulation]:
        """Simulation of each robot by its name."""
        return MappingProxyType(self._robots)

    @property
    def standing(self) -> dict[str, tuple[Robot, Pose2D]]:
        """Each robot and where it is, by its name."""
        return {
            name: (simulation.robot, simulation.observe().pose)
            for name, simulation in self._robots.items()
        }

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._world.time

    @property
    def time_step(self) -> float:
        """Fixed step [s]."""
        return self._world.time_step

    def spawn(
        self, robots: Mapping[str, tuple[Robot, Pose2D]], instead_of: Sequence[str] = ()
    ) -> None:
        """
        Put robots into the world, all or, if there is an error, none.

        Parameters
        ----------
        robots : mapping of str to tuple of Robot and Pose2D
            Each robot and its start, by its name.
        instead_of : sequence of str
            Robots that are removed, if there is no error.

        Raises
        ------
        RobotNameTaken
            If there is a robot of a name already.
        TooManyRobots
            If there would be more than :data:`MOST_ROBOTS`.
        PlaceTaken
            If two would stand too near to each other.
        ParameterError
            If one would stand in an obstacle of the map.
        """
        standing = {n: one for n, one in self.standing.items() if n not in instead_of}
        if len(standing) + len(robots) > MOST_ROBOTS:
            raise TooManyRobots(MOST_ROBOTS)
        for name, (robot, pose) in robots.items():
            if name in standing:
                raise RobotNameTaken(name)
            if self._grid is not None:
                check_start(robot, self._grid, pose)
            check_apart(name, robot, pose, standing)
            standing[name] = robot, pose
        for name in instead_of:
            self.remove(name)
        for name, handle in self._world.spawn(robots).items():
            self._robots[name] = Simulation(handle, *robots[name])

    def remove(self, name: str) -> None:
        """Take a robot out of the world; RobotNotFound if it is not there."""
        if name not in self._robots:
            raise RobotNotFound(name, self._robots)
        del self._robots[name]
        self._world.remove(name)

    def step(self) -> None:
        """Advance by one time step."""
        for simulation in self._robots.values():
            simulation.step()
        self._world.step()

    def change_obstacles(self, changes: Iterable[ObstacleChange], most: int | None = None) -> None:
        """Put and remove obstacles; see :meth:`Simulation.change_obstacles`."""
        changes = list(changes)
        for simulation in self._robots.values():
            simulation.check_clear(changes)
        for simulation in self._robots.values():
            # The world is one: any robot's simulation changes it for all.
            simulation.change_obstacles(changes, most)
            return
        change_obstacles(self._world, changes, most)

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Obstacles that stand, by name."""
        return self._world.obstacles

    def close(self) -> None:
        """Release the world."""
        self._world.close()
