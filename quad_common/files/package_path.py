"""
Files that are named as ROS names them: ``package://PACKAGE/path/in/it``.
"""

from __future__ import annotations

import os
import re
import stat
from functools import lru_cache
from pathlib import Path

from quad_common.files.unblocked_file import open_unblocked

SCHEMES = ('package://', 'model://')
"""Beginnings of names that say which package a file is in."""


_NAME = re.compile(r'<name>\s*([^<>\s]+)\s*</name>')
"""Name of a package in its ``package.xml``."""

_LARGEST_MANIFEST = 2**16
"""Bytes of a ``package.xml`` that are read."""

_LONGEST_NAME = 255
"""Bytes of the name of a package: it is a folder's where the package is installed."""

_MOST_KEPT = 1024
"""Number of manifests whose names are kept: each mesh of a description asks for the same ones."""


def package_name(folder: Path) -> str:
    """
    Return the name of the ROS package in a folder, empty if there is none.

    It is what ``package.xml`` says: folders that were copied or cloned are often called otherwise.
    The folder's own is taken where this says none that a folder could have.
    """
    manifest = folder / 'package.xml'
    try:
        found = manifest.stat()
    except (OSError, ValueError):
        return ''
    if not stat.S_ISREG(found.st_mode):
        return ''
    state = found.st_dev, found.st_ino, found.st_size, found.st_mtime_ns, found.st_ctime_ns
    named = _name_in(manifest, state)
    return folder.name if named is None else named


@lru_cache(maxsize=_MOST_KEPT)
def _name_in(manifest: Path, _state: tuple[int, ...]) -> str | None:
    """Return the name in a manifest: None without one, empty if the file cannot be read."""
    try:
        with open_unblocked(manifest) as file:
            if not stat.S_ISREG(os.fstat(file.fileno()).st_mode):
                return ''
            text = file.read(_LARGEST_MANIFEST).decode(errors='replace')
    except (OSError, ValueError):
        return ''
    found = _NAME.search(text)
    if found is None:
        return None
    name = found.group(1)
    return name if name.isprintable() and len(name.encode()) <= _LONGEST_NAME else None


def is_in_package(name: str) -> bool:
    """Return whether a name says which package its file is in."""
    return name.startswith(SCHEMES)


def is_package_found(name: str) -> bool:
    """Return whether the package that a name says its file is in is there, with the file or not."""
    rest = name.partition('://')[2].partition('/')[2]
    candidates = package_candidates(f'{name[: len(name) - len(rest)]}package.xml')
    return any(package_name(manifest.parent) for manifest in candidates)


def package_candidates(name: str, around: Path | None = None) -> list[Path]:
    """
    List where a file of a package may be.

    Parameters
    ----------
    name : str
        For example ``package://my_robot/urdf/my_robot.urdf``.
    around : Path, optional
        Folder of the file that names it: the package may be one of the folders around.

    Returns
    -------
    list of Path
        In the order of preference; also under ``share`` of ``AMENT_PREFIX_PATH`` and in
        ``ROS_PACKAGE_PATH``.
    """
    inside = name.partition('://')[2]
    package, _, rest = inside.partition('/')
    folders = [] if around is None else [around, *around.parents]
    found = [above / rest for above in folders if package in (above.name, package_name(above))]
    found += [above / inside for above in folders]
    for variable, below in (('AMENT_PREFIX_PATH', 'share'), ('ROS_PACKAGE_PATH', '')):
        for entry in filter(None, os.environ.get(variable, '').split(os.pathsep)):
            found.append(Path(entry) / below / inside)
            if Path(entry).name == package:
                found.append(Path(entry) / rest)
    return found
