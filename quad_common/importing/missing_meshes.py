"""
Meshes that are not there, of what a robot's body carries.
"""

from __future__ import annotations

from typing import Any

from quad_common.description.meshes import mesh_path
from quad_common.description.tree import KinematicTree
from quad_common.errors import MeshNotFound
from quad_common.importing.chains import LegChain
from quad_common.importing.options import Notes


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
