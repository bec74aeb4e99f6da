"""
The robot in PyBullet's physics. The only file that imports pybullet.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import sys
import tempfile
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D
from quad_common.robot import LEGS, Robot
from quad_common.urdf import urdf_from_robot
from quad_sim.simulator import TILT_OF_A_FALL, Contact, Observation, tilt_of
from quad_sim.world import World


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

GRAVITY = 9.80665
"""[m/s^2]"""

_SOLVER_ITERATIONS = 25
"""Half of Bullet's own: a walking body tilts by 0.2 degrees, not 0.1; a step is a third faster."""

_POSITION_GAIN = 0.3
_VELOCITY_GAIN = 1.0
_TILE = 4.0
"""Obstacles are put into one mesh per square of this size, so that far ones cost nothing [m]."""


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

    Raises
    ------
    MissingOptionalDependency
        On import of this module, if PyBullet is not installed.
    """

    def __init__(
        self, robot: Robot, world: World, time_step: float = 0.005, gui: bool = False
    ) -> None:
        self.time_step = time_step
        self._robot = robot
        self._steps = 0
        with _silenced():
            self._bullet: Any = BulletClient(pybullet.GUI if gui else pybullet.DIRECT)
        self._bullet.setGravity(0.0, 0.0, -GRAVITY)
        self._bullet.setPhysicsEngineParameter(
            fixedTimeStep=time_step,
            numSolverIterations=_SOLVER_ITERATIONS,
            deterministicOverlappingPairs=1,
        )
        self._ground = self._make_ground(world)
        self._obstacles = self._make_obstacles(world)
        self._body, self._joints, self._link_names = self._load_robot()
        self._feet = frozenset(f'{leg}_foot' for leg in LEGS)
        self._falls = {Contact('base_link', 'ground')}
        self._falls |= {Contact(f'{leg}_hip', 'ground') for leg in LEGS}
        self._last_velocity = np.zeros(3)
        self.reset(Pose2D(0.0, 0.0, 0.0))

    @property
    def time(self) -> float:
        """Simulated time since the simulator was made [s]."""
        return self._steps * self.time_step

    def reset(self, pose: Pose2D) -> None:
        """
        Stand the robot at a pose, in its initial posture, at rest.

        Parameters
        ----------
        pose : Pose2D
            Of base_link, in the world.
        """
        yaw = pybullet.getQuaternionFromEuler((0.0, 0.0, pose.yaw))
        base = np.array([pose.x, pose.y, self._robot.standing_height])
        center = base + self._to_world(yaw) @ self._robot.body_center
        self._bullet.resetBasePositionAndOrientation(self._body, center, yaw)
        self._bullet.resetBaseVelocity(self._body, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
        self._last_velocity = np.zeros(3)
        angles = self._robot.initial_joint_angles.reshape(-1)
        for joint, angle in zip(self._joints, angles):
            self._bullet.resetJointState(self._body, joint, float(angle))
        self._command(angles, np.zeros_like(angles))

    def step(self, joint_positions: Array, joint_velocities: Array) -> None:
        """
        Advance by one time step.

        Parameters
        ----------
        joint_positions : ndarray, shape (12,)
            Wanted [rad], in the order of ``Robot.joint_names``.
        joint_velocities : ndarray, shape (12,)
            Wanted [rad/s].
        """
        self._command(joint_positions, joint_velocities)
        self._last_velocity = np.array(self._bullet.getBaseVelocity(self._body)[0])
        self._bullet.stepSimulation()
        self._steps += 1

    def observe(self) -> Observation:
        """Return the robot's state."""
        # Bullet speaks of the body's centre of mass; base_link is its own point.
        center, orientation = self._bullet.getBasePositionAndOrientation(self._body)
        velocity, spin = (np.array(v) for v in self._bullet.getBaseVelocity(self._body))
        to_world = self._to_world(orientation)
        to_base = to_world.T
        to_center = to_world @ self._robot.body_center
        acceleration = (velocity - self._last_velocity) / self.time_step
        states = self._bullet.getJointStates(self._body, self._joints)
        contacts = self._contacts()
        tilted = tilt_of(np.array(orientation)) > TILT_OF_A_FALL
        return Observation(
            time=self.time,
            position=center - to_center,
            orientation=np.array(orientation),
            linear_velocity_base_in_base=to_base @ (velocity - _cross(spin, to_center)),
            angular_velocity_base_in_base=to_base @ spin,
            specific_force_in_base=to_base @ (acceleration + (0.0, 0.0, GRAVITY)),
            joint_positions=np.array([state[0] for state in states]),
            joint_velocities=np.array([state[1] for state in states]),
            joint_efforts=np.array([state[3] for state in states]),
            contacts=contacts,
            has_fallen=bool(tilted or any(contact in self._falls for contact in contacts)),
        )

    def close(self) -> None:
        """Disconnect from the physics server."""
        if self._bullet.isConnected():
            self._bullet.disconnect()

    def _to_world(self, orientation: Sequence[float]) -> Array:
        matrix = self._bullet.getMatrixFromQuaternion(orientation)
        return np.reshape(matrix, (3, 3))

    def _command(self, positions: Array, velocities: Array) -> None:
        count = len(self._joints)
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

    def _make_ground(self, world: World) -> int:
        plane = self._bullet.createCollisionShape(pybullet.GEOM_PLANE)
        ground: int = self._bullet.createMultiBody(0, plane)
        # Bullet multiplies the two surfaces' frictions: the feet keep 1.
        self._bullet.changeDynamics(ground, -1, lateralFriction=world.friction, restitution=0.0)
        return ground

    def _make_obstacles(self, world: World) -> frozenset[int]:
        """Build the boxes as one static mesh per tile of the floor."""
        tiles: dict[tuple[int, int], list[Array]] = defaultdict(list)
        for box in world.boxes:
            column, row = np.floor(box.mean(axis=0) / _TILE).astype(int)
            tiles[column, row].append(box)
        bodies = []
        with tempfile.TemporaryDirectory() as folder:
            for index, boxes in enumerate(tiles.values()):
                path = Path(folder) / f'{index}.obj'
                path.write_text(_mesh_of_boxes(boxes, world.obstacle_height), encoding='ascii')
                shape = self._bullet.createCollisionShape(
                    pybullet.GEOM_MESH,
                    fileName=str(path),
                    flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
                )
                bodies.append(self._bullet.createMultiBody(0, shape))
        return frozenset(bodies)

    def _load_robot(self) -> tuple[int, list[int], dict[int, str]]:
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / f'{self._robot.name}.urdf'
            path.write_text(urdf_from_robot(self._robot), encoding='utf-8')
            flags = (
                pybullet.URDF_USE_INERTIA_FROM_FILE
                | pybullet.URDF_USE_SELF_COLLISION
                | pybullet.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT
            )
            body = self._bullet.loadURDF(str(path), flags=flags)
        by_name = {}
        links = {-1: 'base_link'}
        for index in range(self._bullet.getNumJoints(body)):
            info = self._bullet.getJointInfo(body, index)
            by_name[info[1].decode()] = index
            links[index] = info[12].decode()
        for link in links:
            self._bullet.changeDynamics(
                body,
                link,
                lateralFriction=1.0,
                restitution=0.0,
                # Without it a robot that stands still at a heading creeps round by a degree
                # in a second or two. Coulomb's law holds with it as well.
                frictionAnchor=1,
                linearDamping=0.0,
                angularDamping=0.0,
                jointDamping=0.0,
            )
        self._efforts = self._robot.effort.reshape(-1).tolist()
        return body, [by_name[name] for name in self._robot.joint_names], links

    def _contacts(self) -> tuple[Contact, ...]:
        found = set()
        for point in self._bullet.getContactPoints(bodyA=self._body):
            other_body, link, other_link, distance = point[2], point[3], point[4], point[8]
            name = self._link_names[link]
            if distance > 0.0 or (other_body == self._ground and name in self._feet):
                continue
            if other_body == self._body:
                found.add(Contact(*sorted((name, self._link_names[other_link]))))
            else:
                found.add(Contact(name, 'ground' if other_body == self._ground else 'obstacle'))
        return tuple(sorted(found, key=str))


def _cross(a: Array, b: Array) -> Array:
    """Vector product of two vectors; numpy's own takes ten times as long for just two."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def _mesh_of_boxes(boxes: list[Array], height: float) -> str:
    """Write boxes (each the four base corners, counter-clockwise) as a Wavefront mesh."""
    lines = []
    faces = []
    for index, base in enumerate(boxes):
        first = 8 * index + 1
        for z in (0.0, height):
            lines += [f'v {x:.6f} {y:.6f} {z:.6f}' for x, y in base]
        for a, b, c, d in (
            (4, 5, 6, 7),
            (0, 1, 5, 4),
            (1, 2, 6, 5),
            (2, 3, 7, 6),
            (3, 0, 4, 7),
        ):
            faces.append(f'f {first + a} {first + b} {first + c}')
            faces.append(f'f {first + a} {first + c} {first + d}')
    return '\n'.join(lines + faces) + '\n'
