"""
A walk without topics on a machine that is busy: trajectories come late or never, joints are old.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from typing import Any

import numpy as np

from quad_common.errors import TrajectoryError
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.state.sensor_inputs import JointReadings
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_sim.engines.simulator import Observation


@dataclass(frozen=True)
class Disturbance:
    """What a busy machine does to messages, each chance for one message by itself."""

    late: float = 0.25
    """Chance that a trajectory comes late."""
    lateness: float = 2.0
    """Largest lateness of a trajectory, simulated [s]."""
    lost: float = 0.03
    """Chance that a trajectory never comes."""
    stale: float = 0.02
    """Chance that from a measurement on the joints are not received for a while."""
    staleness: float = 0.3
    """Longest time for which they are not [s]."""
    jitter: float = 0.03
    """Largest lateness of any other trajectory [s]."""


UNDISTURBED = Disturbance(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
"""A machine with nothing else to do."""


class DisturbedWalk(ClosedLoop):
    """
    A robot under a controller in a simulator, with messages that a busy machine delays.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : Supervisor
        What moves it.
    disturbance : Disturbance
        What happens to messages.
    rng : numpy.random.Generator
        When it happens.
    **others
        As :class:`~quad_lab.closed_loop.closed_loop.ClosedLoop` takes them.
    """

    def __init__(
        self,
        robot: Robot,
        controller: Supervisor,
        disturbance: Disturbance,
        rng: np.random.Generator,
        **others: Any,
    ) -> None:
        super().__init__(robot, controller, **others)
        self._disturbance = disturbance
        self._rng = rng
        self._in_transit: deque[tuple[float, JointTrajectory]] = deque()
        self._received: Observation | None = None
        self._deaf_until = 0.0
        self.late = 0
        """Number of trajectories that came late."""
        self.lost = 0
        """Number of trajectories that never came, or so late that they had ended."""

    def _step(self) -> None:
        while self._in_transit and self._in_transit[0][0] <= self.time:
            try:
                self.simulation.accept(self._in_transit.popleft()[1])
            except TrajectoryError:
                self.lost += 1
        super()._step()

    def _send(self, trajectory: JointTrajectory) -> None:
        how, rng = self._disturbance, self._rng
        if rng.random() < how.lost:
            self.lost += 1
            return
        lateness = rng.uniform(0.0, how.jitter)
        if rng.random() < how.late:
            lateness = rng.uniform(0.0, how.lateness)
            self.late += 1
        arrival = self.time + lateness
        if self._in_transit:
            # Messages of one topic come in order.
            arrival = max(arrival, self._in_transit[-1][0])
        self._in_transit.append((arrival, trajectory))

    def _readings(self, seen: Observation) -> JointReadings:
        how, rng = self._disturbance, self._rng
        if seen.time >= self._deaf_until:
            self._received = seen
            if rng.random() < how.stale:
                self._deaf_until = seen.time + rng.uniform(0.0, how.staleness)
        return super()._readings(seen if self._received is None else self._received)
