"""
A walk without topics whose gait is not given the processor at random moments.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from quad_common.errors import TrajectoryError
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_sim.engines.simulator import Observation

_DEPTH = 5
"""Readings that wait for the gait, as in the middleware; older ones are lost."""


@dataclass(frozen=True)
class Pauses:
    """When the gait stands still."""

    often: float = 0.02
    """Probability that a pause begins with a reading."""
    longest: float = 1.0
    """Longest pause, simulated [s]."""


class PausedWalk(ClosedLoop):
    """
    A robot under a controller that pauses; the robot goes on with what it was given last.

    After a pause the controller is told what has waited, one reading after the other.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : Supervisor
        What moves it.
    pauses : Pauses
        How often, and for how long, the controller pauses.
    rng : numpy.random.Generator
        When it does.
    **others
        As :class:`~quad_lab.closed_loop.closed_loop.ClosedLoop` takes them.
    """

    def __init__(
        self,
        robot: Robot,
        controller: Supervisor,
        pauses: Pauses,
        rng: np.random.Generator,
        **others: Any,
    ) -> None:
        super().__init__(robot, controller, **others)
        self._pauses = pauses
        self._rng = rng
        self._until = 0.0
        self._waiting: deque[Observation] = deque(maxlen=_DEPTH)
        self.count = 0
        """Number of pauses."""

    def measure(self) -> None:
        """Observe once; let the controller decide, if it is given the processor."""
        seen = self.simulation.observe()
        self._waiting.append(seen)
        if self.time < self._until:
            pass
        elif self._rng.random() < self._pauses.often:
            self._until = self.time + self._rng.uniform(0.0, self._pauses.longest)
            self.count += 1
        else:
            while self._waiting:
                self.decide(self._waiting.popleft())
        self.record.note(seen, self.controller.in_contact_at(seen.time))

    def _send(self, trajectory: JointTrajectory) -> None:
        # After a pause one may be over before it comes: the robot goes on without.
        try:
            super()._send(trajectory)
        except TrajectoryError:
            return
