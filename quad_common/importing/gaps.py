"""
Gaps that descriptions have: masses that none states, and meshes of what the body carries.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import yourdfpy
from numpy.typing import NDArray

from quad_common.description.mass import box_inertia, total
from quad_common.description.meshes import mesh_path
from quad_common.description.poses import inverse, moved
from quad_common.description.shapes import points_of
from quad_common.description.tree import KinematicTree
from quad_common.errors import DescriptionEntryInvalid, MassesMissing, MeshNotFound
from quad_common.importing.chains import LegChain
from quad_common.importing.options import Notes

Array = NDArray[np.float64]

_Box = tuple[Array, Array]
"""Center and size, shape (3,) each [m]."""

LIGHTEST = 1e-3
"""Least mass of a part that physics can move [kg]."""

_SMALLEST = 0.01
"""Least side of a box around shapes [m]."""

_LEAST_PART = 0.01
"""Least fraction of the missing mass that a part gets: flat shapes have no volume."""

_WITHOUT_SHAPE = 0.05
"""Side of the box that stands for a part without shapes, as a fraction of the robot's extent."""


def fill_masses(
    tree: KinematicTree, parts: Mapping[str, Sequence[str]], mass: float, notes: Notes
) -> None:
    """
    Give parts without mass what is missing of the robot's, by the volumes of their shapes.

    Parameters
    ----------
    tree : KinematicTree
        The description; links without mass get one.
    parts : mapping of str to sequence of str
        Links of each part, by the part's name.
    mass : float
        Mass of the whole robot [kg]; 0 if nobody said.
    notes : Notes
        What is assumed is added to it.

    Raises
    ------
    MassesMissing
        If parts have no mass and the robot's is not given, or is no more than what is stated.
    DescriptionEntryInvalid
        If no part has mass or shape, or none is without mass though one is given.
    """
    stated = {name: total(map(tree.mass_of, links)).amount for name, links in parts.items()}
    lacking = [name for name, amount in stated.items() if amount < LIGHTEST]
    if not lacking:
        if mass:
            problem = (
                f'states all masses, {sum(stated.values()):.3g} kg: --mass is for those without'
            )
            raise DescriptionEntryInvalid(tree.path, 'the description', problem)
        return
    missing = mass - sum(stated.values())
    if missing < LIGHTEST * len(lacking):
        of_parts = max(stated[name] for name in lacking)
        whole = sum(stated.values())
        raise MassesMissing(tree.path, tuple(lacking), whole, mass, of_parts, LIGHTEST)
    boxes = {name: _boxes(tree, parts[name]) for name in lacking}
    volumes = {name: sum(map(_volume, own.values())) for name, own in boxes.items()}
    if not any(volumes.values()):
        problem = 'has no mass, and parts without mass have no shape that it could be spread over'
        raise DescriptionEntryInvalid(tree.path, f"link '{lacking[0]}'", problem)
    least = _LEAST_PART * sum(volumes.values())
    counted = {name: max(volume, least) for name, volume in volumes.items()}
    side = _WITHOUT_SHAPE * max(
        float(np.linalg.norm(tree.pose(link)[:3, 3])) for link in tree.links
    )
    for name, own in boxes.items():
        amount = missing * counted[name] / sum(counted.values())
        own = own or {name: (np.zeros(3), np.full(3, side))}
        whole = sum(map(_volume, own.values()))
        for link, (center, size) in own.items():
            _set_mass(tree.links[link], amount * _volume((center, size)) / whole, center, size)
    count = (
        f'{len(lacking)} of {len(parts)} parts have no'
        if len(lacking) < len(parts)
        else 'no part has a'
    )
    notes.assume(f'{count} mass: {missing:.3g} kg are spread over the boxes around shapes')


def _set_mass(link: Any, amount: float, center: Array, size: Array) -> None:
    """Give a link the mass of a homogeneous box [kg], [m]."""
    origin = np.eye(4)
    origin[:3, 3] = center
    link.inertial = yourdfpy.urdf.Inertial(
        origin=origin, mass=amount, inertia=box_inertia(amount, size)
    )


def _volume(box: _Box) -> float:
    return float(np.prod(box[1]))


def _boxes(tree: KinematicTree, links: Sequence[str]) -> dict[str, _Box]:
    """Return center and size of the boxes around links' shapes, in the links' frames [m]."""
    found = {}
    for link in links:
        back = inverse(tree.pose(link))
        shapes = [(moved(back, s.places), s.radius) for s in points_of(tree, [link])]
        if shapes:
            low = np.min([(places - r).min(axis=0) for places, r in shapes], axis=0)
            high = np.max([(places + r).max(axis=0) for places, r in shapes], axis=0)
            found[link] = (0.5 * (low + high), np.maximum(high - low, _SMALLEST))
    return found


def leave_out_missing(tree: KinematicTree, legs: list[LegChain], notes: Notes) -> None:
    """
    Take away shapes of the body whose meshes are nowhere, if it has others to collide with.

    Cameras and the like come from packages of their own, which often are not installed. Of legs
    every shape counts: feet are found by them.

    Parameters
    ----------
    tree : KinematicTree
        The description; links of the body lose the shapes.
    legs : list of LegChain
        The four legs.
    notes : Notes
        What is left out is added to it.
    """
    of_legs = {link for leg in legs for link in tree.below(leg.links[0])}
    body = [link for name, link in tree.links.items() if name not in of_legs]
    shapes = [(link, shape, _is_there(shape, tree)) for link in body for shape in link.collisions]
    if not any(is_there for _, _, is_there in shapes):
        return
    for link, shape, is_there in shapes:
        if not is_there:
            link.collisions = [other for other in link.collisions if other is not shape]
            name = shape.geometry.mesh.filename
            notes.assume(f"what '{link.name}' collides with is left out: there is no mesh {name}")


def _is_there(shape: Any, tree: KinematicTree) -> bool:
    if shape.geometry is None or shape.geometry.mesh is None:
        return True
    try:
        mesh_path(shape.geometry.mesh.filename, tree.path)
    except MeshNotFound:
        return False
    return True
