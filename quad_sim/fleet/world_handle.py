"""
What the handle of a robot in a world with others passes on to that world.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Mapping

import numpy as np
from numpy.typing import NDArray

from quad_sim.engines.simulator import Observation
from quad_sim.fleet.shared_world import SharedWorld
from quad_sim.world.world import Obstacle

Array = NDArray[np.float64]


class WorldHandle(ABC):
    """
    A robot whose commands wait for the world's step; an engine's robot is the other base.

    Parameters
    ----------
    shared : SharedWorld
        The world.
    """

    def __init__(self, shared: SharedWorld) -> None:
        self._shared = shared

    @abstractmethod
    def _drive(self, joint_positions: Array, joint_velocities: Array) -> None:
        """Command the joints."""

    @abstractmethod
    def _observe(self, time: float) -> Observation:
        """Return the robot's state at a time [s]."""

    @property
    def time(self) -> float:
        """Simulated time since the world was made [s]."""
        return self._shared.time

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        """Have the robot commanded so in the next step of the world."""
        self._drive(joint_positions, joint_velocities)

    def observe(self) -> Observation:
        """Return the robot's state."""
        return self._observe(self.time)

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Those that stand in the world now, besides the walls."""
        return self._shared.obstacles

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """Put an obstacle into the world."""
        self._shared.put_obstacle(name, obstacle)

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle out of the world."""
        self._shared.remove_obstacle(name)
