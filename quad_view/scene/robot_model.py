"""
A robot as it is drawn, read from any URDF: links with shapes, joints between them.

Nothing is taken for granted about names, numbers of legs or joints per leg. Frames are URDF's: a
link's frame is that of the joint that leads to it, and a joint's frame is placed in its parent's.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from xml.etree import ElementTree

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import InvalidMessage
from quad_common.errors.quoting import quoted

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

_LONGEST_URDF = 5_000_000
"""Characters of a URDF that are read."""

_MOST_LINKS = 500

_MOST_SHAPES = 2000
"""Visible parts of a robot: more take a page seconds."""

_TURNING = ('revolute', 'continuous')


@dataclass(frozen=True)
class Shape:
    """One visible part of a link."""

    kind: str
    """``box``, ``cylinder``, ``sphere`` or ``mesh``."""
    size: Vector
    """
    Sides of a box; radius and length of a cylinder, and 0; radius of a sphere, and zeros [m]; scale
    of a mesh.
    """
    position: Vector
    """Place of its middle in the link's frame [m]."""
    orientation: tuple[float, float, float, float]
    """Orientation in the link's frame, a quaternion xyzw."""
    color: tuple[int, int, int] | None = None
    """Red, green and blue, 0 to 255; None where the URDF has none."""
    mesh: str = ''
    """Name of a mesh's file, as the URDF has it."""


@dataclass(frozen=True)
class ModelLink:
    """A link, and the joint that leads to it."""

    parent: int
    """Index of its parent; -1 for the root."""
    depth: int
    """Number of joints that may move between the root and it."""
    shapes: tuple[Shape, ...]
    """Visible parts."""
    name: str = ''
    """Name of the link."""


@dataclass(frozen=True, eq=False)
class RobotModel:
    """A robot's links, each after its parent; its root comes first."""

    name: str
    """Name of the robot."""
    links: tuple[ModelLink, ...]
    """Links, the root first."""
    joint_names: tuple[str, ...]
    """Name of the joint whose measured position moves each link; empty for none."""
    origins: Array
    """Place of each link's joint in its parent's frame, shape (n, 3) [m]."""
    turns: Array
    """Orientation of each link's joint in its parent's frame at zero, quaternions xyzw (n, 4)."""
    turning_axes: Array
    """Axis of each joint that turns, else zeros, shape (n, 3)."""
    sliding_axes: Array
    """Axis of each joint that slides, else zeros, shape (n, 3)."""
    factors: Array
    """Factor and offset from a measured position to the joint's own, shape (n, 2)."""

    def poses(self, positions: Mapping[str, float]) -> tuple[Array, Array]:
        """
        Place every link in its parent's frame.

        Parameters
        ----------
        positions : mapping of str to float
            Joint positions by name [rad or m]; those that are missing are 0.

        Returns
        -------
        tuple of ndarray
            Positions, shape (n, 3) [m], and quaternions xyzw, shape (n, 4).
        """
        q = np.array([positions.get(name, 0.0) for name in self.joint_names])
        q = self.factors[:, 0] * q + self.factors[:, 1]
        half = 0.5 * q[:, None]
        turned = np.hstack([np.sin(half) * self.turning_axes, np.cos(half)])
        # A joint that does not turn has no axis, and its cosine must not count.
        turned[~self.turning_axes.any(axis=1)] = (0.0, 0.0, 0.0, 1.0)
        moved = self.origins
        if self.sliding_axes.any():
            moved = moved + rotated(self.turns, q[:, None] * self.sliding_axes)
        return moved, product(self.turns, turned)


def product(a: Array, b: Array) -> Array:
    """Multiply quaternions xyzw, shapes (..., 4): b is done first."""
    ax, ay, az, aw = np.moveaxis(a, -1, 0)
    bx, by, bz, bw = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
            aw * bw - ax * bx - ay * by - az * bz,
        ],
        axis=-1,
    )


