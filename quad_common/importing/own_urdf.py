"""
Writes the robot's own URDF as physics need it: its links, joints, meshes, masses and shapes.

What moves as one is one link, named as in the description, so that frames without mass do not
get one; feet that are links of their own stay so, for contacts to be told apart. The root has
base_link's frame. Other joints are held at 0, and inertias are possible.
"""

from __future__ import annotations

from collections.abc import Iterable
from copy import deepcopy
from pathlib import Path
from typing import Any

import numpy as np
import yourdfpy
from lxml import etree
from numpy.typing import NDArray

from quad_common.description.mass import Mass
from quad_common.description.mesh_files import READ_BY_ALL
from quad_common.description.meshes import convert_mesh, is_elsewhere, mesh_corners, mesh_path
from quad_common.description.poses import inverse, pose_of
from quad_common.description.shape_sizes import THINNEST, in_three, sizes_of, thin_box
from quad_common.description.tree import KinematicTree
from quad_common.errors import DescriptionEntryInvalid, DescriptionUnusable, MeshNotFound
from quad_common.errors.quoting import quoted
from quad_common.files.bounded_file import make_folder
from quad_common.importing.masses import Part
from quad_common.importing.robot_import import ImportedRobot

Array = NDArray[np.float64]

_FOOT = 0.02
"""Mass of a foot that has none of its own, as a fraction of its calf's; taken from that."""


def own_urdf(robot: ImportedRobot, meshes: Path) -> str:
    """
    Write a robot's own URDF.

    Parameters
    ----------
    robot : ImportedRobot
        The robot.
    meshes : Path
        Folder for meshes that not all engines read, made if there are any: they are converted.

    Returns
    -------
    str
        The XML text. Meshes have absolute paths; what is seen of a link whose mesh is missing is
        left out.
    """
    model = yourdfpy.urdf
    base_from_root = inverse(robot.to_base)
    body = robot.parts.body
    shapes = _Shapes(robot, meshes)
    links = [_link(shapes, body.link, body.links, base_from_root, body.mass)]
    joints = []
    for k, (chain, parts, foot) in enumerate(zip(robot.chains, robot.parts.legs, robot.feet)):
        parent, parent_frame = body.link, base_from_root
        for j, (joint, part) in enumerate(zip(chain.joints, parts)):
            frame = robot.tree.pose(joint.child)
            if j == 2 and foot.link != part.link:
                links += _calf_and_foot(shapes, part, foot.link)
            else:
                links.append(_link(shapes, part.link, part.links, frame, part.mass))
            made = _joint(
                joint.name, 'revolute', (parent, part.link), inverse(parent_frame) @ frame
            )
            made.axis = joint.axis
            made.limit = model.Limit(
                effort=float(robot.effort[k, j]),
                velocity=float(robot.velocity[k, j]),
                lower=float(robot.legs[k].lower[j]),
                upper=float(robot.legs[k].upper[j]),
            )
            joints.append(made)
            parent, parent_frame = part.link, frame
        if foot.link != parent:
            origin = inverse(parent_frame) @ robot.tree.pose(foot.link)
            joints.append(_joint(f'{foot.link}_fixed', 'fixed', (parent, foot.link), origin))
    described = model.Robot(
        name=robot.name, links=links, joints=joints, materials=robot.tree.materials
    )
    written = yourdfpy.URDF(described, build_scene_graph=False, load_meshes=False).write_xml()
    text: bytes = etree.tostring(written, pretty_print=True)
    return text.decode()


def _joint(name: str, kind: str, links: tuple[str, str], origin: Array) -> Any:
    """Make a joint of a kind between a parent and its child, whose frame is in the parent's."""
    parent, child = links
    return yourdfpy.urdf.Joint(name=name, type=kind, parent=parent, child=child, origin=origin)


def _calf_and_foot(shapes: _Shapes, part: Part, foot: str) -> list[Any]:
    """Make two links of a calf: the foot's link with what it carries, and the rest."""
    robot, tree = shapes.robot, shapes.robot.tree
    of_foot = set(tree.rigid_group(foot))
    foot_links = [link for link in part.links if link in of_foot]
    rest = [link for link in part.links if link not in of_foot]
    foot_mass = _sum(tree, foot_links, part)
    least = _FOOT * part.mass.amount
    if foot_mass.amount < 1e-3 * part.mass.amount:
        radius = robot.foot_radius
        center = next(own.center for own in robot.feet if own.link == foot)
        foot_mass = Mass(least, center, 0.4 * least * radius**2 * np.eye(3))
    calf_mass = _difference(part.mass, foot_mass)
    return [
        _link(shapes, part.link, rest, tree.pose(part.link), calf_mass),
        _link(shapes, foot, foot_links, tree.pose(foot), foot_mass),
    ]


def _sum(tree: KinematicTree, links: Iterable[str], part: Part) -> Mass:
    """Return the mass of a foot; its inertia is a ball's of that mass if it is none."""
    masses = [tree.mass_of(link) for link in links]
    amount = sum(mass.amount for mass in masses)
    if amount == 0.0:
        return masses[0]
    center = sum((mass.amount * mass.center for mass in masses), np.zeros(3)) / amount
    inertia = sum((mass.inertia for mass in masses), np.zeros((3, 3)))
    found = Mass(amount, center, inertia)
    if found.is_possible:
        return found
    radius = 0.1 * float(np.linalg.norm(part.mass.center - center)) + 1e-3
    return Mass(amount, center, 0.4 * amount * radius**2 * np.eye(3))


