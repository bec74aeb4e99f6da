"""
Reads the files of meshes within bounds.

A few bytes of some formats stand for any number of corners, and name other files. What can place a
shape many times is read in a process of its own, all such files of a description in one.
"""

from __future__ import annotations

import io
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from quad_common.description.bounded_call import (
    BeyondBounds,
    Bounds,
    CallFailed,
    call_in_bounds,
)
from quad_common.errors import FileUnusable
from quad_common.files.bounded_file import read_bytes

Array = NDArray[np.float64]

READ_BY_ALL = ('.obj', '.stl')
"""Formats of meshes that every engine reads."""

FORMATS = (*READ_BY_ALL, '.ply', '.off', '.dae', '.glb', '.gltf')
"""Formats of meshes that are read: no archives, which may hold anything."""

_SCENES = ('.dae', '.glb', '.gltf')
"""Formats that can place one shape any number of times."""

LARGEST_MESH = 2**26
"""Bytes of the largest file of a mesh that is read."""

_MOST_CORNERS = 2**23
"""Corners of the largest mesh that is read."""

_BOUNDS = Bounds(seconds=120, memory=2**32, patience=150.0)
"""Robots whose meshes have a million corners take some ten seconds."""


class Mesh(NamedTuple):
    """What a file holds."""

    corners: Array
    """Places of the corners, shape (n, 3)."""
    text: str
    """The mesh as a file of the format .obj, without its colors; empty if it is of a format that
    every engine reads."""


class MeshFiles:
    """
    The files of meshes of one description, each of which is read once.

    Parameters
    ----------
    find : callable
        Returns the paths of all meshes that the description names and that are there.
    """

    def __init__(self, find: Callable[[], Iterable[Path]]) -> None:
        self._find = find
        self._read: dict[Path, Mesh | str] = {}

    def read(self, path: Path) -> Mesh | str:
        """Return what a file holds; a text that says why it cannot be read."""
        if path not in self._read:
            if path.suffix.lower() in _SCENES:
                scenes = [other for other in self._find() if other.suffix.lower() in _SCENES]
                self._read.update(_scenes({path, *scenes}))
            else:
                self._read[path] = _read(path)
        return self._read[path]


def _scenes(paths: set[Path]) -> dict[Path, Mesh | str]:
    """Read files in a process of their own."""
    try:
        read: dict[Path, Mesh | str] = call_in_bounds(_all_of, paths, bounds=_BOUNDS)
    except (BeyondBounds, CallFailed) as error:
        names = ', '.join(sorted(path.name for path in paths)[:3]) + (' ...' * (len(paths) > 3))
        return dict.fromkeys(paths, f'cannot be read: of {names} together is said: {error}')
    return read


def _all_of(paths: set[Path]) -> dict[Path, Mesh | str]:
    return {path: _read(path) for path in paths}


def _read(path: Path) -> Mesh | str:
    """Return what a file holds, or say why it cannot be read."""
    import trimesh

    suffix = path.suffix.lower()
    if suffix not in FORMATS:
        return f'cannot be read: its name must end in one of {", ".join(FORMATS)}'
    try:
        content = io.BytesIO(read_bytes(path, 'mesh', LARGEST_MESH))
        mesh: Any = trimesh.load(
            content, file_type=suffix[1:], resolver=_resolver(path), force='mesh', process=False
        )
        count = len(mesh.vertices)
        # Scenes without a shape have no corners.
        if count == 0:
            return 'has no corners'
        if count > _MOST_CORNERS:
            return f'has {count} corners; {_MOST_CORNERS} are the most'
        text = ''
        if suffix not in READ_BY_ALL:
            text = mesh.export(file_type='obj', include_texture=False)
        return Mesh(np.array(mesh.vertices, dtype=float).reshape(-1, 3), text)
    except FileUnusable as error:
        return error.reason
    # Readers of a dozen formats raise what they like.
    except Exception as error:
        return f'cannot be read: {type(error).__name__}: {error}'


def _resolver(path: Path) -> Any:
    """Let a file of glTF name what it is made of; colors and pictures are not looked at."""
    import trimesh

    def get(name: str) -> bytes:
        if path.suffix.lower() != '.gltf':
            raise FileNotFoundError(name)
        return read_bytes(path.parent / unquote(name), 'part of a mesh', LARGEST_MESH)

    resolver: Any = trimesh.resolvers.FilePathResolver(str(path))
    resolver.get = get
    return resolver
