"""
A robot of a simulation with its sensors: what they measure, and when.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_sim.engines.simulator import JointFailure, Observation
from quad_sim.pacing import Answers
from quad_sim.parameters import SimParameters
from quad_sim.simulated_localisation import LocalisationOptions, SimulatedLocalisation
from quad_sim.simulation import Simulation

Array = NDArray[np.float64]

_APART = 1_000_003
"""Difference between the seeds of two robots of one world."""


@dataclass(frozen=True)
class SensorReadings:
    """What is measured at one instant, and the noise to measure it with."""

    truth: Observation
    """State of the robot."""
    odometry: Observation
    """State of the robot as drifting odometry has it."""
    correction: Pose2D | None
    """Odometry's frame in the map by the localiser, if it is due [m, m, rad]."""
    odometry_noise: Array
    """Standard normal numbers for x, y, z and the heading, shape (4,)."""
    imu_noise: Array
    """Standard normal numbers for angular velocity and acceleration, shape (2, 3)."""


class SimulatedRobot:
    """
    What is measured of a robot.

    Parameters
    ----------
    simulation : Simulation
        The robot under its controller.
    parameters : SimParameters
        Of the node.
    name : str
        Name of the robot among several, which its frames begin with; empty for one alone.
    number : int
        Number of the robot among several, for noise of its own.
    """

    def __init__(
        self, simulation: Simulation, parameters: SimParameters, name: str = '', number: int = 0
    ) -> None:
        self.simulation = simulation
        """The robot under its controller."""
        self.name = name
        """Name among several robots; empty for one alone."""
        self.parameters = p = _with_frames_of(name, parameters)
        """Parameters of the node, with the robot's own frames."""
        # The first robot's noise is that of one alone.
        seed = p.seed + _APART * number
        self.answers = Answers()
        """How far its gait has answered."""
        self._localisation = SimulatedLocalisation(
            LocalisationOptions(
                p.odom_drift, p.localiser_rate, p.localiser_noise, p.localiser_heading_noise, seed
            )
        )
        self._rng = np.random.default_rng(seed)

    @property
    def robot(self) -> Robot:
        """Robot that is simulated."""
        return self.simulation.robot

    @property
    def has_exact_odometry(self) -> bool:
        """Whether odometry's frame coincides with the world for good."""
        return self._localisation.is_exact

    def observe(self) -> SensorReadings:
        """Measure."""
        truth = self.simulation.observe()
        told = self._localisation.observe(truth)
        # Noise is drawn in any case: who subscribes must not change the run.
        noise = self._rng.standard_normal(4), self._rng.standard_normal((2, 3))
        correction = self._localisation.correction(truth, told)
        return SensorReadings(truth, told, correction, *noise)

    def reset(self) -> None:
        """Put the robot back to its start pose; time goes on."""
        self.simulation.reset()
        self._localisation.reset()

    def plan_failure(self, parameters: SimParameters) -> None:
        """Let a joint fail as parameters say; see :meth:`Simulation.plan_failure`."""
        p = parameters
        failure = JointFailure(p.failing_joint, p.failure, p.failure_time)
        self.simulation.plan_failure(failure if p.failing_joint else None)

    def troubles(self) -> int:
        """Count the kinds of trouble that have been seen."""
        simulation = self.simulation
        seen = (simulation.contacts_seen, simulation.has_fallen, simulation.failed)
        return sum(map(bool, seen))


def _with_frames_of(name: str, parameters: SimParameters) -> SimParameters:
    """Prefix the frames that belong to one robot, as robot_state_publisher's frame_prefix does."""
    prefix = parameters.frame_prefix + (f'{name}/' if name else '')
    if not prefix:
        return parameters
    names = ('odom_frame', 'base_frame', 'footprint_frame')
    return replace(parameters, **{key: prefix + getattr(parameters, key) for key in names})