def rotated(q: Array, v: Array) -> Array:
    """Rotate vectors, shape (..., 3), by unit quaternions xyzw, shape (..., 4)."""
    across = 2.0 * np.cross(q[..., :3], v)
    turned: Array = v + q[..., 3:] * across + np.cross(q[..., :3], across)
    return turned


def model_from_urdf(text: str) -> RobotModel:
    """
    Read a robot's visible shapes and its joints.

    Parameters
    ----------
    text : str
        A URDF.

    Returns
    -------
    RobotModel
        The model.

    Raises
    ------
    InvalidMessage
        If it is no URDF, its links form no tree, or a number is none.
    """
    if len(text) > _LONGEST_URDF:
        raise _invalid(f'it has {len(text)} characters; {_LONGEST_URDF} are the most')
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise _invalid(f'it is no XML: {error}') from error
    links = {element.get('name', ''): element for element in root.iterfind('link')}
    if root.tag != 'robot' or not 0 < len(links) <= _MOST_LINKS:
        raise _invalid(f'it has {len(links)} links below <robot>; 1 to {_MOST_LINKS} are valid')
    shapes = sum(len(link.findall('visual')) for link in links.values())
    if shapes > _MOST_SHAPES:
        raise _invalid(f'it has {shapes} visible parts; {_MOST_SHAPES} are the most')
    joints = _joints_in_order(root, links)
    colors = {
        name: color
        for material in root.iterfind('material')
        if (name := material.get('name')) and (color := _color(material)) is not None
    }
    return _assembled(root.get('name', ''), links, joints, colors)


def _joints_in_order(
    root: ElementTree.Element, links: Mapping[str, ElementTree.Element]
) -> list[tuple[str, str, ElementTree.Element | None]]:
    """List parent and child of each joint, parents first; the root has no joint."""
    below: dict[str, list[tuple[str, ElementTree.Element]]] = {}
    children = set()
    for joint in root.iterfind('joint'):
        parent, child = (_attribute(joint, end, 'link') for end in ('parent', 'child'))
        if parent not in links or child not in links or child in children:
            raise _invalid(f'joint {quoted(joint.get("name", ""))} joins no two links of a tree')
        children.add(child)
        below.setdefault(parent, []).append((child, joint))
    tops = [name for name in links if name not in children]
    if len(tops) != 1:
        raise _invalid(f'{len(tops)} of its links have no parent; one is valid')
    ordered: list[tuple[str, str, ElementTree.Element | None]] = [('', tops[0], None)]
    for _, name, _ in ordered:
        ordered += [(name, child, joint) for child, joint in below.get(name, ())]
    if len(ordered) != len(links):
        raise _invalid('its joints form a circle')
    return ordered


def _assembled(
    name: str,
    elements: Mapping[str, ElementTree.Element],
    joints: list[tuple[str, str, ElementTree.Element | None]],
    colors: Mapping[str, tuple[int, int, int]],
) -> RobotModel:
    count = len(joints)
    origins, turns = np.zeros((count, 3)), np.tile((0.0, 0.0, 0.0, 1.0), (count, 1))
    turning, sliding, factors = np.zeros((count, 3)), np.zeros((count, 3)), np.zeros((count, 2))
    links: list[ModelLink] = []
    names: list[str] = []
    place: dict[str, int] = {}
    for index, (parent, child, joint) in enumerate(joints):
        place[child] = index
        kind, moved_by = 'fixed', ''
        if joint is not None:
            kind, moved_by = joint.get('type', ''), joint.get('name', '')
            origins[index], turns[index] = _origin(joint)
            mimic = joint.find('mimic')
            factors[index] = (1.0, 0.0)
            if mimic is not None:
                moved_by = mimic.get('joint', '')
                factors[index] = (
                    _number(mimic.get('multiplier', '1')),
                    _number(mimic.get('offset', '0')),
                )
            if kind in _TURNING:
                turning[index] = _axis(joint)
            elif kind == 'prismatic':
                sliding[index] = _axis(joint)
        moves = kind in _TURNING or kind == 'prismatic'
        above = links[place[parent]] if parent else None
        depth = (above.depth if above else 0) + (1 if moves else 0)
        shapes = tuple(_shape(visual, colors) for visual in elements[child].iterfind('visual'))
        links.append(ModelLink(place[parent] if parent else -1, depth, shapes, child))
        names.append(moved_by if moves else '')
    return RobotModel(name, tuple(links), tuple(names), origins, turns, turning, sliding, factors)