def _difference(whole: Mass, part: Mass) -> Mass:
    """Take a part of a mass away; what is left keeps an inertia that is possible."""
    amount = whole.amount - part.amount
    center = (whole.amount * whole.center - part.amount * part.center) / amount
    inertia = whole.inertia.copy()
    for sign, mass in ((1.0, whole), (-1.0, part), (-1.0, Mass(amount, center, np.zeros((3, 3))))):
        arm = mass.center - whole.center
        if mass is not whole:
            inertia += sign * mass.amount * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    inertia -= part.inertia
    left = Mass(amount, center, inertia)
    return left if left.is_possible else Mass(amount, center, whole.inertia * amount / whole.amount)


def _link(shapes: _Shapes, name: str, links: Iterable[str], frame: Array, mass: Mass) -> Any:
    """Make one link of several, in a frame that the root's frame places."""
    model, into = yourdfpy.urdf, inverse(frame)
    own = mass.moved(into)
    origin = np.eye(4)
    origin[:3, 3] = own.center
    inertial = model.Inertial(origin=origin, mass=own.amount, inertia=own.inertia)
    made = model.Link(name=name, inertial=inertial)
    for link in links:
        made.visuals += shapes.of_link(link, 'visuals', into)
        made.collisions += shapes.of_link(link, 'collisions', into)
    return made


class _Shapes:
    """
    The shapes of a robot's links, with meshes that engines find and read.

    Parameters
    ----------
    robot : ImportedRobot
        The robot.
    meshes : Path
        Folder for meshes that are converted.
    """

    def __init__(self, robot: ImportedRobot, meshes: Path) -> None:
        self.robot = robot
        self._folder = meshes
        self._converted: dict[Path, Path] = {}
        self._boxes: dict[tuple[str, str], tuple[Array, Array] | None] = {}

    def of_link(self, link: str, use: str, into: Array) -> list[Any]:
        """Return a link's ``visuals`` or ``collisions``, in the frame to which ``into`` takes."""
        tree = self.robot.tree
        found = []
        for shape in getattr(tree.links[link], use):
            placed = deepcopy(shape)
            placed.origin = into @ tree.pose(link) @ pose_of(shape.origin)
            if not self._has_extent(placed.geometry) or not self._has_mesh(placed, use, link):
                continue
            # Names are free in URDF, but engines want different ones.
            placed.name = None
            found.append(placed)
        return found

    def _has_extent(self, geometry: Any) -> bool:
        """Whether a shape is any: dummies have sizes of 0, which engines refuse."""
        if geometry is None:
            return False
        sizes = sizes_of(geometry)
        if geometry.box:
            geometry.box.size = in_three(geometry.box.size)
        if (sizes == 0.0).any():
            return False
        if (sizes < THINNEST).any():
            self.robot.notes.assume(
                f'shapes that are thinner than {1e3 * THINNEST:g} mm are left out'
            )
            return False
        return True

    def _has_mesh(self, shape: Any, use: str, link: str) -> bool:
        """Give a mesh its absolute path, a flat one a box; return whether the shape can be had."""
        mesh = shape.geometry.mesh
        if mesh is None:
            return True
        tree, notes = self.robot.tree, self.robot.notes
        try:
            box = self._thin_box(mesh)
            path = mesh_path(mesh.filename, tree.path)
            if box is None and path.suffix.lower() not in READ_BY_ALL:
                path = self._converted_mesh(path)
        except (MeshNotFound, DescriptionUnusable):
            if use == 'collisions':
                raise
            notes.assume('meshes that are only looked at are missing or unreadable')
            return False
        if box is not None:
            if use == 'collisions':
                self._make_box(shape, link, *box)
                return True
            notes.assume('meshes that are only looked at and have no volume are left out')
            return False
        if is_elsewhere(mesh.filename, tree.path):
            notes.assume(
                'meshes are not where the description says; those around it whose paths end alike '
                'are taken'
            )
        mesh.filename = str(path)
        return True

    def _thin_box(self, mesh: Any) -> tuple[Array, Array] | None:
        """Return the box of a mesh without volume; None if it has one."""
        key = mesh.filename, str(mesh.scale)
        if key not in self._boxes:
            tree = self.robot.tree
            self._boxes[key] = thin_box(mesh_corners(mesh, tree.path, tree.meshes))
        return self._boxes[key]

    def _make_box(self, shape: Any, link: str, pose: Array, size: Array) -> None:
        """Have a thin box stand for a flat mesh that a link collides with."""
        name = shape.geometry.mesh.filename
        if size[1] == 0.0:
            problem = (
                f'collides with the mesh {quoted(name)}, whose corners, with its scale, are on one '
                'line; it must have a volume'
            )
            raise DescriptionEntryInvalid(self.robot.tree.path, f"link '{link}'", problem)
        self.robot.notes.assume(
            f'a box {1e3 * size[2]:g} mm thick stands for the flat mesh {quoted(name)} that '
            f"'{link}' collides with"
        )
        shape.origin = shape.origin @ pose
        shape.geometry = yourdfpy.urdf.Geometry(box=yourdfpy.urdf.Box(size))

    def _converted_mesh(self, path: Path) -> Path:
        """Write a mesh as one that all engines read, once."""
        if path not in self._converted:
            make_folder(self._folder)
            count = len(self._converted)
            target = self._folder.resolve() / f'{path.stem}_{count}.obj'
            tree = self.robot.tree
            convert_mesh(path, target, tree.path, tree.meshes)
            self._converted[path] = target
        return self._converted[path]
