"""
Files that are named as ROS names them: ``package://PACKAGE/path/in/it``.
"""

from __future__ import annotations

import os
from pathlib import Path

SCHEMES = ('package://', 'model://')
"""Beginnings of names that say which package a file is in."""


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
    found = [above / rest for above in folders if above.name == package]
    found += [above / inside for above in folders]
    for variable, below in (('AMENT_PREFIX_PATH', 'share'), ('ROS_PACKAGE_PATH', '')):
        for entry in filter(None, os.environ.get(variable, '').split(os.pathsep)):
            found.append(Path(entry) / below / inside)
            if Path(entry).name == package:
                found.append(Path(entry) / rest)
    return found