def _shape(visual: ElementTree.Element, colors: Mapping[str, tuple[int, int, int]]) -> Shape:
    position, orientation = _origin(visual)
    px, py, pz = (float(v) for v in position)
    qx, qy, qz, qw = (float(v) for v in orientation)
    material = visual.find('material')
    color = None
    if material is not None:
        color = _color(material) or colors.get(material.get('name', ''))
    geometry = visual.find('geometry')
    for element in () if geometry is None else geometry:
        size, mesh = _size(element)
        if size is not None:
            return Shape(element.tag, size, (px, py, pz), (qx, qy, qz, qw), color, mesh)
    raise _invalid('a visual has no box, cylinder, sphere or mesh')


def _size(element: ElementTree.Element) -> tuple[Vector | None, str]:
    if element.tag == 'box':
        return _vector(element.get('size', '')), ''
    if element.tag == 'cylinder':
        return (_number(element.get('radius', '')), _number(element.get('length', '')), 0.0), ''
    if element.tag == 'sphere':
        return (_number(element.get('radius', '')), 0.0, 0.0), ''
    if element.tag == 'mesh':
        return _vector(element.get('scale', '1 1 1')), element.get('filename', '')
    return None, ''


def _color(material: ElementTree.Element) -> tuple[int, int, int] | None:
    element = material.find('color')
    if element is None:
        return None
    parts = [_number(part) for part in element.get('rgba', '').split()]
    if len(parts) != 4:
        raise _invalid(f'the color {quoted(element.get("rgba", ""))} has no four numbers')
    red, green, blue = (round(255.0 * min(max(part, 0.0), 1.0)) for part in parts[:3])
    return red, green, blue


def _origin(element: ElementTree.Element) -> tuple[Array, Array]:
    """Read place and orientation of a joint or a shape."""
    origin = element.find('origin')
    if origin is None:
        return np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    roll, pitch, yaw = (0.5 * angle for angle in _vector(origin.get('rpy', '0 0 0')))
    x = np.array([math.sin(roll), 0.0, 0.0, math.cos(roll)])
    y = np.array([0.0, math.sin(pitch), 0.0, math.cos(pitch)])
    z = np.array([0.0, 0.0, math.sin(yaw), math.cos(yaw)])
    return np.array(_vector(origin.get('xyz', '0 0 0'))), product(z, product(y, x))


def _axis(joint: ElementTree.Element) -> Array:
    element = joint.find('axis')
    axis = np.array(_vector('1 0 0' if element is None else element.get('xyz', '1 0 0')))
    length = float(np.linalg.norm(axis))
    if not length > 0.0:
        raise _invalid(f'joint {quoted(joint.get("name", ""))} has an axis of no direction')
    return axis / length


def _vector(text: str) -> Vector:
    numbers = [_number(part) for part in text.split()]
    if len(numbers) != 3:
        raise _invalid(f'{quoted(text)} are not three numbers')
    return numbers[0], numbers[1], numbers[2]


def _number(text: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise _invalid(f'{quoted(text)} is no number')
    return number


def _attribute(element: ElementTree.Element, tag: str, name: str) -> str:
    found = element.find(tag)
    return '' if found is None else found.get(name, '')


def _invalid(reason: str) -> InvalidMessage:
    return InvalidMessage('robot description', reason)
