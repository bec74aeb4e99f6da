"""
Files that are named as ROS names them: ``package://PACKAGE/path/in/it``.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

SCHEMES = ('package://', 'model://')
"""Beginnings of names that say which package a file is in."""


_NAME = re.compile(r'<name>\s*([^<>\s]+)\s*</name>')
"""Name of a package in its ``package.xml``."""

_LARGEST_MANIFEST = 2**16
"""Characters of a ``package.xml`` that are read."""


def package_name(folder: Path) -> str:
    """
    Return the name of the ROS package in a folder, empty if there is none.

    It is what ``package.xml`` says: folders that were copied or cloned are often called otherwise.
    """
    try:
        with (folder / 'package.xml').open(encoding='utf-8', errors='replace') as file:
            found = _NAME.search(file.read(_LARGEST_MANIFEST))
    except OSError:
        return ''
    return found.group(1) if found else folder.name


def is_in_package(name: str) -> bool:
    """Return whether a name says which package its file is in."""
    return name.startswith(SCHEMES)


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
