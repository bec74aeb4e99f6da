"""
The robot in PyBullet's physics. The only file that imports pybullet.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
import os
import sys
from collections.abc import Hashable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import quaternion_from_matrix, tilt_from_quaternion
from quad_sim.engines.bullet_body import SOLVER_ITERATIONS, load_body, needed_iterations
from quad_sim.engines.bullet_ground import lay_ground
from quad_sim.engines.bullet_obstacles import BulletObstacles, build_walls
from quad_sim.engines.bullet_scene import BulletScene
from quad_sim.engines.simulator import (
    FAILURES,
    FRICTION_FRACTION,
    GRAVITY,
    TILT_OF_A_FALL,
    Contact,
    Observation,
    check_commands,
    falls_of,
    foot_zone,
)
from quad_sim.world.appearance import Appearance
from quad_sim.world.standing import initial_place
from quad_sim.world.world import OF_WORLD, Obstacle, World


@contextlib.contextmanager
def _silenced() -> Iterator[None]:
    """Keep PyBullet's greetings off the output, which may be somebody's JSON."""
    streams = (sys.stdout, sys.stderr)
    with Path(os.devnull).open('wb') as nothing:
        for stream in streams:
            stream.flush()
        saved = [os.dup(number) for number in (1, 2)]
        try:
            for number in (1, 2):
                os.dup2(nothing.fileno(), number)
            yield
        finally:
            # Python and C keep what they print to a pipe or a file until later.
            for stream in streams:
                stream.flush()
            ctypes.CDLL(None).fflush(None)
            for number, was in zip((1, 2), saved):
                os.dup2(was, number)
                os.close(was)


try:
    with _silenced():
        import pybullet
        from pybullet_utils.bullet_client import BulletClient
except ImportError as error:
    raise MissingOptionalDependency(
        'pybullet', 'pip install pybullet (wheels for Python up to 3.11; later ones compile it)'
    ) from error

Array = NDArray[np.float64]

_POSITION_GAIN = 0.3
_VELOCITY_GAIN = 1.0


def headless_client() -> Any:
    """Open an empty world without a window, a ``BulletClient`` of one's own."""
    with _silenced():
        return BulletClient(pybullet.DIRECT)


