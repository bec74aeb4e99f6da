"""
Reads a description of a robot, whichever of the three formats it has.

URDF is read by yourdfpy, xacro by ROS's own package, MJCF by MuJoCo. What comes out is yourdfpy's
model of a robot in each case.
"""

from __future__ import annotations

import io
import logging
import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from quad_common.description.bounded_call import (
    BeyondBounds,
    Bounds,
    CallFailed,
    call_in_bounds,
)
from quad_common.description.elements import check_elements
from quad_common.description.xacro_expansion import expanded
from quad_common.errors import (
    DescriptionUnusable,
    FileUnusable,
    MissingOptionalDependency,
)
from quad_common.files.bounded_file import read_bytes, user_path

LARGEST_DESCRIPTION = 2**24
"""Bytes of the largest description that is read."""

_WHAT = "robot's description"

_BOUNDS_OF_MJCF = Bounds(seconds=40, memory=2**33)
"""Robots whose meshes have a million corners take some seconds."""

try:
    import yourdfpy
    from lxml import etree
except ImportError as error:
    raise MissingOptionalDependency('yourdfpy', "pip install 'quadwalk[robots]'") from error

# It tells what it cannot find or does not know; what matters here becomes an error or a note.
logging.getLogger('yourdfpy').setLevel(logging.ERROR)


def read_description(path: str | Path, arguments: Mapping[str, str] | None = None) -> Any:
    """
    Read a robot's description.

    Parameters
    ----------
    path : str or Path
        URDF, xacro or MJCF file.
    arguments : mapping of str to str, optional
        Values of a xacro file's arguments.

    Returns
    -------
    yourdfpy.Robot
        Links and joints, meshes named as the file names them.

    Raises
    ------
    DescriptionError
        If the file is none of these, or its format's reader refuses it.
    """
    try:
        path = user_path(path, _WHAT)
        content = read_bytes(path, _WHAT, LARGEST_DESCRIPTION)
    except FileUnusable as error:
        raise DescriptionUnusable(error.path, f'the {_WHAT} {error.reason}') from error
    root = _parsed(content, path)
    if root.tag == 'mujoco':
        return _robot_from_mjcf(path)
    if root.tag != 'robot':
        raise DescriptionUnusable(
            path, f'is neither URDF, xacro nor MJCF: it begins with {root.tag}'
        )
    if path.suffix == '.xacro' or 'http://www.ros.org/wiki/xacro' in root.nsmap.values():
        root = _parsed(expanded(path, arguments or {}), path)
    return _robot_from_urdf(root, path)


def _robot_from_mjcf(path: Path) -> Any:
    """Have MuJoCo read a file that may ask for a billion bodies, or a mesh that is a pipe."""
    from quad_common.description.mjcf import robot_from_mjcf

    try:
        return call_in_bounds(robot_from_mjcf, path.absolute(), bounds=_BOUNDS_OF_MJCF)
    except (BeyondBounds, CallFailed) as error:
        raise DescriptionUnusable(path, f'MuJoCo cannot read it: {error}') from None


def _parsed(content: bytes, path: Path) -> Any:
    """Parse XML without entities: a few lines of them can stand for any amount of text."""
    parser = etree.XMLParser(
        resolve_entities=False, no_network=True, remove_comments=True, remove_blank_text=True
    )
    # Versions that XML never had, and encodings that the file has not, are what they say at most.
    content = re.sub(rb'^\s*<\?xml[^>]*\?>', b'', content.removeprefix(b'\xef\xbb\xbf'), count=1)
    try:
        root = etree.fromstring(content, parser)
    except (etree.XMLSyntaxError, ValueError) as error:
        raise DescriptionUnusable(path, f'is no XML: {error}') from error
    if root.getroottree().docinfo.doctype:
        raise DescriptionUnusable(path, 'has a document type, which no robot needs')
    return root


def _robot_from_urdf(root: Any, path: Path) -> Any:
    if root.find('link') is None:
        raise DescriptionUnusable(
            path, 'describes no links; is it a part that the description of a robot includes?'
        )
    if not root.get('name'):
        # The reader wants one; xacro files are often without.
        root.set('name', path.name.partition('.')[0] or 'robot')
    check_elements(root, path)
    try:
        model = yourdfpy.URDF.load(
            io.BytesIO(etree.tostring(root)), load_meshes=False, build_scene_graph=False
        )
    # The reader raises what its parts raise, mostly of a number that is none.
    except Exception as error:
        detail = f'{type(error).__name__}: {error}'
        raise DescriptionUnusable(path, f'the URDF cannot be read: {detail}') from error
    return model.robot
