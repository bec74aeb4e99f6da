"""
A robot's links and joints as a tree: places, masses and shapes at the zero of all joints.

Poses are homogeneous matrices, shape (4, 4); unless something else is said they place a thing in
the frame of the tree's root link with every joint at 0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from quad_common.description.mass import Mass, no_mass
from quad_common.description.meshes import files_of
from quad_common.description.poses import pose_of
from quad_common.description.shape_sizes import LARGEST, size_problem
from quad_common.errors import DescriptionEntryInvalid, DescriptionUnusable

Array = NDArray[np.float64]

TURNING = ('revolute', 'continuous')
"""Kinds of joints that turn about an axis."""

_KINDS = (*TURNING, 'prismatic', 'fixed', 'floating', 'planar')

_SHORTEST_AXIS = 1e-6

_HEAVIEST = 1e4
"""Largest mass of a link [kg], and its largest moment of inertia [kg m^2]."""


@dataclass(frozen=True, eq=False)
class TreeJoint:
    """A joint between two links."""

    name: str
    """Name of the joint."""
    kind: str
    """Kind, as URDF names it."""
    parent: str
    """Name of the link that carries the joint."""
    child: str
    """Name of the link that the joint moves."""
    origin: Array
    """Pose of the child's frame in the parent's at 0, shape (4, 4)."""
    axis: Array
    """Axis in the child's frame, a unit vector, shape (3,)."""
    lower: float
    """Lower limit, minus infinity without one [rad]."""
    upper: float
    """Upper limit, infinity without one [rad]."""
    effort: float | None
    """Largest torque that is stated [N m]."""
    velocity: float | None
    """Largest speed that is stated [rad/s]."""
    follows: str = ''
    """Name of the joint that it follows, without a motor of its own; empty if it follows none."""

    @property
    def moves(self) -> bool:
        """Whether the joint lets its links move against each other."""
        return self.kind != 'fixed'


