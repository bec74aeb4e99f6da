"""
Meshes that descriptions name: where they are, and their corners.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import DescriptionUnusable, MeshNotFound
from quad_common.errors.quoting import quoted
from quad_common.files.bounded_file import is_file
from quad_common.files.package_path import is_in_package, package_candidates
from quad_common.files.whole_file import write_text

Array = NDArray[np.float64]

_LARGEST = 1e3
"""Largest coordinate of a mesh's corner [m]."""

_FILE = 'file://'

_LEVELS = 4
"""Number of folders around a description in which meshes are looked for by their paths' ends."""

_LONGEST_END = 8
"""Number of names in such an end."""


def mesh_path(name: str, description: Path) -> Path:
    """
    Find a mesh.

    Parameters
    ----------
    name : str
        As the description names it: absolute, relative to the description, or
        ``package://PACKAGE/...``.
    description : Path
        The description. A package is looked for among the folders around it, in
        ``ROS_PACKAGE_PATH`` and under ``share`` of ``AMENT_PREFIX_PATH``.

        Descriptions that were copied name meshes of where they were written: as a last resort
        the end of the path, two names at least, is looked for in the folders around.

    Returns
    -------
    Path
        Absolute.

    Raises
    ------
    MeshNotFound
        If it is nowhere.
    """
    folder = description.resolve().parent
    for path in chain(_candidates(name, folder), _by_end(name, folder)):
        if is_file(path):
            return path.resolve()
    raise MeshNotFound(description, name)


def is_elsewhere(name: str, description: Path) -> bool:
    """Return whether a mesh is not where its name says (:func:`mesh_path` finds it or not)."""
    return not any(is_file(path) for path in _candidates(name, description.resolve().parent))


def _by_end(name: str, folder: Path) -> Iterator[Path]:
    """Give where files around a description would end as a name does, the longest ends first."""
    path = name.partition('://')[2] or name
    parts = [part for part in unquote(path).split('/') if part][-_LONGEST_END:]
    around = [folder, *folder.parents][:_LEVELS]
    for k in range(len(parts) - 1):
        if '..' not in parts[k:]:
            yield from (above / '/'.join(parts[k:]) for above in around)


def _candidates(name: str, folder: Path) -> list[Path]:
    if name.startswith(_FILE):
        return [Path(name[len(_FILE) :]), Path(unquote(name[len(_FILE) :]))]
    if not is_in_package(name):
        return [folder / name]
    # Files of one folder are often handed on without their package.
    rest = name.partition('://')[2].partition('/')[2]
    return [*package_candidates(name, folder), folder / rest, folder.parent / rest]


def mesh_corners(mesh: Any, description: Path) -> Array:
    """
    Read the corners of a mesh.

    Parameters
    ----------
    mesh : yourdfpy.Mesh
        Name and scale.
    description : Path
        The description that names it.

    Returns
    -------
    ndarray, shape (n, 3)
        In the mesh's frame [m].

    Raises
    ------
    DescriptionError
        If it is not there, or no mesh.
    """
    corners: Array = np.array(_read(mesh_path(mesh.filename, description), description).vertices)
    scaled: Array = corners.reshape(-1, 3) * scale_of(mesh)
    if not (np.abs(scaled) <= _LARGEST).all():
        raise DescriptionUnusable(
            description,
            f'the mesh {quoted(mesh.filename)} has a corner that is no place: its numbers must be '
            f'finite, and from {-_LARGEST:g} to {_LARGEST:g} m with its scale',
        )
    return scaled


def scale_of(mesh: Any) -> Array:
    """Return the scale of a mesh along its axes, shape (3,)."""
    scale = 1.0 if mesh.scale is None else mesh.scale
    return np.broadcast_to(np.asarray(scale, dtype=float), (3,))


def convert_mesh(path: Path, target: Path, description: Path) -> None:
    """
    Write a mesh in the format of another file, told by its suffix, without its colors.

    Raises
    ------
    DescriptionError
        If it is no mesh.
    FileUnusable
        If the other file cannot be written.
    """
    mesh = _read(path, description)
    text = mesh.export(file_type=target.suffix[1:], include_texture=False)
    write_text(target, text, 'mesh')


def _read(path: Path, description: Path) -> Any:
    import trimesh

    try:
        mesh: Any = trimesh.load(path, force='mesh', process=False)
        # Scenes without a shape have no corners.
        assert len(mesh.vertices) > 0
    # Readers of a dozen formats raise what they like.
    except Exception as error:
        reason = f'the mesh {path} cannot be read: {type(error).__name__}: {error}'
        raise DescriptionUnusable(description, reason) from error
    return mesh
