"""
URDF of a robot: its own, or one generated from its data with links, inertias, limits and feet.

A generated one has one link per body, hip, thigh, calf and foot. The inertias are those of solid
boxes, cylinders and spheres with the data file's masses and sizes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import PurePath
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from quad_common.robot.leg_kinematics import Leg
from quad_common.robot.robot import Robot
from quad_common.robot.robot_build import LEGS, LinkShape

Vector = tuple[float, float, float]

_ZERO: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class _Origin:
    """Pose of a frame in the frame of a link, as URDF has it."""

    xyz: Vector = _ZERO
    """Position [m]."""
    rpy: Vector = _ZERO
    """Roll, pitch and yaw about fixed axes [rad]."""


@dataclass(frozen=True)
class _Solid:
    """A homogeneous body, in axes of its own at its center of mass."""

    mass: float
    """[kg]"""
    inertia: Vector
    """Principal moments ixx, iyy and izz [kg m^2]."""
    geometry: str
    """Name of URDF's element: box, cylinder or sphere."""
    size: dict[str, str]
    """That element's attributes [m]."""


def urdf_from_robot(robot: Robot) -> str:
    """
    Return a robot's own URDF, or write one if it has none.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    str
        The XML text, with base_link's frame at its root. Joints and links are named as in
        :attr:`Robot.part_names`; joint angles mean what they mean in
        :mod:`quad_common.robot.leg_kinematics`.
    """
    if robot.own_urdf:
        return robot.own_urdf
    root = ElementTree.Element('robot', name=robot.name)
    length, width, height = robot.body_size
    inertia = (
        robot.body_mass / 12.0 * (width**2 + height**2),
        robot.body_mass / 12.0 * (length**2 + height**2),
        robot.body_mass / 12.0 * (length**2 + width**2),
    )
    body = _Solid(robot.body_mass, inertia, 'box', {'size': _text((length, width, height))})
    _link(root, 'base_link', body, _Origin(robot.body_center))
    for index, leg in enumerate(robot.legs):
        _leg(root, robot, index, leg)
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding='unicode')


def published_urdf(robot: Robot) -> str:
    """
    Return a robot's URDF for others, whose tree of frames begins at base_link.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    str
        As :func:`urdf_from_robot`; above a root of another name there is ``base_link``, in the
        same place. Meshes are named by URIs, ``file:///...``, as RViz and Foxglove need them.
    """
    text = urdf_from_robot(robot)
    if not robot.own_urdf:
        return text
    root = ElementTree.fromstring(text)
    for mesh in root.iter('mesh'):
        path = PurePath(mesh.get('filename', ''))
        if path.is_absolute():
            mesh.set('filename', path.as_uri())
    children = {joint.find('child').get('link') for joint in root.iter('joint')}  # type: ignore[union-attr]
    top = next(link.get('name') for link in root.iter('link') if link.get('name') not in children)
    if top != 'base_link':
        ElementTree.SubElement(root, 'link', name='base_link')
        _joint(root, 'base_link_fixed', 'fixed', ('base_link', str(top)), _Origin())
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
    hip = _Origin((float(x), float(y), float(z)), _rpy_from_matrix(axes))
    chain = (
        ('base_link', 'hip', hip, '0 0 {:g}'),
        (f'{prefix}_hip', 'thigh', _Origin(pitch_axis), '0 {:g} 0'),
        (f'{prefix}_thigh', 'calf', _Origin(knee), '0 {:g} 0'),
    )
    for kind, (parent, child, origin, axis) in enumerate(chain):
        links = parent, f'{prefix}_{child}'
        joint = _joint(root, names[kind], 'revolute', links, origin)
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
    _joint(root, f'{foot}_joint', 'fixed', (f'{prefix}_calf', foot), _Origin(sole))


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
    """Add a link that is a cylinder from its joint to ``end``; a ball if they coincide."""
    shape = robot.links[kind]
    x, y, z = end
    length = math.hypot(x, y, z)
    if length == 0.0:
        _ball(root, f'{prefix}_{kind}', shape)
        return
    across = shape.mass * (3.0 * shape.radius**2 + length**2) / 12.0
    along = shape.mass * shape.radius**2 / 2.0
    size = {'radius': f'{shape.radius:.6g}', 'length': f'{length:.9g}'}
    # URDF's cylinders stand along z: turn z onto the rod.
    rpy = (0.0, math.atan2(math.hypot(x, y), z), math.atan2(y, x))
    rod = _Solid(shape.mass, (across, across, along), 'cylinder', size)
    _link(root, f'{prefix}_{kind}', rod, _Origin((x / 2.0, y / 2.0, z / 2.0), rpy))


def _ball(root: ElementTree.Element, name: str, shape: LinkShape) -> None:
    """Add a link that is a ball around its joint."""
    inertia = (0.4 * shape.mass * shape.radius**2,) * 3
    ball = _Solid(shape.mass, inertia, 'sphere', {'radius': f'{shape.radius:.6g}'})
    _link(root, name, ball, _Origin())


def _link(root: ElementTree.Element, name: str, solid: _Solid, center: _Origin) -> None:
    """Add a link that is one solid, seen and touched as it is."""
    link = ElementTree.SubElement(root, 'link', name=name)
    inertial = ElementTree.SubElement(link, 'inertial')
    _add_origin(inertial, center)
    ElementTree.SubElement(inertial, 'mass', value=f'{solid.mass:.9g}')
    ixx, iyy, izz = (f'{value:.9g}' for value in solid.inertia)
    ElementTree.SubElement(
        inertial, 'inertia', ixx=ixx, ixy='0', ixz='0', iyy=iyy, iyz='0', izz=izz
    )
    for use in ('visual', 'collision'):
        element = ElementTree.SubElement(link, use)
        _add_origin(element, center)
        geometry = ElementTree.SubElement(element, 'geometry')
        ElementTree.SubElement(geometry, solid.geometry, solid.size)


def _joint(
    root: ElementTree.Element, name: str, kind: str, links: tuple[str, str], origin: _Origin
) -> ElementTree.Element:
    """Add a joint of a kind between a parent and its child, whose origin is in the parent."""
    parent, child = links
    joint = ElementTree.SubElement(root, 'joint', name=name, type=kind)
    ElementTree.SubElement(joint, 'parent', link=parent)
    ElementTree.SubElement(joint, 'child', link=child)
    _add_origin(joint, origin)
    return joint


def _add_origin(element: ElementTree.Element, origin: _Origin) -> None:
    ElementTree.SubElement(element, 'origin', xyz=_text(origin.xyz), rpy=_text(origin.rpy))


def _text(vector: Vector) -> str:
    return ' '.join(f'{value:.9g}' for value in vector)
