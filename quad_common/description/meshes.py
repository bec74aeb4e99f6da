"""
Meshes that descriptions name: where they are, and their corners.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from quad_common.description.mesh_files import Mesh, MeshFiles
from quad_common.description.shape_sizes import LARGEST, in_three
from quad_common.errors import DescriptionUnusable, MeshNotFound
from quad_common.errors.quoting import quoted
from quad_common.files.bounded_file import is_file
from quad_common.files.package_path import is_in_package, package_candidates
from quad_common.files.whole_file import write_text

Array = NDArray[np.float64]

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


def mesh_corners(mesh: Any, description: Path, files: MeshFiles) -> Array:
    """
    Read the corners of a mesh.

    Parameters
    ----------
    mesh : yourdfpy.Mesh
        Name and scale.
    description : Path
        The description that names it.
    files : MeshFiles
        Its files of meshes.

    Returns
    -------
    ndarray, shape (n, 3)
        In the mesh's frame [m].

    Raises
    ------
    DescriptionError
        If it is not there, or no mesh.
    """
    corners = _read(mesh_path(mesh.filename, description), description, files).corners
    scaled: Array = corners * in_three(1.0 if mesh.scale is None else mesh.scale)
    if not (np.abs(scaled) <= LARGEST).all():
        raise DescriptionUnusable(
            description,
            f'the mesh {quoted(mesh.filename)} has a corner that is no place: its numbers must be '
            f'finite, and from {-LARGEST:g} to {LARGEST:g} m with its scale',
        )
    return scaled


def convert_mesh(path: Path, target: Path, description: Path, files: MeshFiles) -> None:
    """
    Write a mesh of a format that not every engine reads as a file of the format .obj.

    Raises
    ------
    DescriptionError
        If it is no mesh.
    FileUnusable
        If the other file cannot be written.
    """
    write_text(target, _read(path, description, files).text, 'mesh')


def _read(path: Path, description: Path, files: MeshFiles) -> Mesh:
    mesh = files.read(path)
    if isinstance(mesh, str):
        raise DescriptionUnusable(description, f'the mesh {path} {mesh}')
    return mesh


def files_of(names: Collection[str], description: Path) -> MeshFiles:
    """Return the files of the meshes of some names, those that are there."""

    def find() -> Iterator[Path]:
        for name in names:
            with suppress(MeshNotFound):
                yield mesh_path(name, description)

    return MeshFiles(find)
