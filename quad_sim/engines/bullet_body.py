"""
The robot as a body of Bullet.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import RobotNotLoaded
from quad_common.process.temporary_folder import temporary_folder
from quad_common.robot.robot import Robot
from quad_common.robot.urdf import urdf_from_robot

Array = NDArray[np.float64]

SOLVER_ITERATIONS = 25
"""Half of Bullet's own: a walking body tilts by 0.2 degrees, not 0.1; a step is a third faster."""

_MOST_ITERATIONS = 400

_ALOFT = 100.0
"""Height at which a robot touches nothing but itself [m]."""


@dataclass(frozen=True, eq=False)
class InertialFrame:
    """Frame of the body's inertia in base_link, which Bullet gives in place of base_link's."""

    center: Sequence[float] | Array
    """Center of the body's mass in base_link, shape (3,) [m]."""
    turn: tuple[float, ...] | None = None
    """Quaternion xyzw of the axes of inertia in base_link; None if they are base_link's."""

    def from_base(
        self, base: Array, orientation: Sequence[float] | Array, to_world: Array
    ) -> tuple[Array, Sequence[float] | Array]:
        """Return this frame's pose for one of base_link, of which ``to_world`` is the matrix."""
        center: Array = base + to_world @ self.center
        if self.turn is None:
            return center, orientation
        return center, _product(orientation, self.turn)

    def base_orientation(self, orientation: Sequence[float]) -> Sequence[float] | Array:
        """Return base_link's orientation for one of this frame, quaternions xyzw."""
        if self.turn is None:
            return orientation
        x, y, z, w = self.turn
        return _product(orientation, (-x, -y, -z, w))


def _product(
    first: Sequence[float] | Array, second: Sequence[float]
) -> tuple[float, float, float, float]:
    """Return the product of two unit quaternions xyzw; SciPy's takes 20 times as long for two."""
    (x, y, z, w), (a, b, c, d) = first, second
    return (
        w * a + x * d + y * c - z * b,
        w * b - x * c + y * d + z * a,
        w * c + x * b - y * a + z * d,
        w * d - x * a - y * b - z * c,
    )


@dataclass(frozen=True)
class BulletBody:
    """A robot in a Bullet world."""

    number: int
    """Bullet's number of the body."""
    joints: list[int]
    """Bullet's indices of the joints, in the order of ``Robot.joint_names``."""
    links: dict[int, str]
    """Names of the links by Bullet's indices."""
    inertial: InertialFrame
    """Frame of the body's inertia."""
    feet_by_calf: dict[int, int]
    """Links of the feet by those that they are fixed to."""


def load_body(client: Any, robot: Robot, in_physics: bool) -> BulletBody:
    """
    Load a robot into a world.

    Parameters
    ----------
    client : BulletClient
        The world.
    robot : Robot
        The robot.
    in_physics : bool
        Whether it is to collide, with its own inertia; otherwise it is only looked at.
    """
    flags = 0
    if in_physics:
        flags = (
            client.URDF_USE_INERTIA_FROM_FILE
            | client.URDF_USE_SELF_COLLISION
            | client.URDF_USE_SELF_COLLISION_EXCLUDE_PARENT
            # Otherwise cylinders are hulls with a margin around them, 1 mm thicker than the
            # data say: a third more for the shins of a small robot.
            | client.URDF_USE_IMPLICIT_CYLINDER
        )
    with temporary_folder() as folder:
        path = folder / 'robot.urdf'
        path.write_text(urdf_from_robot(robot), encoding='utf-8')
        try:
            number: int = client.loadURDF(str(path), flags=flags)
        except client.error as error:
            raise RobotNotLoaded(robot.name, 'PyBullet', str(error)) from error
    by_name, links = {}, {-1: client.getBodyInfo(number)[0].decode()}
    feet: dict[int, int] = {}
    for index in range(client.getNumJoints(number)):
        described = client.getJointInfo(number, index)
        by_name[described[1].decode()], links[index] = index, described[12].decode()
        if links[index] in robot.part_names.feet:
            is_fixed = described[2] == client.JOINT_FIXED
            feet.update({described[16]: index} if is_fixed else {})
    joints = [by_name[name] for name in robot.joint_names]
    body = BulletBody(number, joints, links, _inertial_frame(client, number, robot), feet)
    if in_physics:
        _set_dynamics(client, body)
        if robot.own_urdf:
            _part_overlapping_links(client, robot, body)
    return body


def needed_iterations(client: Any, robot: Robot, body: BulletBody) -> int:
    """
    Return how many iterations Bullet's solver needs for a robot to stand firmly.

    It goes from one constraint to the next, and converges the more slowly the less inertia there
    is between the ground and the load: with calves of a hundredth of the load's inertia, as some
    descriptions have them, joints sag by 0.02 rad in 25 iterations and feet creep.

    Parameters
    ----------
    client : BulletClient
        The world.
    robot : Robot
        The robot, in its initial posture.
    body : BulletBody
        The same robot in that world.
    """
    angles = robot.initial_joint_angles.reshape(-1).tolist()
    # Six rows for the free base come first; joints are in Bullet's order, as are the angles here.
    order = np.argsort(body.joints)
    ordered = [angles[k] for k in order]
    matrix = np.array(client.calculateMassMatrix(body.number, ordered))
    inertia = np.empty(len(angles))
    inertia[order] = np.diag(matrix)[-len(angles) :]
    knees = inertia.reshape(4, 3)[:, 2]
    lengths = np.asarray(robot.stacked_legs.calf_length)
    loads = robot.mass / 4.0 * np.square(lengths)
    ratio = float(np.max(loads / knees))
    return int(np.clip(ratio, SOLVER_ITERATIONS, _MOST_ITERATIONS))


def _inertial_frame(client: Any, number: int, robot: Robot) -> InertialFrame:
    if not robot.own_urdf:
        return InertialFrame(robot.body_center)
    described = client.getDynamicsInfo(number, -1)
    return InertialFrame(np.array(described[3]), tuple(described[4]))


def _part_overlapping_links(client: Any, robot: Robot, body: BulletBody) -> None:
    """Let links pass each other that overlap in the initial posture: their shapes are covers."""
    client.resetBasePositionAndOrientation(body.number, (0.0, 0.0, _ALOFT), (0.0, 0.0, 0.0, 1.0))
    for joint, angle in zip(body.joints, robot.initial_joint_angles.reshape(-1)):
        client.resetJointState(body.number, joint, float(angle))
    client.performCollisionDetection()
    for point in client.getContactPoints(body.number, body.number):
        client.setCollisionFilterPair(body.number, body.number, point[3], point[4], 0)


def _set_dynamics(client: Any, body: BulletBody) -> None:
    for link in body.links:
        client.changeDynamics(
            body.number,
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
