"""
URDF generated from a robot's data: links, inertias, limits, feet.

One link per body, hip, thigh, calf and foot. The inertias are those of solid boxes,
cylinders and spheres with the data file's masses and sizes.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree

from quad_common.leg_kinematics import YawPitchPitchLeg
from quad_common.robot import LEGS, Robot

Vector = tuple[float, float, float]

_ORIGIN: Vector = (0.0, 0.0, 0.0)


def urdf_from_robot(robot: Robot) -> str:
    """
    Write a robot as URDF.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    str
        The XML text. Joints are named as in :attr:`Robot.joint_names`; feet are the
        links ``lf_foot`` and so on; joint angles mean what they mean in
        :mod:`quad_common.leg_kinematics`.
    """
    root = ElementTree.Element('robot', name=robot.name)
    length, width, height = robot.body_size
    _link(
        root,
        'base_link',
        robot.body_mass,
        robot.body_center,
        (
            robot.body_mass / 12.0 * (width**2 + height**2),
            robot.body_mass / 12.0 * (length**2 + height**2),
            robot.body_mass / 12.0 * (length**2 + width**2),
        ),
        ('box', {'size': _text((length, width, height))}),
        _ORIGIN,
    )
    for index, leg in enumerate(robot.legs):
        _leg(root, robot, index, leg)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding='unicode')


def _leg(root: ElementTree.Element, robot: Robot, index: int, leg: YawPitchPitchLeg) -> None:
    """Add one leg: each link's x axis points along the leg, and pitch turns x down."""
    prefix = LEGS[index]
    names = robot.joint_names[3 * index : 3 * index + 3]
    pitch_axis = (leg.hip_offset, 0.0, -leg.hip_drop)
    _rod(root, robot, prefix, 'hip', pitch_axis)
    _rod(root, robot, prefix, 'thigh', (leg.thigh_length, 0.0, 0.0))
    _rod(root, robot, prefix, 'calf', (leg.calf_length, 0.0, 0.0))
    foot = robot.links['foot']
    _link(
        root,
        f'{prefix}_foot',
        foot.mass,
        _ORIGIN,
        (0.4 * foot.mass * foot.radius**2,) * 3,
        ('sphere', {'radius': f'{foot.radius:.6g}'}),
        _ORIGIN,
    )
    chain = (
        ('base_link', 'hip', leg.hip, (0.0, 0.0, leg.outward), '0 0 1'),
        (f'{prefix}_hip', 'thigh', pitch_axis, _ORIGIN, '0 1 0'),
        (f'{prefix}_thigh', 'calf', (leg.thigh_length, 0.0, 0.0), _ORIGIN, '0 1 0'),
    )
    for kind, (parent, child, xyz, rpy, axis) in enumerate(chain):
        joint = _joint(root, names[kind], 'revolute', parent, f'{prefix}_{child}', xyz, rpy)
        ElementTree.SubElement(joint, 'axis', xyz=axis)
        ElementTree.SubElement(
            joint,
            'limit',
            lower=f'{robot.lower[kind]:.9g}',
            upper=f'{robot.upper[kind]:.9g}',
            velocity=f'{robot.velocity[kind]:.9g}',
            effort=f'{robot.effort[kind]:.9g}',
        )
    _joint(
        root,
        f'{prefix}_foot_joint',
        'fixed',
        f'{prefix}_calf',
        f'{prefix}_foot',
        (leg.calf_length, 0.0, 0.0),
        _ORIGIN,
    )


def _rod(root: ElementTree.Element, robot: Robot, prefix: str, kind: str, end: Vector) -> None:
    """Add a link that is a cylinder from its joint to ``end`` (in its xz-plane)."""
    shape = robot.links[kind]
    length = math.hypot(end[0], end[2])
    middle = (end[0] / 2.0, 0.0, end[2] / 2.0)
    across = shape.mass * (3.0 * shape.radius**2 + length**2) / 12.0
    along = shape.mass * shape.radius**2 / 2.0
    # URDF's cylinders stand along z: turn z onto the rod.
    tilt = math.atan2(end[0], end[2])
    _link(
        root,
        f'{prefix}_{kind}',
        shape.mass,
        middle,
        (across, across, along),
        ('cylinder', {'radius': f'{shape.radius:.6g}', 'length': f'{length:.9g}'}),
        (0.0, tilt, 0.0),
    )


def _link(
    root: ElementTree.Element,
    name: str,
    mass: float,
    center: Vector,
    inertia: Vector,
    shape: tuple[str, dict[str, str]],
    rpy: Vector,
) -> None:
    link = ElementTree.SubElement(root, 'link', name=name)
    inertial = ElementTree.SubElement(link, 'inertial')
    ElementTree.SubElement(inertial, 'origin', xyz=_text(center), rpy=_text(rpy))
    ElementTree.SubElement(inertial, 'mass', value=f'{mass:.9g}')
    ixx, iyy, izz = (f'{value:.9g}' for value in inertia)
    ElementTree.SubElement(
        inertial, 'inertia', ixx=ixx, ixy='0', ixz='0', iyy=iyy, iyz='0', izz=izz
    )
    for use in ('visual', 'collision'):
        element = ElementTree.SubElement(link, use)
        ElementTree.SubElement(element, 'origin', xyz=_text(center), rpy=_text(rpy))
        geometry = ElementTree.SubElement(element, 'geometry')
        ElementTree.SubElement(geometry, shape[0], shape[1])


def _joint(
    root: ElementTree.Element,
    name: str,
    kind: str,
    parent: str,
    child: str,
    xyz: Vector,
    rpy: Vector,
) -> ElementTree.Element:
    joint = ElementTree.SubElement(root, 'joint', name=name, type=kind)
    ElementTree.SubElement(joint, 'parent', link=parent)
    ElementTree.SubElement(joint, 'child', link=child)
    ElementTree.SubElement(joint, 'origin', xyz=_text(xyz), rpy=_text(rpy))
    return joint


def _text(vector: Vector) -> str:
    return ' '.join(f'{value:.9g}' for value in vector)
