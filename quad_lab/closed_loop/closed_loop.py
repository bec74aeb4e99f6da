"""
The closed loop in one process, without topics: simulator, sensors and controller.

The controller is told what it would receive on topics, at the same rate. Every walk without topics
is one of these: what the robot takes its place to be, what happens to messages and who makes the
plans is put in.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import InvalidMessage, QuadError
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.state.robot_state import RobotState
from quad_gait.state.sensor_inputs import JointReadings
from quad_gait.state.state_estimator import StateEstimator
from quad_gait.supervisor import Supervisor
from quad_lab.closed_loop.loop_record import Record
from quad_sim.engines.registry import AUTO, make_simulator
from quad_sim.engines.simulator import Observation
from quad_sim.simulation import Simulation
from quad_sim.world.appearance import Appearance
from quad_sim.world.world import World

Array = NDArray[np.float64]

SENSOR_PERIOD = 0.02
"""Time between two measurements, as sim_node publishes them [s]."""

_ORIGIN = Pose2D(0.0, 0.0, 0.0)

_PATIENCE = 10.0
"""Time without a new cycle after which a robot does not walk [s]."""


@dataclass(eq=False, repr=False)
class DoesNotWalk(QuadError):
    """A robot that was to walk stands still."""

    reason: str
    """Reason, as a clause."""

    def sentence(self) -> str:
        """Say why it stands still."""
        return f'the robot does not walk: {self.reason}'


Place = tuple[Pose2D, Pose2D]
"""Pose of base_link in the map, and by odometry."""


class ClosedLoop:
    """
    A robot under a controller in a simulator.

    What a subclass may change is what becomes of messages: `_readings` and `_send`.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : Supervisor
        What moves it.
    backend : str
        One of :data:`quad_sim.engines.registry.BACKENDS`.
    world : World, optional
        A level floor if not given.
    start : Pose2D
        Of the robot.
    appearance : Appearance, optional
        Of the world in pictures.
    """

    def __init__(
        self,
        robot: Robot,
        controller: Supervisor,
        backend: str = AUTO,
        world: World | None = None,
        start: Pose2D = _ORIGIN,
        appearance: Appearance | None = None,
    ) -> None:
        simulator = make_simulator(backend, robot, world, appearance=appearance)
        self._begin(controller, Simulation(simulator, robot, start))

    @classmethod
    def around(cls, controller: Supervisor, simulation: Simulation) -> ClosedLoop:
        """Close the loop around a simulation that there is, which somebody else may step."""
        loop = cls.__new__(cls)
        loop._begin(controller, simulation)
        return loop

    def _begin(self, controller: Supervisor, simulation: Simulation) -> None:
        self.robot = robot = simulation.robot
        self.controller = controller
        self.record = Record(robot)
        self._estimator = StateEstimator(robot)
        self._simulation = simulation
        self._steps = round(SENSOR_PERIOD / self._simulation.time_step)
        self._since_measured = 0
        self.on_observation: list[Callable[[Observation], None]] = []
        """Called with each observation, before the controller is told of it."""
        self.locate: Callable[[Observation], Place | None] = true_place
        """Returns where the robot takes itself to be; None while it does not know."""

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._simulation.time

    @property
    def simulation(self) -> Simulation:
        """The simulation, to look at."""
        return self._simulation

    @property
    def feet(self) -> Array:
        """Centers of the feet in the world when they were last measured, shape (4, 3) [m]."""
        feet = self.record.last_feet
        return np.full((4, 3), np.nan) if feet is None else feet

    def run(self, duration: float, until: Callable[[], bool] | None = None) -> bool:
        """
        Go on for a time.

        Parameters
        ----------
        duration : float
            At most so long [s].
        until : callable, optional
            End when it is true; asked after each measurement.

        Returns
        -------
        bool
            Whether ``until`` came true.
        """
        end = self.time + duration
        while self.time < end - self._simulation.time_step / 2.0:
            self._step()
            if self._since_measured == 0 and until is not None and until():
                return True
        return False

    def _step(self) -> None:
        """Measure if it is time to, and advance by one step of physics."""
        if self._since_measured == 0:
            self.measure()
        self._simulation.step()
        self._since_measured = (self._since_measured + 1) % self._steps

    def next_cycle_end(self) -> Pose2D:
        """
        Go on to the end of the cycle that runs, or of the next, and return the pose then.

        Raises
        ------
        DoesNotWalk
            If no cycle begins for a long time, or the robot is disabled.
        """
        patience = self.time + _PATIENCE
        # A cycle that is over within the next step of physics counts as over.
        soon = self._simulation.time_step
        current = self.controller.cycle_at(self.time + soon)
        while current is None:
            if self.time > patience or self.controller.activity.is_disabled:
                raise DoesNotWalk(self.controller.reason)
            self.run(SENSOR_PERIOD)
            current = self.controller.cycle_at(self.time + soon)
        end = current.end
        self.run(end - self.time - SENSOR_PERIOD)
        while self.time < end - self._simulation.time_step / 2.0:
            # Measurements come at their own pace; the cycle ends at any step between.
            self._step()
        return self._simulation.observe().pose

    def measure(self) -> None:
        """Observe once, and let the controller decide."""
        seen = self._simulation.observe()
        for callback in self.on_observation:
            callback(seen)
        self.decide(seen)
        self.record.note(seen, self.controller.in_contact_at(seen.time))

    def decide(self, seen: Observation) -> None:
        """Tell the controller of an observation, and send what it decides."""
        state = self._state(seen)
        trajectory = None if state is None else self.controller.update(state)
        if trajectory is not None:
            self._send(trajectory)

    def _state(self, seen: Observation) -> RobotState | None:
        """Return what the controller is told, checked as the node does; None for nothing."""
        place = self.locate(seen)
        try:
            self._estimator.take_joints(self._readings(seen))
            if place is None:
                return None
            pose, odometry = place
            state = self._estimator.take_odometry(seen.time, odometry, seen.orientation)
        except InvalidMessage:
            # The robot was put somewhere else; for a moment it is not believed.
            return None
        return state if state is None or pose is odometry else state.placed(pose, odometry)

    def _readings(self, seen: Observation) -> JointReadings:
        """Return what the joints say."""
        return JointReadings(
            seen.joint_positions, seen.joint_velocities, seen.joint_efforts, seen.time
        )

    def _send(self, trajectory: JointTrajectory) -> None:
        """Hand a trajectory to the robot."""
        self._simulation.accept(trajectory)

    def close(self) -> None:
        """Release the simulator."""
        self._simulation.close()


def true_place(seen: Observation) -> Place:
    """Return where the robot really is, as odometry without an error has it."""
    pose = seen.pose
    return pose, pose
