"""
One robot in a Bullet world: how it is put, driven and observed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.rotations import quaternion_from_matrix, tilt_from_quaternion
from quad_sim.engines.bullet_body import load_body, needed_iterations
from quad_sim.engines.simulator import (
    FAILURES,
    FRICTION_FRACTION,
    GROUND,
    TILT_OF_A_FALL,
    Accelerometer,
    Contact,
    Observation,
    check_commands,
    falls_of,
    foot_zone,
)
from quad_sim.world.standing import initial_place
from quad_sim.world.world import World

Array = NDArray[np.float64]

_POSITION_GAIN = 0.3
_VELOCITY_GAIN = 1.0


class BulletRobot:
    """
    What a simulator offers of one robot, but for time and the world.

    Parameters
    ----------
    client : BulletClient
        The world in Bullet.
    robot : Robot
        The robot, which is loaded into it.
    world : World
        Ground on which it is put.
    time_step : float
        Fixed step [s].
    name_of : callable
        Returns what a body of Bullet that is not this robot's is, for :attr:`Contact.other`.
    """

    def __init__(
        self,
        client: Any,
        robot: Robot,
        world: World,
        time_step: float,
        name_of: Callable[[int], str],
    ) -> None:
        self.time_step = time_step
        self.failures: tuple[str, ...] = FAILURES
        self._bullet = client
        self._robot = robot
        self._world = world
        self._name_of = name_of
        body = load_body(client, robot, in_physics=True)
        self._body, self._joints, self._link_names = body.number, body.joints, body.links
        self._inertial = body.inertial
        self.iterations = needed_iterations(client, robot, body) if robot.own_urdf else 0
        """Iterations that Bullet's solver needs for it; 0 for no more than others."""
        self._efforts = robot.effort.reshape(-1).tolist()
        self._feet = robot.part_names.feet
        self._falls = falls_of(robot)
        self._foot_of = body.feet_by_calf
        """Feet by the calves that they are fixed to."""
        self._foot_zone = foot_zone(robot)
        count = len(self._joints)
        self._gains = [_POSITION_GAIN] * count, [_VELOCITY_GAIN] * count
        self._accelerometer = Accelerometer(time_step)
        self._force: list[float] | None = None

    @property
    def number(self) -> int:
        """Bullet's number of its body."""
        return self._body

    def reset(self, pose: Pose2D) -> None:
        """Stand the robot at a pose; see :meth:`Simulator.reset`."""
        base, rotation = initial_place(self._robot, self._world.terrain, pose)
        if rotation is None:
            orientation = self._bullet.getQuaternionFromEuler((0.0, 0.0, pose.yaw))
        else:
            orientation = quaternion_from_matrix(rotation)
        self._accelerometer.reset()
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

    def _drive(self, joint_positions: Array, joint_velocities: Array) -> None:
        """Have the robot driven in the next step; see :meth:`Simulator.step`."""
        check_commands(joint_positions, joint_velocities)
        self._command(joint_positions, joint_velocities)
        self._accelerometer.note(self._bullet.getBaseVelocity(self._body)[0])
        if self._force is not None:
            center = self._bullet.getBasePositionAndOrientation(self._body)[0]
            self._bullet.applyExternalForce(
                self._body, -1, self._force, center, self._bullet.WORLD_FRAME
            )

    def _observe(self, time: float) -> Observation:
        """Return the robot's state at a time [s]."""
        # Bullet speaks of the body's center of mass; base_link is its own point.
        center, orientation = self._bullet.getBasePositionAndOrientation(self._body)
        orientation = self._inertial.base_orientation(orientation)
        velocity, spin = map(np.array, self._bullet.getBaseVelocity(self._body))
        to_world = self._to_world(orientation)
        to_base = to_world.T
        to_center = to_world @ self._inertial.center
        states = self._bullet.getJointStates(self._body, self._joints)
        joint_positions, joint_velocities, _, torques = zip(*states)
        contacts = self._contacts()
        efforts = np.array(torques)
        # What Bullet's motor gives there is the gear's friction.
        if self._free:
            efforts[self._free] = 0.0
        tilted = tilt_from_quaternion(np.array(orientation)) > TILT_OF_A_FALL
        return Observation(
            time=time,
            position=center - to_center,
            orientation=np.array(orientation),
            linear_velocity_base_in_base=to_base @ (velocity - _cross(spin, to_center)),
            angular_velocity_base_in_base=to_base @ spin,
            specific_force_in_base=to_base @ self._accelerometer.specific_force(velocity),
            joint_positions=np.array(joint_positions),
            joint_velocities=np.array(joint_velocities),
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

    def _to_world(self, orientation: Sequence[float] | Array) -> Array:
        matrix = self._bullet.getMatrixFromQuaternion(orientation)
        return np.array(matrix).reshape(3, 3)

    def _command(self, positions: Array, velocities: Array) -> None:
        if self._stuck:
            positions, velocities = positions.copy(), velocities.copy()
            for joint, angle in self._stuck.items():
                positions[joint], velocities[joint] = angle, 0.0
        position_gains, velocity_gains = self._gains
        # Bullet reads lists faster than arrays.
        self._bullet.setJointMotorControlArray(
            self._body,
            self._joints,
            self._bullet.POSITION_CONTROL,
            targetPositions=positions.tolist(),
            targetVelocities=velocities.tolist(),
            forces=self._efforts,
            positionGains=position_gains,
            velocityGains=velocity_gains,
        )
        for joint in self._free:
            self._bullet.setJointMotorControl2(
                self._body,
                self._joints[joint],
                self._bullet.VELOCITY_CONTROL,
                targetVelocity=0.0,
                force=FRICTION_FRACTION * self._efforts[joint],
            )

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
            if distance > 0.0:
                continue
            if other_body == self._body:
                found.add(Contact(*sorted((name, self._link_names[other_link]))))
                continue
            other = self._name_of(other_body)
            if other != GROUND or not self._is_foot(link, point[5]):
                found.add(Contact(name, other))
        return tuple(sorted(found, key=str))


def _cross(a: Array, b: Array) -> Array:
    """Vector product of two vectors; numpy's own takes ten times as long for just two."""
    (ax, ay, az), (bx, by, bz) = a, b
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
