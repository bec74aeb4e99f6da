"""
How large the body is and how thick the legs are, from the shapes of the links.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from quad_common.description.poses import moved
from quad_common.description.shapes import points_of
from quad_common.description.tree import KinematicTree
from quad_common.importing.chains import LegChain
from quad_common.importing.options import Notes

Array = NDArray[np.float64]

_SLIM = 0.06
"""Radius of a link without shapes, as a fraction of the leg's length."""

_THICKEST = 0.35
"""Largest radius of a link, as a fraction of the leg's length: covers reach far along a leg."""

_DEPTH = 0.6
"""Part of its extent in the leg's plane that a thigh's or calf's radius holds at least: legs pass
the body and each other sideways, and are flatter that way than they are deep."""

_ROLL = 0.45
"""Roll of a leg at which its edges come nearest to the body, in a wide stride sideways [rad]."""

_APART = 0.0148
"""Distance that parts keep from each other anyway, as a fraction of the leg's length: edges may
reach so far beyond a radius. It is :data:`quad_common.robot.own_parts.LEAST_CLEARANCE` in the
stance that imported robots have."""

_QUANTILE = 0.9
"""Part of a link's points that its thickness holds: bolts and edges stand out."""


@dataclass(frozen=True, eq=False)
class Sizes:
    """A box for the body and a radius for each kind of link."""

    body_size: Array
    """Length, width and height of the body, shape (3,) [m]."""
    body_center: Array
    """Center of that box in base_link, shape (3,) [m]."""
    radii: dict[str, float]
    """Radii of ``hip``, ``thigh`` and ``calf`` [m]."""


def body_box(
    tree: KinematicTree, body: list[str], to_base: Array, hips: Array, notes: Notes
) -> tuple[Array, Array]:
    """
    Find the box that holds the body's shapes.

    Parameters
    ----------
    tree : KinematicTree
        The description.
    body : list of str
        Links of the body.
    to_base : ndarray, shape (4, 4)
        Takes points of the root's frame to base_link's.
    hips : ndarray, shape (4, 3)
        Hip points in base_link [m].
    notes : Notes
        What is assumed is added to it.

    Returns
    -------
    size, center : ndarray, shape (3,)
        [m]
    """
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for shape in points_of(tree, body):
        places = moved(to_base, shape.places)
        low = np.minimum(low, places.min(axis=0) - shape.radius)
        high = np.maximum(high, places.max(axis=0) + shape.radius)
    if not np.isfinite(low).all():
        spread = np.ptp(hips, axis=0)
        height = 0.3 * float(spread[:2].min())
        notes.assume('the body has no shape: a box between the hips is assumed')
        return np.array([spread[0], spread[1], height]), np.zeros(3)
    return np.maximum(high - low, 1e-3), 0.5 * (low + high)


def link_radii(
    tree: KinematicTree,
    legs: list[LegChain],
    ends: Array,
    across: Array,
    foot_links: list[str],
    notes: Notes,
) -> dict[str, float]:
    """
    Find how thick hips, thighs and calves are.

    Parameters
    ----------
    tree : KinematicTree
        The description.
    legs : list of LegChain
        The four legs.
    ends : ndarray, shape (4, 3, 2, 3)
        Both ends of each link's middle line at the zero of all joints, in the root's frame [m].
    across : ndarray, shape (4, 3)
        Unit vectors along the pitch axes, in the root's frame.
    foot_links : list of str
        Links of the feet, which are not the calves'.
    notes : Notes
        What is assumed is added to it.
    """
    length = float(np.linalg.norm(ends[:, 1:, 1] - ends[:, 1:, 0], axis=-1).sum(axis=1).mean())
    radii = {}
    for part, kind in enumerate(('hip', 'thigh', 'calf')):
        found = []
        for leg, chain in enumerate(legs):
            links = [n for n in tree.rigid_group(chain.links[part]) if n not in foot_links]
            for shape in points_of(tree, links):
                start, end = ends[leg, part]
                away = _distances(shape.places, start, end)
                reach = float(np.quantile(away, _QUANTILE))
                if part > 0:
                    aside = np.abs((shape.places - start) @ across[leg])
                    reach = max(_DEPTH * reach, _reach_aside(away, aside, _APART * length))
                found.append(reach + shape.radius)
        if found:
            radius = min(float(np.median(found)), _THICKEST * length)
        else:
            radius = _SLIM * length
            notes.assume(f'{kind}s have no shape: a radius of {1e3 * radius:.0f} mm is assumed')
        radii[kind] = max(radius, 1e-3)
    return radii


def _reach_aside(away: Array, aside: Array, apart: float) -> float:
    """
    Return how far a link reaches sideways, upright and rolled, from its points (n,) [m].

    ``away`` is how far points are from the link's middle line, ``aside`` across the leg's plane.
    """
    deep = np.sqrt(np.maximum(away**2 - aside**2, 0.0))
    rolled = math.cos(_ROLL) * aside + math.sin(_ROLL) * deep
    return float(max(np.quantile(aside, _QUANTILE), np.quantile(rolled, _QUANTILE) - apart))


def _distances(points: Array, start: Array, end: Array) -> Array:
    """Return the distances of points (n, 3) from a line between two points [m]."""
    along = end - start
    squared = float(along @ along)
    fraction = np.zeros(len(points)) if squared < 1e-12 else (points - start) @ along / squared
    nearest = start + np.clip(fraction, 0.0, 1.0)[:, None] * along
    distances: Array = np.linalg.norm(points - nearest, axis=1)
    return distances
