"""
Walks a robot in one process, without topics: controller and simulator hand in hand.

For measuring gaits. The controller hears what it would hear on topics, at the same rate.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import InvalidMessage, QuadError
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.behaviours.walk_controller import WalkController
from quad_gait.cycle.stability import stability_margin
from quad_gait.state.measurement import Measurement
from quad_gait.state.sensor_inputs import JointReadings, SensorInputs
from quad_sim.engines.simulator import Observation, tilt_of
from quad_sim.simulation import Simulation, make_simulator
from quad_sim.world.world import World

Array = NDArray[np.float64]

SENSOR_PERIOD = 0.02
"""Between two measurements, as sim_node publishes them [s]."""

_ORIGIN = Pose2D(0.0, 0.0, 0.0)

_PATIENCE = 10.0
"""A robot that begins no cycle for so long does not walk [s]."""


class DoesNotWalk(QuadError):
    """A robot that was to walk stands still."""

    def __init__(self, reason: str) -> None:
        super().__init__(f'the robot does not walk: {reason}')


@dataclass
class Record:
    """What was seen of a walk, one entry per measurement."""

    times: list[float] = field(default_factory=list)
    """[s]"""
    poses: list[Pose2D] = field(default_factory=list)
    """Of base_link."""
    tilts: list[float] = field(default_factory=list)
    """[rad]"""
    margins: list[float] = field(default_factory=list)
    """Measured static stability margin [m]."""
    slips: list[float] = field(default_factory=list)
    """How far stance feet moved over the ground since the last measurement, summed [m]."""
    torques: list[float] = field(default_factory=list)
    """Root mean square over the joints [N m]."""
    power: list[float] = field(default_factory=list)
    """Mechanical power of all joints, positive parts only [W]."""
    joints: list[Array] = field(default_factory=list)
    """Joint positions, shape (12,) [rad]."""
    has_fallen: bool = False

    @property
    def tilt_rms(self) -> float:
        """Root mean square of the tilt [rad]."""
        return float(np.sqrt(np.mean(np.square(self.tilts)))) if self.tilts else math.nan

    @property
    def heading(self) -> Array:
        """Heading, without jumps at +-pi [rad]."""
        return np.asarray(np.unwrap([pose.yaw for pose in self.poses]), dtype=np.float64)

    @property
    def positions(self) -> Array:
        """Shape (n, 2) [m]."""
        return np.array([(pose.x, pose.y) for pose in self.poses])


class DirectWalk:
    """
    A robot under a controller in a simulator.

    Parameters
    ----------
    robot : Robot
        The robot.
    controller : WalkController
        What moves it.
    backend : str
        ``bullet`` or ``kinematic``.
    world : World, optional
        A level floor if not given.
    start : Pose2D
        Of the robot.
    """

    def __init__(
        self,
        robot: Robot,
        controller: WalkController,
        backend: str = 'bullet',
        world: World | None = None,
        start: Pose2D = _ORIGIN,
    ) -> None:
        self.robot = robot
        self.controller = controller
        self.record = Record()
        self._inputs = SensorInputs(robot)
        self._simulation = Simulation(make_simulator(backend, robot, world), robot, start)
        self._steps = round(SENSOR_PERIOD / self._simulation.time_step)
        self._since_measured = 0
        self._feet: tuple[Array, NDArray[np.bool_]] | None = None
        self.on_observation: list[Callable[[Observation], None]] = []
        """Called with each observation, before the controller hears of it."""

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
        return np.full((4, 3), np.nan) if self._feet is None else self._feet[0]

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
        now = self._measurement(seen)
        trajectory = None if now is None else self.controller.update(now)
        if trajectory is not None:
            self._send(trajectory)
        self._note(seen, tilt_of(seen.orientation))

    def _measurement(self, seen: Observation) -> Measurement | None:
        """Return what the controller is told, checked as the node does; None for nothing."""
        try:
            self._inputs.take_joints(self._readings(seen))
            return self._inputs.take_odometry(seen.time, seen.pose, seen.orientation)
        except InvalidMessage:
            # The robot was put somewhere else; for a moment it is not believed.
            return None

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

    def _note(self, seen: Observation, tilt: float) -> None:
        record = self.record
        joints = seen.joint_positions.reshape(4, 3)
        rotation = _matrix(seen.orientation)
        feet = self.robot.foot_positions(joints) @ rotation.T + seen.position
        center = self.robot.center_of_mass(joints) @ rotation.T + seen.position
        in_contact = self.controller.in_contact_at(seen.time)
        record.times.append(seen.time)
        record.poses.append(seen.pose)
        record.tilts.append(tilt)
        record.margins.append(float(stability_margin(center[:2], feet[:, :2], in_contact)))
        slip = 0.0
        if self._feet is not None:
            before, was_in_contact = self._feet
            standing = in_contact & was_in_contact
            slip = float(np.linalg.norm((feet - before)[standing, :2], axis=1).sum())
        self._feet = (feet, in_contact)
        record.slips.append(slip)
        record.torques.append(float(np.sqrt(np.mean(np.square(seen.joint_efforts)))))
        power = seen.joint_efforts * seen.joint_velocities
        record.power.append(float(np.maximum(power, 0.0).sum()))
        record.joints.append(seen.joint_positions)
        record.has_fallen = record.has_fallen or seen.has_fallen


def _matrix(orientation: Array) -> Array:
    """Rotation matrix of a unit quaternion xyzw."""
    x, y, z, w = orientation
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
