"""
The URDF beside a robot's data file, checked against the names that the file gives.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

from quad_common.errors import FileUnusable, RobotFileUnusable, RobotValueInvalid
from quad_common.errors.quoting import quoted
from quad_common.files.bounded_file import read_text
from quad_common.robot.robot_build import PartNames

LARGEST_URDF = 2**24
"""Bytes of the largest URDF that is read."""

_WHAT = 'URDF'


def named_urdf(document: Mapping[str, Any], names: PartNames, path: Path) -> str:
    """
    Read the robot's own URDF, whose path is relative to the data file.

    Parameters
    ----------
    document : mapping
        The data file.
    names : PartNames
        Names of joints and links that the URDF must have.
    path : Path
        Path of the data file.

    Returns
    -------
    str
        The XML text.

    Raises
    ------
    RobotModelError
        If there is none, it cannot be read, is no tree of links, or lacks one of the names.
    """
    name = document.get('urdf')
    if not isinstance(name, str) or not name.isprintable():
        raise RobotValueInvalid('urdf', name, 'the path of a URDF file', f'{path}: ')
    file = path.parent / name
    try:
        text = read_text(file, _WHAT, LARGEST_URDF)
    except FileUnusable as error:
        raise error.of_kind(RobotFileUnusable) from error
    problem = _problem(text, names)
    if problem:
        raise RobotFileUnusable(_WHAT, file, problem)
    return text


def _problem(text: str, names: PartNames) -> str:
    """Say what is wrong with a URDF; nothing if it is as the data file says."""
    if '<!DOCTYPE' in text:
        return 'has a document type, which no robot needs'
    try:
        root = ElementTree.fromstring(text)
    except (ElementTree.ParseError, ValueError) as error:
        return f'is no XML: {error}'
    if root.tag != 'robot':
        return f'is no URDF: it begins with {quoted(root.tag)}'
    links = [link.get('name', '') for link in root.iterfind('link')]
    joints = {joint.get('name', ''): joint for joint in root.iterfind('joint')}
    parents: dict[str, str] = {}
    for joint_name, joint in joints.items():
        ends = [joint.find(end) for end in ('parent', 'child')]
        parent, child = ('' if end is None else end.get('link', '') for end in ends)
        if parent not in links or child not in links:
            return f'has a joint {quoted(joint_name)} between links that are not there'
        if child in parents:
            return f'has two joints above the link {quoted(child)}'
        parents[child] = parent
    return (
        _not_there('link', (*names.feet, *sorted(names.falls)), links)
        or _not_there('joint', names.joints, joints)
        or _not_turning(names.joints, joints)
        or _not_once('link', links)
        or _not_once('joint', [joint.get('name', '') for joint in root.iterfind('joint')])
        or _no_tree(links, parents)
    )


def _not_there(kind: str, named: Iterable[str], there: Iterable[str]) -> str:
    missing = next((name for name in named if name not in set(there)), None)
    return '' if missing is None else f'has no {kind} {quoted(missing)}, which the data file names'


def _not_turning(named: Iterable[str], joints: Mapping[str, ElementTree.Element]) -> str:
    fixed = next((name for name in named if joints[name].get('type') != 'revolute'), None)
    return '' if fixed is None else f'has a joint {quoted(fixed)} that is not revolute'


def _not_once(kind: str, there: list[str]) -> str:
    name, count = Counter(there).most_common(1)[0]
    return '' if count == 1 else f'has {count} {kind}s {quoted(name)}'


def _no_tree(links: list[str], parents: Mapping[str, str]) -> str:
    """Say how many roots there are if not one: then the rest hangs in a loop, or apart."""
    roots = [link for link in links if link not in parents]
    if len(roots) != 1:
        return f'has {len(roots)} links that hang from no other; a robot has one'
    for link in links:
        above, steps = link, 0
        while above in parents and steps <= len(links):
            above, steps = parents[above], steps + 1
        if steps > len(links):
            return f'has a loop of joints at the link {quoted(link)}'
    return ''