class BulletSimulator:
    """
    A rigid-body simulation of one robot in one world.

    Parameters
    ----------
    robot : Robot
        The robot.
    world : World
        Ground and obstacles.
    time_step : float
        Fixed step [s].
    gui : bool
        Show PyBullet's own window.
    appearance : Appearance, optional
        Of the world in pictures.

    Raises
    ------
    MissingOptionalDependency
        On import of this module, if PyBullet is not installed.
    """

    def __init__(
        self,
        robot: Robot,
        world: World,
        time_step: float = 0.005,
        gui: bool = False,
        appearance: Appearance | None = None,
    ) -> None:
        self.time_step = time_step
        self.failures: tuple[str, ...] = FAILURES
        self._robot = robot
        self._world = world
        self._appearance = Appearance() if appearance is None else appearance
        self._scene: BulletScene | None = None
        self._goal: Pose2D | None = None
        self._steps = 0
        with _silenced():
            self._bullet: Any = BulletClient(pybullet.GUI if gui else pybullet.DIRECT)
        self._bullet.setGravity(0.0, 0.0, -GRAVITY)
        self._bullet.setPhysicsEngineParameter(
            fixedTimeStep=time_step,
            numSolverIterations=SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
        )
        self._grounds = lay_ground(self._bullet, world)
        build_walls(self._bullet, world)
        self._obstacles = BulletObstacles(self._bullet, world)
        for index, obstacle in enumerate(world.obstacles):
            self.put_obstacle((OF_WORLD, index), obstacle)
        body = load_body(self._bullet, robot, in_physics=True)
        self._body, self._joints, self._link_names = body.number, body.joints, body.links
        self._inertial = body.inertial
        if robot.own_urdf:
            iterations = needed_iterations(self._bullet, robot, body)
            self._bullet.setPhysicsEngineParameter(numSolverIterations=iterations)
        self._efforts = robot.effort.reshape(-1).tolist()
        self._feet = robot.part_names.feet
        self._falls = falls_of(robot)
        self._foot_of = body.feet_by_calf
        """Feet by the calves that they are fixed to."""
        self._foot_zone = foot_zone(robot)
        self._last_velocity = np.zeros(3)
        self._force: list[float] | None = None
        self.reset(Pose2D(0.0, 0.0, 0.0))

    @property
    def time(self) -> float:
        """Simulated time since the simulator was made [s]."""
        return self._steps * self.time_step

    def reset(self, pose: Pose2D) -> None:
        """Stand the robot at a pose; see :meth:`Simulator.reset`."""
        base, rotation = initial_place(self._robot, self._world.terrain, pose)
        if rotation is None:
            orientation = pybullet.getQuaternionFromEuler((0.0, 0.0, pose.yaw))
        else:
            orientation = quaternion_from_matrix(rotation)
        self._last_velocity = np.zeros(3)
        self._force = None
        self._free: list[int] = []
        self._stuck: dict[int, float] = {}
        angles = self._robot.initial_joint_angles.reshape(-1)
        self.place(base, orientation, angles)
        self._command(angles, np.zeros_like(angles))

    def place(
        self, position: Array, orientation: Sequence[float] | Array, joint_angles: Array
    ) -> None:
        """Put the robot somewhere, at rest; see :meth:`VisibleSimulator.place`."""
        center, turned = self._inertial.from_base(
            position, orientation, self._to_world(orientation)
        )
        self._bullet.resetBasePositionAndOrientation(self._body, center, turned)
        self._bullet.resetBaseVelocity(self._body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        for joint, angle in zip(self._joints, joint_angles):
            self._bullet.resetJointState(self._body, joint, float(angle))

    def fail_joint(self, joint: int, kind: str) -> None:
        """Let a joint fail from now on; see :meth:`Simulator.fail_joint`."""
        if kind == 'free':
            self._free.append(joint)
        else:
            self._stuck[joint] = self._bullet.getJointState(self._body, self._joints[joint])[0]

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        """
        Advance by one time step.

        Parameters
        ----------
        joint_positions : ndarray, shape (12,)
            Wanted [rad], in the order of ``Robot.joint_names``.
        joint_velocities : ndarray, shape (12,)
            Wanted [rad/s].

        Raises
        ------
        ParameterError
            If one of them is not finite: that would stay in Bullet's world for ever.
        """
        check_commands(joint_positions, joint_velocities)
        self._command(joint_positions, joint_velocities)
        self._last_velocity = np.array(self._bullet.getBaseVelocity(self._body)[0])
        if self._force is not None:
            center = self._bullet.getBasePositionAndOrientation(self._body)[0]
            self._bullet.applyExternalForce(
                self._body, -1, self._force, center, pybullet.WORLD_FRAME
            )
        self._bullet.stepSimulation()
        self._steps += 1

    def observe(self) -> Observation:
        """Return the robot's state."""
        # Bullet speaks of the body's center of mass; base_link is its own point.
        center, orientation = self._bullet.getBasePositionAndOrientation(self._body)
        orientation = self._inertial.base_orientation(orientation)
        velocity, spin = (np.array(v) for v in self._bullet.getBaseVelocity(self._body))
        to_world = self._to_world(orientation)
        to_base = to_world.T
        to_center = to_world @ self._inertial.center
        acceleration = (velocity - self._last_velocity) / self.time_step
        states = self._bullet.getJointStates(self._body, self._joints)
        contacts = self._contacts()
        efforts = np.array([state[3] for state in states])
        # What Bullet's motor gives there is the gear's friction.
        efforts[self._free] = 0.0
        tilted = tilt_from_quaternion(np.array(orientation)) > TILT_OF_A_FALL
        return Observation(
            time=self.time,
            position=center - to_center,
            orientation=np.array(orientation),
            linear_velocity_base_in_base=to_base @ (velocity - _cross(spin, to_center)),
            angular_velocity_base_in_base=to_base @ spin,
            specific_force_in_base=to_base @ (acceleration + (0.0, 0.0, GRAVITY)),
            joint_positions=np.array([state[0] for state in states]),
            joint_velocities=np.array([state[1] for state in states]),
            joint_efforts=efforts,
            contacts=contacts,
            has_fallen=bool(tilted or self._falls.intersection(contacts)),
        )

    def foot_forces(self) -> Array:
        """
        Return what presses against each foot, as no robot can measure it.

        Returns
        -------
        ndarray, shape (4,)
            Of ``LEGS``: normal forces of the ground and of obstacles in the last step, added up
            over the points of contact; 0 in the air [N].
        """
        forces = dict.fromkeys(self._feet, 0.0)
        for point in self._bullet.getContactPoints(bodyA=self._body):
            if point[2] != self._body and self._is_foot(point[3], point[5]):
                forces[self._link_names[self._foot_of.get(point[3], point[3])]] += point[9]
        return np.array(list(forces.values()))

    def push(self, force: Array) -> None:
        """Push against the body from now on; see :meth:`SolidSimulator.push`."""
        self._force = force.tolist() if np.any(force) else None

    def put_obstacle(self, name: Hashable, obstacle: Obstacle) -> None:
        """
        Put an obstacle, in the place of the one of that name if there is one.

        Parameters
        ----------
        name : hashable
            Of the obstacle; those of the world are ('room', 0), ('room', 1) and so on.
        obstacle : Obstacle
            It stands fast.
        """
        self._obstacles.put(name, obstacle)
        if self._scene is not None:
            self._scene.put_obstacle(name, obstacle)

    def remove_obstacle(self, name: Hashable) -> None:
        """Take an obstacle away, if it is there."""
        self._obstacles.remove(name)
        if self._scene is not None:
            self._scene.remove_obstacle(name)

    @property
    def obstacles(self) -> dict[Hashable, Obstacle]:
        """Those that stand there now, besides the walls."""
        return self._obstacles.standing

    def put_goal_marker(self, pose: Pose2D) -> None:
        """Lay the goal's marker on the floor, or move it; nothing collides with it."""
        self._goal = pose
        if self._scene is not None:
            self._scene.put_goal_marker(pose)

    def prepare_pictures(self) -> None:
        """Make the world that pictures are taken of."""
        if self._scene is None:
            self._scene = self._make_scene()

    def render(self, view: Array, projection: Array, width: int, height: int) -> NDArray[np.uint8]:
        """Draw a picture, which physics do not notice; see `simulated_camera.Scene`."""
        self.prepare_pictures()
        assert self._scene is not None
        center, orientation = self._bullet.getBasePositionAndOrientation(self._body)
        states = self._bullet.getJointStates(self._body, self._joints)
        self._scene.put_robot(center, orientation, [state[0] for state in states])
        return self._scene.render(view, projection, width, height)

    def close(self) -> None:
        """Disconnect from the physics server."""
        if self._scene is not None:
            self._scene.close()
        if self._bullet.isConnected():
            self._bullet.disconnect()

    def _to_world(self, orientation: Sequence[float] | Array) -> Array:
        matrix = self._bullet.getMatrixFromQuaternion(orientation)
        return np.reshape(matrix, (3, 3))

    def _command(self, positions: Array, velocities: Array) -> None:
        count = len(self._joints)
        if self._stuck:
            positions, velocities = positions.copy(), velocities.copy()
            for joint, angle in self._stuck.items():
                positions[joint], velocities[joint] = angle, 0.0
        self._bullet.setJointMotorControlArray(
            self._body,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=positions,
            targetVelocities=velocities,
            forces=self._efforts,
            positionGains=[_POSITION_GAIN] * count,
            velocityGains=[_VELOCITY_GAIN] * count,
        )
        for joint in self._free:
            self._bullet.setJointMotorControl2(
                self._body,
                self._joints[joint],
                pybullet.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=FRICTION_FRACTION * self._efforts[joint],
            )

    def _make_scene(self) -> BulletScene:
        """Make what pictures are taken of, a second world with the same things in it."""
        client = headless_client()
        body = load_body(client, self._robot, in_physics=False)
        scene = BulletScene(client, body, self._robot, self._world, self._appearance)
        for name, obstacle in self.obstacles.items():
            scene.put_obstacle(name, obstacle)
        if self._goal is not None:
            scene.put_goal_marker(self._goal)
        return scene

    def _is_foot(self, link: int, place: Sequence[float]) -> bool:
        """Whether a link that touches something at a place [m] stands there as a foot."""
        if self._link_names[link] in self._feet:
            return True
        foot = self._foot_of.get(link)
        if foot is None:
            return False
        center = self._bullet.getLinkState(self._body, foot)[4]
        return math.dist(place, center) < self._foot_zone

    def _contacts(self) -> tuple[Contact, ...]:
        found = set()
        for point in self._bullet.getContactPoints(bodyA=self._body):
            other_body, link, other_link, distance = point[2], point[3], point[4], point[8]
            name = self._link_names[link]
            if distance > 0.0 or (other_body in self._grounds and self._is_foot(link, point[5])):
                continue
            if other_body == self._body:
                found.add(Contact(*sorted((name, self._link_names[other_link]))))
            else:
                found.add(Contact(name, 'ground' if other_body in self._grounds else 'obstacle'))
        return tuple(sorted(found, key=str))


def _cross(a: Array, b: Array) -> Array:
    """Vector product of two vectors; numpy's own takes ten times as long for just two."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
