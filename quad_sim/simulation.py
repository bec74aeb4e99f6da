"""
A robot under its trajectory controller in a simulator: what ``sim_node`` steps.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    EmergencyStopped,
    NotSimulated,
    ObstacleOnRobot,
    ParameterError,
    TrajectoryOver,
)
from quad_common.maps.occupancy_grid import OccupancyGrid
from quad_common.planar_pose import Pose2D
from quad_common.quantity import ANGLE, COORDINATE
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_sim.engines.registry import engines_with
from quad_sim.engines.simulator import (
    Ball,
    Contact,
    JointFailure,
    Observation,
    Simulator,
    SolidSimulator,
    ThrowingSimulator,
    VisibleSimulator,
)
from quad_sim.world.obstacle_changes import ObstacleChange, change_obstacles
from quad_sim.world.simulated_camera import Picture, SimulatedCamera
from quad_sim.world.world import Obstacle

Array = NDArray[np.float64]


def start_from(name: str, numbers: Sequence[float]) -> Pose2D:
    """
    Make a start of its numbers.

    Parameters
    ----------
    name : str
        Name of the start, for the error.
    numbers : sequence of float
        x, y and yaw [m, m, rad].

    Raises
    ------
    OutOfRange
        If one is outside the range of places or headings.
    """
    x, y, yaw = numbers
    return Pose2D(
        COORDINATE.check(f'{name}.x', x),
        COORDINATE.check(f'{name}.y', y),
        ANGLE.check(f'{name}.yaw', yaw),
    )


def check_start(robot: Robot, grid: OccupancyGrid, start: Pose2D) -> None:
    """
    Raise ParameterError if the robot would start in an obstacle of the map.

    Parameters
    ----------
    robot : Robot
        The robot.
    grid : OccupancyGrid
        The map.
    start : Pose2D
        Where it is to stand.
    """
    rows, columns = np.nonzero(grid.occupied())
    if rows.size == 0:
        return
    here = grid.world_to_map(np.array([start.x, start.y]))
    # To the nearest point of each cell's square.
    apart = np.maximum(np.abs(np.column_stack([columns, rows]) + 0.5 - here) - 0.5, 0.0)
    nearest = grid.resolution * float(np.min(np.hypot(apart[:, 0], apart[:, 1])))
    if nearest < robot.standing_radius:
        raise ParameterError(
            'start_pose',
            [start.x, start.y, start.yaw],
            f'at least {robot.standing_radius:.2f} m from every obstacle of the map, '
            f'and the nearest is {nearest:.2f} m away',
        )


class Simulation:
    """
    Steps a simulator with the commands of the current trajectory, and keeps the record.

    Parameters
    ----------
    simulator : Simulator
        The robot in its world.
    robot : Robot
        The same robot's data.
    start_pose : Pose2D
        Where it stands at first and after a reset.
    """

    def __init__(self, simulator: Simulator, robot: Robot, start_pose: Pose2D) -> None:
        self._simulator = simulator
        self._robot = robot
        self._standing_radius = robot.standing_radius
        self._initial_joints = robot.initial_joint_angles.reshape(-1)
        self._limits = JointLimits.of(robot)
        self._executor = TrajectoryExecutor(robot.joint_names, self._initial_joints, self._limits)
        self.is_frozen = False
        """Whether the joints hold, and no trajectory is executed."""
        self.start_pose = start_pose
        """Pose to which a reset puts the robot back."""
        self._push_ends = math.inf
        self._failure: JointFailure | None = None
        self.failed: JointFailure | None = None
        """The last joint that has failed since the last reset."""
        self.contacts_seen: set[Contact] = set()
        """Every contact that should not be, since the last reset."""
        self.has_fallen = False
        """Whether the robot has fallen since the last reset."""
        self.late_trajectories = 0
        """Number that came after their first point was due, since the last reset."""
        self.pushes = 0
        """Number of pushes since the last reset."""
        self.reset()

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self._simulator.time

    @property
    def time_step(self) -> float:
        """Fixed step [s]."""
        return self._simulator.time_step

    @property
    def robot(self) -> Robot:
        """Robot that is simulated."""
        return self._robot

    @property
    def commanded(self) -> Array:
        """Where the joints are commanded to be now, shape (12,) [rad]."""
        return self._executor.command(self.time)[0]

    def reset(self) -> None:
        """Put the robot back to its start pose, at rest, with all joints sound; time goes on."""
        self._simulator.reset(self.start_pose)
        self._push_ends = math.inf
        self._failure = self.failed = None
        self._executor.hold(self._initial_joints)
        self.contacts_seen.clear()
        self.has_fallen = False
        self.late_trajectories = 0
        self.pushes = 0

    def accept(self, trajectory: JointTrajectory) -> None:
        """
        Hand a trajectory to the controller; see :meth:`TrajectoryExecutor.accept`.

        Raises
        ------
        CommandOutsideLimits
            If it asks for more than the joints can do.
        EmergencyStopped
            If the emergency stop is on.
        TrajectoryOver
            If it has ended already; it counts as a late one, unless its sender's clock is another.
        """
        if self.is_frozen:
            raise EmergencyStopped
        self._check_limits(trajectory)
        try:
            is_late = not self._executor.accept(trajectory, self.time)
        except TrajectoryOver as error:
            self.late_trajectories += error.is_delayed
            raise
        self.late_trajectories += is_late

    def freeze(self, is_frozen: bool) -> None:
        """Hold all joints where they are commanded now, or take trajectories again."""
        if is_frozen and not self.is_frozen:
            self._executor.hold(self._executor.command(self.time)[0])
        self.is_frozen = is_frozen

    def _check_limits(self, trajectory: JointTrajectory) -> None:
        names = self._limits.joint_names
        if sorted(trajectory.joint_names) != sorted(names):
            # The executor says which one lacks, or is not known.
            return
        order = [trajectory.joint_names.index(name) for name in names]
        self._limits.check(
            trajectory.times, trajectory.positions[:, order], trajectory.velocities[:, order]
        )

    def plan_failure(self, failure: JointFailure | None) -> None:
        """
        Let a joint fail when it is time to, in place of what was planned before.

        Parameters
        ----------
        failure : JointFailure or None
            None: what was planned does not happen. What has happened stays until a reset.

        Raises
        ------
        JointNotFound
            If the robot has no joint of that name.
        NotSimulated
            If the simulator has no such failures.
        """
        if failure is not None:
            self._robot.joint_index(failure.joint)
            if failure.kind not in self._simulator.failures:
                raise NotSimulated(f'a {failure.kind} joint', engines_with('has_world'))
        self._failure = failure

    def step(self) -> None:
        """Advance by one time step."""
        failure = self._failure
        if failure is not None and self.time >= failure.time - self.time_step / 2.0:
            self._simulator.fail_joint(self._robot.joint_index(failure.joint), failure.kind)
            self._failure, self.failed = None, failure
        if self.time >= self._push_ends - self.time_step / 2.0:
            self.push(np.zeros(3))
        self._simulator.step(*self._executor.command(self.time + self.time_step))

    def observe(self) -> Observation:
        """Return the robot's state, and note contacts and falls."""
        observation = self._simulator.observe()
        self.contacts_seen.update(observation.contacts)
        self.has_fallen = self.has_fallen or observation.has_fallen
        return observation

    def check_solid(self, what: str) -> SolidSimulator:
        """
        Return the simulator, if it has a world that the robot can touch.

        Parameters
        ----------
        what : str
            What that is wanted for, with its article.

        Raises
        ------
        NotSimulated
            If it has none.
        """
        if not isinstance(self._simulator, SolidSimulator):
            raise NotSimulated(what, engines_with('has_world'))
        return self._simulator

    def check_visible(self, what: str) -> VisibleSimulator:
        """
        Return the simulator, if it has a world to look at.

        Parameters
        ----------
        what : str
            What that is wanted for, with its article.

        Raises
        ------
        NotSimulated
            If it has none.
        """
        if not isinstance(self._simulator, VisibleSimulator):
            raise NotSimulated(what, engines_with('has_pictures'))
        return self._simulator

    def change_obstacles(self, changes: Iterable[ObstacleChange], most: int | None = None) -> None:
        """
        Put and remove obstacles, all or, if there is an error, none.

        Parameters
        ----------
        changes : iterable of ObstacleChange
            In order.
        most : int, optional
            So many obstacles may stand at once; any number if not given.

        Raises
        ------
        NotSimulated
            If the simulator has no obstacles.
        TooManyObstacles
            If there would be more.
        ObstacleOnRobot
            If one would stand where the robot is.
        """
        changes = list(changes)
        world = self.check_solid('an obstacle')
        self.check_clear(changes)
        change_obstacles(world, changes, most)

    def check_clear(self, changes: Iterable[ObstacleChange]) -> None:
        """Raise ObstacleOnRobot if an obstacle would stand where the robot is."""
        pose = self._simulator.observe().pose
        for change in changes:
            if change.obstacle is not None:
                distance = float(change.obstacle.distance_to(np.array([pose.x, pose.y])))
                if distance < self._standing_radius:
                    raise ObstacleOnRobot(str(change.name), distance, self._standing_radius)

    @property
    def obstacles(self) -> Mapping[Hashable, Obstacle]:
        """Obstacles that stand, by name; none in a simulator without."""
        simulator = self._simulator
        return simulator.obstacles if isinstance(simulator, SolidSimulator) else {}

    def foot_forces(self) -> Array:
        """Return the normal forces against the feet; see :class:`SolidSimulator`."""
        return self.check_solid('the forces on the feet').foot_forces()

    def push(self, force: Array, duration: float = math.inf) -> None:
        """
        Push against the body from now on, in place of the last push.

        Parameters
        ----------
        force : ndarray, shape (3,)
            Against the body's center of mass, in the world's axes [N].
        duration : float
            Simulated time for which it lasts, a time step at least [s].

        Raises
        ------
        NotSimulated
            If the simulator has no forces.
        """
        self.check_solid('a push').push(force)
        self._push_ends = self.time + max(duration, self.time_step)
        self.pushes += bool(np.any(force))

    def throw(self, ball: Ball | None) -> None:
        """Let a ball fly; see :class:`ThrowingSimulator`. NotSimulated where there are no balls."""
        if not isinstance(self._simulator, ThrowingSimulator):
            raise NotSimulated('a ball', engines_with('has_world'))
        self._simulator.throw(ball)

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Lay the goal's marker on the floor, or move it; NotSimulated if it cannot be seen."""
        self.check_visible('a goal marker').put_goal_marker(pose)

    def picture(self, camera: SimulatedCamera, rng: np.random.Generator) -> Picture:
        """Take a picture of the world as it is now; see :meth:`SimulatedCamera.take`."""
        return camera.take(self.check_visible('a camera'), rng)

    def close(self) -> None:
        """Release the simulator."""
        self._simulator.close()
