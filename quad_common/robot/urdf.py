"""
URDF generated from a robot's data: links, inertias, limits, feet.

One link per body, hip, thigh, calf and foot. The inertias are those of solid boxes,
cylinders and spheres with the data file's masses and sizes.
"""

from __future__ import annotations

import math
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_kinematics import Leg
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS, LinkShape

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
        :mod:`quad_common.robot.leg_kinematics`.
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


def _leg(root: ElementTree.Element, robot: Robot, index: int, leg: Leg) -> None:
    """Add one leg: in its links' frames x is rho or along the link, y is nu."""
    prefix = LEGS[index]
    names = robot.joint_names[3 * index : 3 * index + 3]
    pitch_axis = (float(leg.radial_offset), float(leg.lateral_offset), float(leg.axial_offset))
    knee = (float(leg.thigh_length), 0.0, 0.0)
    sole = (float(leg.calf_length), 0.0, 0.0)
    _rod(root, robot, prefix, 'hip', pitch_axis)
    _rod(root, robot, prefix, 'thigh', knee)
    _rod(root, robot, prefix, 'calf', sole)
    _ball(root, f'{prefix}_foot', robot.links['foot'])
    x, y, z = leg.hip
    axes = np.column_stack([leg.radial_direction, leg.lateral_direction, leg.first_axis])
    chain = (
        ('base_link', 'hip', (float(x), float(y), float(z)), _rpy_from_matrix(axes), '0 0 {:g}'),
        (f'{prefix}_hip', 'thigh', pitch_axis, _ORIGIN, '0 {:g} 0'),
        (f'{prefix}_thigh', 'calf', knee, _ORIGIN, '0 {:g} 0'),
    )
    for kind, (parent, child, xyz, rpy, axis) in enumerate(chain):
        joint = _joint(root, names[kind], 'revolute', parent, f'{prefix}_{child}', xyz, rpy)
        ElementTree.SubElement(joint, 'axis', xyz=axis.format(leg.signs[kind]))
        ElementTree.SubElement(
            joint,
            'limit',
            lower=f'{robot.lower[index, kind]:.9g}',
            upper=f'{robot.upper[index, kind]:.9g}',
            velocity=f'{robot.velocity[index, kind]:.9g}',
            effort=f'{robot.effort[index, kind]:.9g}',
        )
    foot = f'{prefix}_foot'
    _joint(root, f'{foot}_joint', 'fixed', f'{prefix}_calf', foot, sole, _ORIGIN)


def _rpy_from_matrix(matrix: NDArray[np.float64]) -> Vector:
    """Roll, pitch and yaw about fixed axes of a rotation matrix (3, 3) [rad]."""
    level = math.hypot(matrix[0, 0], matrix[1, 0])
    pitch = math.atan2(-matrix[2, 0], level)
    if level < 1e-9:
        # Straight up or down, roll and yaw turn about one axis: it is all yaw.
        return 0.0, pitch, math.atan2(-matrix[0, 1], matrix[1, 1])
    roll = math.atan2(matrix[2, 1], matrix[2, 2])
    return roll, pitch, math.atan2(matrix[1, 0], matrix[0, 0])


def _rod(root: ElementTree.Element, robot: Robot, prefix: str, kind: str, end: Vector) -> None:
    """Add a link that is a cylinder from its joint to ``end``; a ball if that is no way."""
    shape = robot.links[kind]
    x, y, z = end
    length = math.hypot(x, y, z)
    if length == 0.0:
        _ball(root, f'{prefix}_{kind}', shape)
        return
    across = shape.mass * (3.0 * shape.radius**2 + length**2) / 12.0
    along = shape.mass * shape.radius**2 / 2.0
    _link(
        root,
        f'{prefix}_{kind}',
        shape.mass,
        (x / 2.0, y / 2.0, z / 2.0),
        (across, across, along),
        ('cylinder', {'radius': f'{shape.radius:.6g}', 'length': f'{length:.9g}'}),
        # URDF's cylinders stand along z: turn z onto the rod.
        (0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x)),
    )


def _ball(root: ElementTree.Element, name: str, shape: LinkShape) -> None:
    """Add a link that is a ball around its joint."""
    _link(
        root,
        name,
        shape.mass,
        _ORIGIN,
        (0.4 * shape.mass * shape.radius**2,) * 3,
        ('sphere', {'radius': f'{shape.radius:.6g}'}),
        _ORIGIN,
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
