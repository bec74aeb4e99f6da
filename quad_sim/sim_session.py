"""
A simulation as ``sim_node`` runs it: its pace, what its sensors measure and when, its status.

The session knows no topics. Its node tells it to go on, and publishes what comes of it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.status import Level, Status
from quad_sim.engines.registry import make_simulator
from quad_sim.engines.simulator import JointFailure, Observation
from quad_sim.pacing import Answers, Pacing
from quad_sim.parameters import SimParameters
from quad_sim.scenery import appearance_from, camera_from, scenery_from
from quad_sim.simulated_localisation import LocalisationOptions, SimulatedLocalisation
from quad_sim.simulation import Simulation
from quad_sim.world.simulated_camera import Picture

Array = NDArray[np.float64]

_CLOCK_RATE = 100.0
"""Least rate of the published clock, in simulated time [Hz]."""

_LONGEST_WAIT = 0.1
"""Longest time for which a node is told to wait [s]."""


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


class Output(Protocol):
    """What becomes of a session's measurements."""

    def publish_clock(self, time: float) -> None:
        """Publish simulated time [s]."""

    def publish_picture(self, time: float, take: Callable[[], Picture]) -> None:
        """Publish what the camera sees at a time [s]; without a subscriber none is taken."""

    def publish_readings(self, readings: SensorReadings) -> None:
        """Publish what was measured."""


