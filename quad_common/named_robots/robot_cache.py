"""
Data files of robots that are asked for by name or by description, imported once and kept.

They are kept in the user's folder for caches, by the description's content: one that changes is
imported again.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
from dataclasses import replace
from itertools import islice, takewhile
from pathlib import Path

from quad_common.errors import DescriptionUnusable, FileUnusable
from quad_common.files.bounded_file import is_file, make_folder, read_bytes, read_text, user_path
from quad_common.files.whole_file import write_text
from quad_common.importing.options import ASSUMED, ImportOptions, file_name
from quad_common.named_robots.description_cache import cached_description
from quad_common.named_robots.known_robots import KNOWN_ROBOTS

DESCRIPTIONS = ('.urdf', '.xacro', '.xml', '.mjcf')
"""Suffixes of files that are imported where a robot is asked for."""

_FORMAT = 21
"""Number of the format of kept files: raised when an import finds more than it did."""

_MOST_INCLUDED = 1000
"""Number of xacro files in a package that are looked at."""

_LARGEST = 2**24
"""Bytes of the largest description that is read."""


def _included(description: Path) -> list[tuple[str, int]]:
    """List what a xacro file may include, with the times of the last changes [ns]."""
    if description.suffix != '.xacro':
        return []
    folder = description.resolve().parent
    package = next((at for at in (folder, *folder.parents) if is_file(at / 'package.xml')), None)
    # Without a package there is no telling where it ends: a home folder is not looked through.
    found = folder.glob('*.xacro') if package is None else package.rglob('*.xacro')
    files = islice((path for path in found if is_file(path)), _MOST_INCLUDED)
    return sorted((str(path), path.stat().st_mtime_ns) for path in files)


def cache_folder() -> Path:
    """Return the folder in which imported robots are kept."""
    home = os.environ.get('XDG_CACHE_HOME') or '~/.cache'
    return user_path(home) / 'quadwalk' / 'robots'


def is_kept(data_file: Path) -> bool:
    """Return whether a robot's data file was made of a description that was asked for."""
    return data_file.parent == cache_folder()


def assumptions(data_file: Path) -> list[str]:
    """Return what was assumed where a robot's description told nothing, as sentences."""
    lines = takewhile(lambda line: line.startswith('#'), read_text(data_file).splitlines())
    return [line.removeprefix(ASSUMED) for line in lines if line.startswith(ASSUMED)]


def known_robot_file(name: str) -> Path | None:
    """
    Return the data file of a robot whose description is installed; None if there is none.

    Parameters
    ----------
    name : str
        One of :data:`KNOWN_ROBOTS`, or of the package ``robot_descriptions``.

    Raises
    ------
    DescriptionError
        If it cannot be imported.
    DescriptionNotCached, MissingOptionalDependency
        If it is to be fetched, or the package to be installed, first.
    """
    known = KNOWN_ROBOTS.get(name)
    path = known.path if known is not None else None
    if known is not None and path is not None:
        return imported_file(path, replace(known.options, name=name))
    cached = cached_description(name)
    if cached is None:
        return None
    return imported_file(cached.path, replace(cached.options, name=name))


def imported_file(description: Path, options: ImportOptions | None = None) -> Path:
    """
    Return the data file of the robot that a description describes.

    Parameters
    ----------
    description : Path
        URDF, xacro or MJCF file.
    options : ImportOptions, optional
        What it leaves open.

    Returns
    -------
    Path
        Kept since the last time, or written now.

    Raises
    ------
    DescriptionError
        If it cannot be imported.
    FileUnusable
        If nothing can be written in the folder for caches.
    """
    options = ImportOptions() if options is None else options
    try:
        content = read_bytes(description, "robot's description", _LARGEST)
    except FileUnusable as error:
        raise DescriptionUnusable(error.path, f"the robot's description {error.reason}") from error
    asked = f'{_FORMAT} {description.resolve()} {options} {_included(description)}'.encode()
    key = hashlib.sha256(content + asked).hexdigest()[:12]
    name = file_name(options.name or description.name.partition('.')[0])
    path = cache_folder() / f'{name}-{key}.yaml'
    if is_file(path) and is_file(path.with_suffix('.urdf')):
        return path
    # Reading descriptions needs packages that are slow to import, and may not be there.
    from quad_common.importing.robot_document import write_robot
    from quad_common.importing.robot_import import import_robot

    robot = import_robot(description, options)
    make_folder(path.parent)
    try:
        # Several nodes may begin at once: each writes files of its own, and the last one stays.
        with tempfile.TemporaryDirectory(dir=path.parent) as folder:
            meshes = path.with_name(f'{path.stem}_meshes')
            data_file, urdf = write_robot(robot, Path(folder) / path.name, meshes)
            urdf.replace(path.with_suffix('.urdf'))
            data_file.replace(path)
    except OSError as error:
        reason = f'cannot be written in: {error.strerror or error}; set XDG_CACHE_HOME to another'
        raise FileUnusable('folder of imported robots', path.parent, reason) from error
    return path


def described_file(text: str) -> Path:
    """
    Return the data file of the robot that a URDF describes, which somebody has published.

    Parameters
    ----------
    text : str
        The URDF.

    Returns
    -------
    Path
        As of :func:`imported_file`.

    Raises
    ------
    DescriptionError
        If it cannot be imported.
    FileUnusable
        If nothing can be written in the folder for caches.
    """
    key = hashlib.sha256(text.encode()).hexdigest()[:12]
    description = cache_folder() / 'descriptions' / key / 'described_robot.urdf'
    if not is_file(description):
        make_folder(description.parent)
        write_text(description, text, "robot's description")
    return imported_file(description)
