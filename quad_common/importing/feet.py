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

_WIDE, _NARROW = (np.radians(np.linspace(-half, half, 21)) for half in (50.0, 30.0))
"""Directions in which a leg's end meets the ground, about the leg's own while its stance is not
known, then about the vertical [rad]."""

_UNROUND = 0.06
"""Fraction of its radius by which a round end may differ from a circle."""

_THINNEST, _THICKEST = 0.005, 0.25
"""Least and largest radius of an end, as a fraction of the calf's length: corners are points."""


@dataclass(frozen=True, eq=False)
class Foot:
    """The end of a leg at the zero of all joints."""

    center: Array
    """Center of the foot's ball in the root's frame, shape (3,) [m]."""
    radius: float
    """Radius of that ball [m]."""
    link: str
    """Name of the link that it belongs to."""
    end: Points | None = None
    """Shape at the leg's end; None of a ball, and of an end without shape."""


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
    plane = np.array([outward, np.cross(axis, outward)])
    center, radius, error = _rounding(shape, end, plane, _WIDE)
    if not (_THIN * length <= radius <= _THICKEST * length and error <= _UNROUND * radius):
        radius = _THIN * length
        center = end - radius * outward
    return Foot(center, radius, shape.link, shape)


def foot_on_ground(foot: Foot, knee: Array, axis: Array, down: Array, notes: Notes) -> Foot:
    """
    Find how a leg's end meets the ground, where the leg's stance is known.

    Parameters
    ----------
    foot : Foot
        The foot, as found without its stance.
    knee, axis : ndarray, shape (3,)
        As of :func:`find_foot`.
    down : ndarray, shape (3,)
        Direction downward in the stance, as the calf at the zero of all joints has it, in the
        root's frame.
    notes : Notes
        What is assumed is added to it.

    Returns
    -------
    Foot
        A ball as it is; of another end the circle on which it rolls.
    """
    if foot.end is None:
        return foot
    across = down - axis * float(down @ axis)
    across /= np.linalg.norm(across)
    length = float(_distances(foot.end, knee, axis).max())
    plane = np.array([across, np.cross(axis, across)])
    center, radius, error = _rounding(foot.end, foot.center, plane, _NARROW)
    least, most = _THINNEST * length, _THICKEST * length
    if not least <= radius <= most:
        radius = min(max(radius, least), most)
        center, _, error = _rounding(foot.end, foot.center, plane, _NARROW, radius)
    millimetres = f'{1e3 * radius:.0f} mm radius'
    if error <= _UNROUND * radius:
        text = f'they are round, of {millimetres}'
    else:
        text = f'a circle of {millimetres} stands for them'
    notes.assume(f"no ball is at the legs' ends: {text}")
    return Foot(center, radius, foot.link)


def _rounding(
    shape: Points, near: Array, plane: Array, angles: Array, radius: float | None = None
) -> tuple[Array, float, float]:
    """
    Fit a circle to a leg's end where it meets the ground, in the plane in which the leg moves.

    In a direction d a shape reaches as far as h(d) = max p d over its points p; a circle about c
    with the radius r reaches c d + r. That is linear in c and r: least squares over directions.

    Parameters
    ----------
    shape : Points
        Shape at the leg's end.
    near : ndarray, shape (3,)
        A point of the plane near the end, in the root's frame [m].
    plane : ndarray, shape (2, 3)
        Middle of the directions, and the direction at right angles to it in the plane.
    angles : ndarray, shape (n,)
        Directions from the middle one [rad].
    radius : float, optional
        Radius of the circle; fitted if not given [m].

    Returns
    -------
    center : ndarray, shape (3,)
        In the root's frame [m].
    radius, error : float
        Radius, and the largest distance between the end and the circle [m].
    """
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    places = (shape.places - near) @ plane.T
    reaches = (places @ directions.T).max(axis=0) + shape.radius
    terms = np.column_stack([directions, np.ones(len(directions))])
    if radius is None:
        solution = np.linalg.lstsq(terms, reaches, rcond=None)[0]
    else:
        center = np.linalg.lstsq(directions, reaches - radius, rcond=None)[0]
        solution = np.append(center, radius)
    error = float(np.abs(terms @ solution - reaches).max())
    return near + solution[:2] @ plane, float(solution[2]), error


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