class SimSession:
    """
    Steps the simulation that parameters describe.

    Parameters
    ----------
    parameters : SimParameters
        Of the node.
    robot : Robot
        The robot.
    clock : callable
        Returns the wall clock's time [s].
    """

    def __init__(self, parameters: SimParameters, robot: Robot, clock: Callable[[], float]) -> None:
        p = parameters
        self._parameters = p
        self._clock = clock
        self.robot = robot
        """The robot."""
        self.scenery = scenery_from(p, robot)
        """World, maps, start and goal."""
        look = appearance_from(p, robot)
        self.camera = camera_from(p) if p.camera else None
        """The camera under the ceiling, if there is one."""
        world = self.scenery.world
        simulator = make_simulator(p.backend, robot, world, p.time_step, p.gui, look)
        self.simulation = Simulation(simulator, robot, self.scenery.start)
        """What is stepped."""
        self.plan_failure(p)
        if self.scenery.goal is not None:
            self.simulation.put_goal_marker(self.scenery.goal)
        if self.camera is not None:
            # Where nothing can draw, it is said at the start.
            self.simulation.check_visible('a camera').prepare_pictures()
        self._localisation = SimulatedLocalisation(
            LocalisationOptions(
                p.odom_drift, p.localiser_rate, p.localiser_noise, p.localiser_heading_noise, p.seed
            )
        )
        self._rng = np.random.default_rng(p.seed)
        self._pacing = Pacing(p.real_time_factor, clock())
        self._answers = Answers()
        self._is_paused = False
        self._steps = 0
        self._steps_per_clock = max(1, int(1.0 / (_CLOCK_RATE * p.time_step) + 1e-9))
        self._steps_per_observation = max(1, round(1.0 / (p.sensor_rate * p.time_step)))
        self._steps_per_picture = max(1, round(1.0 / (p.camera_rate * p.time_step)))
        self._spent = {'physics': 0.0, 'publishing': 0.0, 'pictures': 0.0}
        self._troubles_reported = 0

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.simulation.time

    @property
    def has_exact_odometry(self) -> bool:
        """Whether odometry's frame coincides with the world for good."""
        return self._localisation.is_exact

    @property
    def frames_on_map(self) -> tuple[str, ...]:
        """Frames that coincide with the world."""
        p = self._parameters
        return (p.map_frame, p.odom_frame) if self.has_exact_odometry else (p.map_frame,)

    @property
    def has_news(self) -> bool:
        """Whether there is trouble of a kind that no :meth:`status` has told of."""
        return self._troubles() > self._troubles_reported

    def plan_failure(self, parameters: SimParameters) -> None:
        """Let a joint fail as parameters say; see :meth:`Simulation.plan_failure`."""
        p = parameters
        failure = JointFailure(p.failing_joint, p.failure, p.failure_time)
        self.simulation.plan_failure(failure if p.failing_joint else None)

    def wait(self) -> float:
        """Return how long there is nothing to do [s]; 0 if the next observation is due."""
        if self._is_paused:
            return _LONGEST_WAIT
        wall = self._clock()
        wait = max(self._pacing.ahead(self.time, wall), self._answers.wait(self.time, wall))
        return min(max(wait, 0.0), _LONGEST_WAIT)

    def take_answer(self, stamp: float) -> None:
        """Take it that the gait has answered what was measured up to a time [s]."""
        self._answers.take(stamp, self.time, self._clock())

    def advance(self, output: Output) -> None:
        """Simulate up to the next observation, and publish what is measured meanwhile."""
        for _ in range(self._steps_per_observation):
            began = self._clock()
            self.simulation.step()
            self._steps += 1
            self._spent['physics'] += self._clock() - began
            if self._steps % self._steps_per_clock == 0:
                output.publish_clock(self.time)
            if self.camera is not None and self._steps % self._steps_per_picture == 0:
                began = self._clock()
                output.publish_picture(self.time, self._take_picture)
                self._spent['pictures'] += self._clock() - began
        began = self._clock()
        self.observe(output)
        self._spent['publishing'] += self._clock() - began

    def observe(self, output: Output) -> None:
        """Measure, and publish it."""
        truth = self.simulation.observe()
        told = self._localisation.observe(truth)
        # Noise is drawn in any case: who subscribes must not change the run.
        noise = self._rng.standard_normal(4), self._rng.standard_normal((2, 3))
        correction = self._localisation.correction(truth, told)
        output.publish_readings(SensorReadings(truth, told, correction, *noise))

    def reset(self) -> None:
        """Put the robot back to its start pose; time goes on."""
        self.simulation.reset()
        self._localisation.reset()

    def pause(self) -> None:
        """Let simulated time stand still."""
        self._is_paused = True

    def unpause(self) -> None:
        """Go on, at the pace from now on."""
        self._is_paused = False
        self._pacing.restart(self.time, self._clock())

    def status(self) -> Status:
        """Return how the simulation goes."""
        simulation = self.simulation
        self._troubles_reported = self._troubles()
        contacts = ', '.join(sorted(map(str, simulation.contacts_seen)))
        values = {
            'time': f'{simulation.time:.2f}',
            'real_time_factor': f'{self._pacing.measured_factor(self.time, self._clock()):.2f}',
            'contacts': contacts,
            'has_fallen': simulation.has_fallen,
            'late_trajectories': simulation.late_trajectories,
            'seconds_in_physics': f'{self._spent["physics"]:.3f}',
            'seconds_publishing': f'{self._spent["publishing"]:.3f}',
            'seconds_in_pictures': f'{self._spent["pictures"]:.3f}',
        }
        failed = simulation.failed
        if simulation.has_fallen:
            return Status(Level.ERROR, 'the robot has fallen; reset stands it up again', values)
        if failed is not None:
            return Status(Level.WARN, f'{failed.joint} is {failed.kind}; reset repairs it', values)
        if contacts:
            return Status(Level.WARN, f'contact: {contacts}', values)
        if simulation.is_frozen:
            return Status(Level.WARN, 'the emergency stop is on: no trajectory is executed', values)
        return Status(Level.OK, 'paused' if self._is_paused else 'running', values)

    def close(self) -> None:
        """Release the simulator."""
        self.simulation.close()

    def _troubles(self) -> int:
        """Count the kinds of trouble that have been seen."""
        simulation = self.simulation
        seen = (simulation.contacts_seen, simulation.has_fallen, simulation.failed)
        return sum(map(bool, seen))

    def _take_picture(self) -> Picture:
        assert self.camera is not None
        # Each picture has noise of its own: who looked at the others must not change it.
        rng = np.random.default_rng((self._parameters.seed, self._steps))
        return self.simulation.picture(self.camera, rng)