class KinematicTree:
    """
    The tree of a robot's links.

    Parameters
    ----------
    robot : yourdfpy.Robot
        What a description says.
    path : Path
        The description, for the sentences of errors.

    Raises
    ------
    DescriptionError
        If the links are no tree, or a number is none.
    """

    def __init__(self, robot: Any, path: Path) -> None:
        self.path = path
        self.materials: list[Any] = list(robot.materials)
        """Colors that links name."""
        self.links: dict[str, Any] = {}
        for link in robot.links:
            if link.name in self.links:
                raise self._invalid('link', link.name, 'is there twice')
            self.links[link.name] = link
        self.joints: dict[str, TreeJoint] = {}
        self.parents: dict[str, TreeJoint] = {}
        self.children: dict[str, list[TreeJoint]] = {name: [] for name in self.links}
        for given in robot.joints:
            joint = self._joint(given)
            if joint.name in self.joints:
                raise self._invalid('joint', joint.name, 'is there twice')
            if joint.child in self.parents:
                other = self.parents[joint.child].name
                raise self._invalid(
                    'link', joint.child, f"hangs at two joints, '{other}' and '{joint.name}'"
                )
            self.joints[joint.name] = joint
            self.parents[joint.child] = joint
            self.children[joint.parent].append(joint)
        self.root = self._only_root()
        shapes = [s for link in robot.links for s in (*link.collisions, *link.visuals)]
        meshes = [s.geometry.mesh for s in shapes if s.geometry is not None and s.geometry.mesh]
        self.meshes = files_of(sorted({mesh.filename for mesh in meshes}), path)
        """Files of the meshes that links name."""

    def chain(self, link: str) -> list[TreeJoint]:
        """List the joints between the root and a link, from the root on."""
        joints = []
        while link in self.parents:
            joints.append(self.parents[link])
            link = joints[-1].parent
        return joints[::-1]

    def pose(self, link: str, angles: Mapping[str, float] | None = None) -> Array:
        """Place a link's frame in the root's, shape (4, 4); joints are at 0 unless given [rad]."""
        if not angles:
            return self._at_zero[link]
        pose: Array = np.eye(4)
        for joint in self.chain(link):
            pose = pose @ joint.origin
            if angle := angles.get(joint.name):
                turn = np.eye(4)
                turn[:3, :3] = Rotation.from_rotvec(angle * joint.axis).as_matrix()
                pose = pose @ turn
        return pose

    def rigid_group(self, link: str) -> list[str]:
        """List a link, and the links below it that cannot move against it."""
        return self._from(link, lambda joint: not joint.moves)

    def below(self, link: str) -> list[str]:
        """List a link and all links below it, whatever joints are between them."""
        return self._from(link, lambda joint: True)

    def _from(self, link: str, is_passed: Callable[[TreeJoint], bool]) -> list[str]:
        """List a link, and those below it along some joints, a branch after the other."""
        found, waiting = [], [link]
        while waiting:
            found.append(waiting.pop())
            passed = [joint.child for joint in self.children[found[-1]] if is_passed(joint)]
            waiting += reversed(passed)
        return found

    def mass_of(self, link: str) -> Mass:
        """Return the mass of one link, in the root's frame."""
        inertial = self.links[link].inertial
        if inertial is None or not inertial.mass:
            return no_mass()
        moments = np.zeros((3, 3)) if inertial.inertia is None else np.array(inertial.inertia)
        own = Mass(float(inertial.mass), np.zeros(3), moments)
        return own.moved(self.pose(link) @ pose_of(inertial.origin))

    def _joint(self, given: Any) -> TreeJoint:
        name = str(given.name)
        for link in (given.parent, given.child):
            if link not in self.links:
                raise self._invalid('joint', name, f"names the link '{link}', which is not there")
        if given.type not in _KINDS:
            raise self._invalid('joint', name, f"is of the kind '{given.type}'")
        axis = np.array([1.0, 0.0, 0.0] if given.axis is None else given.axis, dtype=float)
        length = float(np.linalg.norm(axis)) if axis.shape == (3,) else math.nan
        if given.type == 'fixed':
            # Exporters write axes of 0 there, which mean nothing.
            axis, length = np.array([1.0, 0.0, 0.0]), 1.0
        if not _SHORTEST_AXIS < length < LARGEST:
            raise self._invalid('joint', name, f'has the axis {given.axis}')
        limit = given.limit
        has_range = given.type == 'revolute' and limit is not None
        lower = limit.lower if has_range and limit.lower is not None else -math.inf
        upper = limit.upper if has_range and limit.upper is not None else math.inf
        if not lower <= upper:
            raise self._invalid('joint', name, f'has the range {lower} to {upper}')
        if lower == upper:
            if lower != 0.0:
                raise self._invalid('joint', name, f'is fixed at {lower:g} rad by its limits')
            # Exporters write 0 to 0 where nobody said anything.
            lower, upper = -math.inf, math.inf
        return TreeJoint(
            name=name,
            kind=given.type,
            parent=given.parent,
            child=given.child,
            origin=self._checked('joint', name, pose_of(given.origin)),
            axis=axis / length,
            lower=float(lower),
            upper=float(upper),
            effort=None if limit is None else _stated(limit.effort),
            velocity=None if limit is None else _stated(limit.velocity),
            follows='' if given.mimic is None else str(given.mimic.joint),
        )

    def _checked(self, kind: str, name: str, pose: Array) -> Array:
        if not (np.isfinite(pose).all() and np.abs(pose).max() <= LARGEST):
            raise self._invalid(kind, name, 'has an origin that is no place')
        return pose

    def _only_root(self) -> str:
        roots = [name for name in self.links if name not in self.parents]
        if len(roots) != 1:
            named = ', '.join(f"'{name}'" for name in roots[:4]) or 'none'
            raise DescriptionUnusable(
                self.path, f'the links are no tree: {len(roots)} of them hang at no joint ({named})'
            )
        for name, link in self.links.items():
            self._check_link(name, link)
        reached = set(self.below(roots[0]))
        lost = [name for name in self.links if name not in reached]
        if lost:
            raise DescriptionUnusable(
                self.path, f"the links are no tree: '{lost[0]}' hangs at itself"
            )
        return roots[0]

    def _check_link(self, name: str, link: Any) -> None:
        inertial = link.inertial
        if inertial is not None:
            self._checked('link', name, pose_of(inertial.origin))
            mass = float(inertial.mass or 0.0)
            moments = np.zeros(9) if inertial.inertia is None else np.ravel(inertial.inertia)
            if not 0.0 <= mass <= _HEAVIEST:
                raise self._invalid('link', name, f'has the mass {mass:g} kg')
            if not (np.isfinite(moments).all() and np.abs(moments).max() <= _HEAVIEST):
                raise self._invalid('link', name, 'has an inertia that is no number')
        for shape in (*link.collisions, *link.visuals):
            self._checked('link', name, pose_of(shape.origin))
            if problem := size_problem(shape.geometry):
                raise self._invalid('link', name, problem)

    @cached_property
    def _at_zero(self) -> dict[str, Array]:
        poses = {self.root: np.eye(4)}
        waiting = [self.root]
        while waiting:
            link = waiting.pop()
            for joint in self.children[link]:
                poses[joint.child] = poses[link] @ joint.origin
                waiting.append(joint.child)
        return poses

    def _invalid(self, kind: str, name: str, problem: str) -> DescriptionEntryInvalid:
        return DescriptionEntryInvalid(self.path, f"{kind} '{name}'", problem)


def _stated(figure: float | None) -> float | None:
    """Return a largest effort or speed if it is one; exporters write 0 for want of another."""
    return float(figure) if figure is not None and 0.0 < figure < math.inf else None
