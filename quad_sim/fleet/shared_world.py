"""
What every world with several robots offers: robots that come and go, and one step for all.
"""

from __future__ import annotations

import importlib
from collections.abc import Hashable, Mapping
from typing import Any, Protocol

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.registry import resolved
from quad_sim.engines.simulator import Simulator
from quad_sim.world.world import Obstacle, World, world_from_map


class SharedWorld(Protocol):
    """
    One world with any number of robots.

    Each robot has a handle, which is a :class:`~quad_sim.engines.simulator.Simulator`: its ``step``
    notes what the robot is commanded in the next step, which the world makes for all at once.
    """

    time_step: float
    """Fixed step [s]."""

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""

    def spawn(self, robots: Mapping[str, tuple[Robot, Pose2D]]) -> dict[str, Simulator]:
        """
        Put robots into the world.

        Parameters
        ----------
        robots : mapping of str to tuple of Robot and Pose2D
            Each robot, and where it stands, by names that no robot of the world has.

        Returns
        -------
        dict of str to Simulator
            Their handles.
        """

    def remove(self, name: str) -> None:
        """Take a robot out of the world; the others go on."""

    def step(self) -> None:
        """Advance by one time step, with every robot as its handle was commanded last."""

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle, in the place of the one of that name if there is one."""

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""

    def close(self) -> None:
        """Release what the world holds."""


_WORLDS = {
    'bullet': ('quad_sim.fleet.bullet_world', 'BulletWorld'),
    'mujoco': ('quad_sim.fleet.mujoco_world', 'MujocoWorld'),
    'kinematic': ('quad_sim.fleet.kinematic_world', 'KinematicWorld'),
}
"""Module and class of each backend's world; imported when it is chosen."""


def make_shared_world(
    backend: str, world: World | None = None, time_step: float = 0.005
) -> SharedWorld:
    """
    Make a world without robots.

    Parameters
    ----------
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    world : World, optional
        Ground and obstacles; an empty floor if not given. The kinematic backend has an empty floor
        in any case, and robots that pass through one another.
    time_step : float
        Fixed step [s].

    Returns
    -------
    SharedWorld

    Raises
    ------
    ParameterError
        If there is no such backend.
    MissingOptionalDependency
        If the backend's package is not installed.
    """
    module, name = _WORLDS[resolved(backend)]
    make: Any = getattr(importlib.import_module(module), name)
    return make(world_from_map(None) if world is None else world, time_step)  # type: ignore[no-any-return]
