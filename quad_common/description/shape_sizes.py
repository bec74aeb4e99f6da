"""
Sizes of shapes: whether they are any, and how thin a shape is.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LARGEST = 1e3
"""Largest length that a description may have [m], and largest scale of a mesh."""

THINNEST = 1e-5
"""Extent below which a shape has no volume [m]: engines refuse it."""

_SHEET = 1e-3
"""Thickness of the box that stands for a flat mesh [m]."""


def size_problem(geometry: Any) -> str:
    """
    Say what is wrong with the sizes of a shape.

    Parameters
    ----------
    geometry : yourdfpy.Geometry
        The shape; None for one without.

    Returns
    -------
    str
        What a link with it has that it cannot have; empty if nothing is wrong.
    """
    if geometry is None:
        return ''
    for what, numbers, counts, least in _sizes(geometry):
        values = np.ravel(np.asarray(numbers, dtype=float))
        text = ' '.join(f'{value:g}' for value in values)
        if len(values) not in counts:
            return f'has a {what} of {len(values)} numbers ({text}); it must be 3'
        if not ((values >= least) & (values <= LARGEST)).all():
            return f'has a {what} of {text}; it must be from {least:g} to {LARGEST:g}'
    return ''


def in_three(numbers: Any) -> Array:
    """Return a size or scale along each axis, shape (3,); one number is for all."""
    return np.broadcast_to(np.asarray(numbers, dtype=float), (3,))


def sizes_of(geometry: Any) -> Array:
    """Return the sizes of a shape that is no mesh, in no order, shape (n,) [m]."""
    sizes = [np.ravel(numbers) for _, numbers, _, least in _sizes(geometry) if least == 0.0]
    return np.concatenate([np.zeros(0), *sizes])


def _sizes(geometry: Any) -> Iterator[tuple[str, Any, tuple[int, ...], float]]:
    """Yield what a size is called, its numbers, how many they may be, and the least."""
    if geometry.box is not None:
        yield 'box size', geometry.box.size, (1, 3), 0.0
    if geometry.sphere is not None:
        yield 'sphere radius', geometry.sphere.radius, (1,), 0.0
    if geometry.cylinder is not None:
        yield 'cylinder radius', geometry.cylinder.radius, (1,), 0.0
        yield 'cylinder length', geometry.cylinder.length, (1,), 0.0
    if geometry.mesh is not None and geometry.mesh.scale is not None:
        # Meshes are mirrored by negative scales.
        yield 'mesh scale', geometry.mesh.scale, (1, 3), -LARGEST


def thin_box(corners: Array) -> tuple[Array, Array] | None:
    """
    Return the box around a mesh that has no volume.

    Parameters
    ----------
    corners : ndarray, shape (n, 3)
        Corners of the mesh [m].

    Returns
    -------
    pose : ndarray, shape (4, 4)
        Of the box in the mesh's frame.
    size : ndarray, shape (3,)
        Of the box [m]; its last is its thickness, and the second is 0 of a mesh that is a line,
        or a point.

        None of a mesh that has a volume.
    """
    middle = corners.mean(axis=0)
    spread = corners - middle
    axes = np.linalg.eigh(spread.T @ spread)[1]
    if np.ptp(spread @ axes[:, 0]) >= THINNEST:
        return None
    # In millimetres: the rectangle is found in single precision.
    flat = spread @ axes[:, [2, 1]]
    (across, along), size, turn = cv2.minAreaRect((1e3 * flat).astype(np.float32))
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    pose = np.eye(4)
    pose[:3, 0] = axes[:, [2, 1]] @ [cosine, sine]
    pose[:3, 1] = axes[:, [2, 1]] @ [-sine, cosine]
    pose[:3, 2] = np.cross(pose[:3, 0], pose[:3, 1])
    pose[:3, 3] = middle + 1e-3 * (axes[:, [2, 1]] @ [across, along])
    sides = 1e-3 * np.array(size)
    if sides.min() < THINNEST:
        sides = np.array([sides.max(), 0.0])
    return pose, np.append(sides, _SHEET)
