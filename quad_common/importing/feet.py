"""
Where a leg's foot is: a ball at its end, or the point that is farthest from the knee.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.description.shapes import Points, points_of
from quad_common.description.tree import KinematicTree
from quad_common.errors import LegNotFeasible
from quad_common.importing.chains import LegChain
from quad_common.importing.options import Notes

Array = NDArray[np.float64]

_PREFERRED = 0.1
"""Fraction of its distance by which a ball may be nearer to the knee than another shape."""

_THIN = 0.04
"""Radius of a foot without a ball, as a fraction of the calf's length."""

_TIP = 0.05
"""Fraction of the calf's length within which points are one tip."""


@dataclass(frozen=True, eq=False)
class Foot:
    """The end of a leg at the zero of all joints."""

    center: Array
    """Center of the foot's ball in the root's frame, shape (3,) [m]."""
    radius: float
    """Radius of that ball [m]."""
    link: str
    """Name of the link that it belongs to."""


def find_foot(tree: KinematicTree, leg: LegChain, knee: Array, axis: Array, notes: Notes) -> Foot:
    """
    Find a leg's foot.

    Parameters
    ----------
    tree : KinematicTree
        The description.
    leg : LegChain
        The leg.
    knee, axis : ndarray, shape (3,)
        A point of the knee's axis and its direction, in the root's frame.
    notes : Notes
        What is assumed is added to it.

    Raises
    ------
    LegNotFeasible
        If nothing is at the leg's end: neither a shape nor a fixed link.
    """
    links = tree.rigid_group(leg.links[-1])
    shapes = list(points_of(tree, links))
    if not shapes:
        return _end_of_links(tree, links, knee, axis, notes)
    reaches = [float(_distances(shape, knee, axis).max()) + shape.radius for shape in shapes]
    farthest = max(reaches)
    balls = [k for k, shape in enumerate(shapes) if shape.kind == 'sphere']
    ball = max(balls, key=lambda k: reaches[k], default=None)
    if ball is not None and reaches[ball] > (1.0 - _PREFERRED) * farthest:
        return Foot(shapes[ball].places[0], shapes[ball].radius, shapes[ball].link)
    shape = shapes[int(np.argmax(reaches))]
    distances = _distances(shape, knee, axis)
    length = float(distances.max())
    if length <= 0.0:
        raise LegNotFeasible(tree.path, leg.joints[0].name, 'has no end away from its knee')
    tip = shape.places[distances > (1.0 - _TIP) * length].mean(axis=0)
    outward = tip - knee - axis * float((tip - knee) @ axis)
    outward /= np.linalg.norm(outward)
    radius = _THIN * length
    end = tip + outward * (length - float((tip - knee) @ outward))
    notes.assume(
        f"no ball is at the legs' ends: feet of {1e3 * radius:.0f} mm radius are assumed there"
    )
    return Foot(end - radius * outward, radius, shape.link)


def _end_of_links(
    tree: KinematicTree, links: list[str], knee: Array, axis: Array, notes: Notes
) -> Foot:
    """Take the frame of a fixed link at the end of a leg without shapes."""
    places = np.array([tree.pose(link)[:3, 3] for link in links])
    distances = _distances(Points('link', '', places, 0.0), knee, axis)
    last = int(np.argmax(distances))
    length = float(distances[last])
    if length < 1e-3:
        raise LegNotFeasible(tree.path, links[0], 'has no shape and no link at its end: no foot')
    radius = _THIN * length
    notes.assume(
        f'calves have no shapes: the feet are where {links[last]} is, {1e3 * radius:.0f} mm thick'
    )
    return Foot(places[last], radius, links[last])


def _distances(shape: Points, knee: Array, axis: Array) -> Array:
    """Return the distances of a shape's points from the knee's axis, shape (n,) [m]."""
    distances: Array = np.linalg.norm(np.cross(shape.places - knee, axis), axis=1)
    return distances
