"""
Where a leg's foot is: a ball at its end, the rounding of its end, or the point farthest away.
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

_ROUNDING = np.radians(np.linspace(-50.0, 50.0, 21))
"""Directions about the leg's own in which its end meets the ground [rad]."""

_UNROUND = 0.06
"""Fraction of its radius by which a round end may differ from a circle."""

_THICKEST = 0.25
"""Largest radius of a round end, as a fraction of the calf's length."""


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
    end = tip + outward * (length - float((tip - knee) @ outward))
    found = _rounding(shape, end, np.array([outward, np.cross(axis, outward)]))
    if found is not None and _THIN * length <= found[1] <= _THICKEST * length:
        center, radius = found
        notes.assume(
            f"no ball is at the legs' ends: they are round, of {1e3 * radius:.0f} mm radius"
        )
        return Foot(center, radius, shape.link)
    radius = _THIN * length
    notes.assume(
        f"no ball is at the legs' ends: feet of {1e3 * radius:.0f} mm radius are assumed there"
    )
    return Foot(end - radius * outward, radius, shape.link)


def _rounding(shape: Points, end: Array, plane: Array) -> tuple[Array, float] | None:
    """
    Fit a circle to a leg's end where it meets the ground, in the plane in which the leg moves.

    In a direction d a shape reaches as far as h(d) = max p d over its points p; a circle about c
    with the radius r reaches c d + r. That is linear in c and r: least squares over directions.

    Parameters
    ----------
    shape : Points
        Shape at the leg's end.
    end : ndarray, shape (3,)
        A point of the end, in the root's frame [m].
    plane : ndarray, shape (2, 3)
        Direction of the leg, and the one across it in its plane.

    Returns
    -------
    center, radius
        [m]; None if the end is not round.
    """
    directions = np.column_stack([np.cos(_ROUNDING), np.sin(_ROUNDING)])
    places = (shape.places - end) @ plane.T
    reaches = (places @ directions.T).max(axis=0) + shape.radius
    terms = np.column_stack([directions, np.ones(len(directions))])
    solution = np.linalg.lstsq(terms, reaches, rcond=None)[0]
    radius = float(solution[2])
    if radius <= 0.0 or np.abs(terms @ solution - reaches).max() > _UNROUND * radius:
        return None
    return end + solution[:2] @ plane, radius


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
