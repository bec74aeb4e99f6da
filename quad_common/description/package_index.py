"""
Lets xacro find ROS packages that are not installed: those around the file that names them.

xacro asks ROS's index of packages, ``AMENT_PREFIX_PATH``, which only knows what is installed. A
description that was copied, or that is in a workspace that was not built, names its own package.
"""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from quad_common.files.bounded_file import is_file
from quad_common.files.package_path import package_name

_INDEX = 'AMENT_PREFIX_PATH'

_LEVELS = 6
"""Number of folders above a description that are looked at."""


@contextmanager
def packages_around(description: Path) -> Iterator[dict[str, str]]:
    """
    Add the packages around a description to the index, behind those that are installed.

    Parameters
    ----------
    description : Path
        The description. Folders above it with a ``package.xml`` are packages of the name that
        this says, and of the folder's own, and so are the folders beside those.

    Yields
    ------
    dict of str to str
        Where the packages really are, by the folders that the index gives.
    """
    before = os.environ.get(_INDEX)
    with tempfile.TemporaryDirectory() as folder:
        share = Path(folder) / 'share'
        names = share / 'ament_index' / 'resource_index' / 'packages'
        names.mkdir(parents=True)
        folders: dict[str, str] = {}
        for package in _packages(description.resolve()):
            for name in dict.fromkeys((package_name(package), package.name)):
                linked = share / name
                # Names of files only: what package.xml says may be anything.
                if str(linked) not in folders and linked.parent == share and name != '..':
                    (names / name).touch()
                    linked.symlink_to(package)
                    folders[str(linked)] = str(package)
        os.environ[_INDEX] = os.pathsep.join(filter(None, (before, folder)))
        try:
            yield folders
        finally:
            if before is None:
                del os.environ[_INDEX]
            else:
                os.environ[_INDEX] = before


def in_real_folders(
    text: str, folders: Mapping[str, str], written: Callable[[str], str] = str
) -> str:
    """
    Name the real folders of packages in a text in place of those that the index gives.

    Parameters
    ----------
    text : str
        What xacro made of a description, or said of it.
    folders : mapping of str to str
        As :func:`packages_around` yields them.
    written : callable
        Form that paths have in the text.

    Returns
    -------
    str
        The text with the real folders.
    """
    real = {written(found): written(folder) for found, folder in folders.items()}
    if not real:
        return text
    # The name of one package may begin another's.
    longest_first = sorted(real, key=len, reverse=True)
    pattern = '|'.join(re.escape(found) for found in longest_first)
    return re.sub(pattern, lambda match: real[match.group()], text)


def _packages(description: Path) -> list[Path]:
    """List the folders of packages around a file, the nearest first."""
    found: list[Path] = []
    for above in list(description.parents)[:_LEVELS]:
        if not is_file(above / 'package.xml'):
            continue
        manifests = sorted(above.parent.glob('*/package.xml'))
        beside = [path.parent for path in manifests if is_file(path)]
        found += [path for path in (above, *beside) if path not in found]
    return found
