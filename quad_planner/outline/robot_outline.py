"""
The outline of a robot: the convex polygon on the ground that holds its parts.
"""

from __future__ import annotations

import ast
import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from quad_common.errors import ParameterError
from quad_common.robot.robot import Robot

Array = NDArray[np.float64]

_SIDES = 16
"""Sides of the polygon that holds a round end of a part."""

_LARGEST = 10.0
"""Farthest corner of an outline from base_link [m]."""

_LONGEST_TEXT = 10_000
"""Number of letters of an outline, at most: Python's parser bears no text of any length."""

_VALID = (
    'a list of at least three corners in metres, within 10 m of base_link and around it, as '
    '[[0.3, 0.2], [-0.5, 0.2], [-0.5, -0.2], [0.3, -0.2]]; or empty'
)


def standing_outline(robot: Robot) -> Array:
    """
    Outline a robot that stands.

    The parts are those of :class:`~quad_common.robot.robot_shape.RobotShape` in the initial
    posture: the body's box, and capsules for the links of the legs. Stance feet stay within
    their places of rest at the ends of a walk, so strides do not lengthen it.

    Parameters
    ----------
    robot : Robot
        The robot.

    Returns
    -------
    ndarray, shape (n, 2)
        Corners of a convex polygon in the body frame, counter-clockwise [m].
    """
    shape = robot.own_parts.shape
    ends, radii = shape.part_ends(robot.initial_joint_angles)
    angles = 2.0 * math.pi * np.arange(_SIDES) / _SIDES
    # Around each round end, so that it is held.
    around = np.column_stack((np.cos(angles), np.sin(angles))) / math.cos(math.pi / _SIDES)
    points = ends[:, None, :2] + radii[:, None, None] * around
    return convex_hull(np.vstack((points.reshape(-1, 2), shape.body_corners()[:, :2])))


def convex_hull(points: ArrayLike) -> Array:
    """
    Wrap points in a convex polygon.

    Parameters
    ----------
    points : array_like, shape (n, 2)
        Any points.

    Returns
    -------
    ndarray, shape (m, 2)
        Its corners, counter-clockwise, without those on a straight side (Andrew's chain).
    """
    ordered = sorted(set(map(tuple, np.asarray(points, dtype=float).tolist())))
    halves = []
    for sequence in (ordered, ordered[::-1]):
        chain: list[tuple[float, float]] = []
        for x, y in sequence:
            while len(chain) > 1:
                (ax, ay), (bx, by) = chain[-2:]
                if (bx - ax) * (y - ay) - (by - ay) * (x - ax) > 1e-12:
                    break
                chain.pop()
            chain.append((x, y))
        halves.append(chain[:-1])
    return np.array(halves[0] + halves[1])


def outline_from_text(text: str) -> Array:
    """
    Read an outline, written as Nav2 writes footprints.

    Parameters
    ----------
    text : str
        A list of corners in the body frame, ``[[x, y], ...]`` [m].

    Returns
    -------
    ndarray, shape (n, 2)
        The convex polygon that holds them, counter-clockwise [m].

    Raises
    ------
    ParameterError
        If the text is no such list, a corner is too far off, or base_link is not inside.
    """
    try:
        if len(text) > _LONGEST_TEXT:
            raise ValueError
        corners = np.array(ast.literal_eval(text.strip()), dtype=float)
    except (ValueError, SyntaxError, TypeError, MemoryError, RecursionError):
        raise ParameterError('outline', text, _VALID) from None
    if corners.ndim != 2 or corners.shape[1] != 2 or not np.isfinite(corners).all():
        raise ParameterError('outline', text, _VALID)
    if np.abs(corners).max() > _LARGEST:
        raise ParameterError('outline', text, _VALID)
    hull = convex_hull(corners)
    if len(hull) < 3 or inner_radius(hull) <= 0.0:
        raise ParameterError('outline', text, _VALID)
    return hull


def inner_radius(outline: Array) -> float:
    """Return the radius of the largest circle around base_link within an outline [m]."""
    sides = np.roll(outline, -1, axis=0) - outline
    normals = np.column_stack((sides[:, 1], -sides[:, 0]))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    return float((normals * outline).sum(axis=1).min())


def outer_radius(outline: Array) -> float:
    """Return the radius of the circle around base_link that holds an outline [m]."""
    return float(np.linalg.norm(outline, axis=1).max())
