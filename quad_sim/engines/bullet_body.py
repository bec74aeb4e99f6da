"""
The robot as a body of Bullet.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from quad_common.process.temporary_folder import temporary_folder
from quad_common.robot.robot import Robot
from quad_common.robot.urdf import urdf_from_robot


@dataclass(frozen=True)
class BulletBody:
    """A robot in a Bullet world."""

    number: int
    """Bullet's number of the body."""
    joints: list[int]
    """Bullet's indices of the joints, in the order of ``Robot.joint_names``."""
    links: dict[int, str]
    """Names of the links by Bullet's indices."""


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
        path = folder / f'{robot.name}.urdf'
        path.write_text(urdf_from_robot(robot), encoding='utf-8')
        number: int = client.loadURDF(str(path), flags=flags)
    by_name, links = {}, {-1: 'base_link'}
    for index in range(client.getNumJoints(number)):
        described = client.getJointInfo(number, index)
        by_name[described[1].decode()], links[index] = index, described[12].decode()
    body = BulletBody(number, [by_name[name] for name in robot.joint_names], links)
    if in_physics:
        _set_dynamics(client, body)
    return body


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
