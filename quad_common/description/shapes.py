"""
Shapes of links as points with a radius: enough to find feet, sizes and thicknesses.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.description.meshes import mesh_corners
from quad_common.description.poses import moved, pose_of
from quad_common.description.shape_sizes import in_three
from quad_common.description.tree import KinematicTree

Array = NDArray[np.float64]

_ROUND = 24
"""Number of points on the rim of a cylinder."""


@dataclass(frozen=True, eq=False)
class Points:
    """Points on the surface of a shape, or the centers of balls."""

    kind: str
    """Kind of the shape: box, cylinder, sphere or mesh."""
    link: str
    """Name of the link."""
    places: Array
    """Places in the root's frame, shape (n, 3) [m]."""
    radius: float
    """Radius of the balls around the places, 0 for points on a surface [m]."""


def points_of(tree: KinematicTree, links: Iterable[str]) -> Iterator[Points]:
    """Yield the shapes of links: what they collide with, or what is seen of them if nothing is."""
    links = list(links)
    for use in ('collisions', 'visuals'):
        shapes = [(link, shape) for link in links for shape in getattr(tree.links[link], use)]
        shapes = [(link, shape) for link, shape in shapes if shape.geometry is not None]
        if shapes:
            for link, shape in shapes:
                pose = tree.pose(link) @ pose_of(shape.origin)
                kind, places, radius = _sampled(shape.geometry, tree)
                yield Points(kind, link, moved(pose, places), radius)
            return


def _sampled(geometry: Any, tree: KinematicTree) -> tuple[str, Array, float]:
    if geometry.sphere is not None:
        return 'sphere', np.zeros((1, 3)), float(geometry.sphere.radius)
    if geometry.box is not None:
        half = in_three(geometry.box.size) / 2.0
        return 'box', np.array(list(product((-1.0, 1.0), repeat=3))) * half, 0.0
    if geometry.cylinder is not None:
        turn = np.linspace(0.0, 2.0 * np.pi, _ROUND, endpoint=False)
        ring = geometry.cylinder.radius * np.column_stack([np.cos(turn), np.sin(turn)])
        half_length = geometry.cylinder.length / 2.0
        ends = [np.column_stack([ring, np.full(_ROUND, z)]) for z in (-half_length, half_length)]
        return 'cylinder', np.concatenate(ends), 0.0
    return 'mesh', mesh_corners(geometry.mesh, tree.path, tree.meshes), 0.0
