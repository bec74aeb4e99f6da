"""
Expands xacro files, by ROS's own package.
"""

from __future__ import annotations

import importlib.util
import re
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

from quad_common.description.bounded_call import (
    BeyondBounds,
    Bounds,
    CallFailed,
    call_in_bounds,
)
from quad_common.description.package_index import in_real_folders, packages_around
from quad_common.errors import DescriptionUnusable, MissingOptionalDependency
from quad_common.errors.quoting import quoted

_BOUNDS = Bounds(seconds=20, memory=2**32, patience=20.0)
"""Large descriptions of robots take a tenth of a second; a file may include a pipe."""


def expanded(path: Path, arguments: Mapping[str, str]) -> bytes:
    """
    Run xacro, in a process of its own: what a file evaluates may take any time and memory.

    Parameters
    ----------
    path : Path
        The file.
    arguments : mapping of str to str
        Values of its arguments; those that are not given keep the defaults that the file has.

    Returns
    -------
    bytes
        The URDF.

    Raises
    ------
    DescriptionUnusable
        If it cannot be expanded, or does not ask for an argument that is given.
    MissingOptionalDependency
        If xacro is not installed.
    """
    if importlib.util.find_spec('xacro') is None:
        raise MissingOptionalDependency('xacro', "pip install 'quadwalk[robots]'")
    with packages_around(path) as folders:
        try:
            text, asked = call_in_bounds(
                _expand, str(path.absolute()), dict(arguments), bounds=_BOUNDS
            )
        except BeyondBounds as error:
            raise DescriptionUnusable(path, f'xacro cannot expand it: {error}') from None
        except CallFailed as error:
            reason = _reason(error.message, error.kind, folders)
            raise DescriptionUnusable(path, f'xacro cannot expand it: {reason}') from None
    if unknown := sorted(set(arguments) - set(asked)):
        known = ', '.join(map(quoted, asked)) or 'none'
        raise DescriptionUnusable(
            path, f'asks for no argument {quoted(unknown[0])}; it asks for {known}'
        )
    # Folders may have any name, and this is XML, whose attributes are in double quotes.
    return in_real_folders(text, folders, lambda path: escape(path, {'"': '&quot;'})).encode(
        errors='surrogatepass'
    )


class _Arguments(dict[str, str]):
    """Values of arguments, and which were asked for: xacro takes any without a word."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def _expand(path: str, arguments: dict[str, str]) -> tuple[str, list[str]]:
    """Expand a file, which is evaluated; return what it says, and what arguments it asks for."""
    import xacro

    given = _Arguments(arguments)
    text: str = xacro.process_file(path, mappings=given).toxml()
    return text, sorted(given.asked)


def _reason(error: str, kind: str, folders: Mapping[str, str]) -> str:
    """Say once why xacro gave up, with the real folders and what can be done."""
    # xacro repeats itself, with classes and numbers of errors between.
    reason = error.rpartition('> ')[2].partition(' [Errno')[0] or kind
    reason = in_real_folders(reason, folders)
    if lacking := re.search(r"package '([^']*)' not found", error):
        return (
            f'the package {quoted(lacking.group(1))} that it uses is not installed, and not around '
            'the file'
        )
    if 'Undefined substitution argument' in reason:
        reason += '; give it with --argument NAME=VALUE'
    return reason
