"""
Expands xacro files, by ROS's own package.
"""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from xml.sax.saxutils import escape

from quad_common.description.package_index import in_real_folders, packages_around
from quad_common.description.xacro_worker import LONGEST
from quad_common.errors import DescriptionUnusable, MissingOptionalDependency
from quad_common.errors.quoting import quoted

_WORKER = 'quad_common.description.xacro_worker'

_PATIENCE = 60.0
"""Time on the wall clock for a file, which may wait for what it includes [s]."""


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
        If it cannot be expanded.
    MissingOptionalDependency
        If xacro is not installed.
    """
    if importlib.util.find_spec('xacro') is None:
        raise MissingOptionalDependency('xacro', "pip install 'quadwalk[robots]'")
    with packages_around(path) as folders:
        result = _work(path, arguments)
    if 'error' in result:
        reason = _reason(result['error'], result['kind'], folders)
        raise DescriptionUnusable(path, f'xacro cannot expand it: {reason}')
    # Folders may have any name, and this is XML, whose attributes are in double quotes.
    return in_real_folders(
        result['text'], folders, lambda path: escape(path, {'"': '&quot;'})
    ).encode(errors='surrogatepass')


def _work(path: Path, arguments: Mapping[str, str]) -> dict[str, str]:
    """Have the file expanded; return the text, or the error and its kind."""
    order = json.dumps([str(path.absolute()), dict(arguments)])
    try:
        done = subprocess.run(
            [sys.executable, '-m', _WORKER, order],
            # Where this package is found, whatever lies in the user's folder.
            cwd=Path(__file__).parents[2],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            timeout=_PATIENCE,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return {'error': '', 'kind': f'it waits for more than {_PATIENCE:.0f} s'}
    try:
        result: dict[str, str] = json.loads(done.stdout)
    except ValueError:
        # Ended by its limit, or for want of memory.
        return {'error': '', 'kind': f'it takes more than {LONGEST} s, or too much memory'}
    return result


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
