"""
What a request for another robot means: which robot, by which name; and which robots are asked for.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import dataclass
from pathlib import PurePath
from urllib.parse import unquote

from quad_common.errors import (
    EntityNameInvalid,
    EntityNamespaceInvalid,
    NamePatternInvalid,
    ResourceFormatUnknown,
    ResourceMissing,
    ResourceStringGiven,
    RobotNameTaken,
)
from quad_common.named_robots.robot_cache import DESCRIPTIONS

ROBOT_NAME = re.compile(r'[A-Za-z]\w{0,60}', re.ASCII)
"""Names of robots: each is a namespace of ROS."""

FORMATS = ('urdf', 'xacro', 'mjcf')
"""Formats of other people's descriptions that are read, as simulators call them."""

_SUFFIXES = (*DESCRIPTIONS, '.yaml')

_LONGEST_PATTERN = 100

_MOST_REPETITIONS = 3
"""Of a pattern of names, with the alternatives of its groups: with more of them, or one within
another, a search may take for ever."""


@dataclass(frozen=True)
class SpawnRequest:
    """What somebody asks to be spawned."""

    uri: str
    """Name of a robot, or its file."""
    name: str = ''
    """Name that it is to have; empty for one that is found for it."""
    namespace: str = ''
    """Namespace that it is to have; empty for its name."""
    allow_renaming: bool = False
    """Whether another name than the one that is given will do."""
    resource_string: str = ''
    """Content of its file, in place of a URI."""

    @property
    def kind(self) -> str:
        """
        Name of the robot, or path of its file.

        Raises
        ------
        ResourceMissing, ResourceStringGiven
            If there is no URI.
        ResourceFormatUnknown
            If the URI leads to nothing that is read.
        """
        uri = self.uri.strip()
        if not uri:
            raise ResourceStringGiven() if self.resource_string else ResourceMissing()
        scheme, separator, rest = uri.partition('://')
        if separator and scheme not in ('file', 'package'):
            raise ResourceFormatUnknown(uri, _SUFFIXES)
        path = unquote(rest) if scheme == 'file' else uri
        is_file = bool(separator) or '/' in path or '.' in path
        if is_file and PurePath(path).suffix not in _SUFFIXES:
            raise ResourceFormatUnknown(uri, _SUFFIXES)
        return path

    def name_among(self, taken: Collection[str]) -> str:
        """
        Find the name of the robot.

        Parameters
        ----------
        taken : collection of str
            Names that robots have already.

        Returns
        -------
        str
            Its name, which is its namespace and the prefix of its frames.

        Raises
        ------
        EntityNameInvalid, EntityNamespaceInvalid, RobotNameTaken
            If the name cannot be, and no other one will do.
        """
        namespace = self.namespace.strip('/')
        if namespace and not ROBOT_NAME.fullmatch(namespace):
            raise EntityNamespaceInvalid(self.namespace, self.name)
        if namespace and self.name not in ('', namespace) and not self.allow_renaming:
            raise EntityNamespaceInvalid(self.namespace, self.name)
        name = namespace or self.name
        if not ROBOT_NAME.fullmatch(name):
            if not self.allow_renaming:
                raise EntityNameInvalid(name)
            name = _valid_name(name or PurePath(self.kind).stem)
        if name not in taken:
            return name
        if not self.allow_renaming:
            raise RobotNameTaken(name)
        numbered = (f'{name[:50]}_{number}' for number in range(2, len(taken) + 3))
        return next(each for each in numbered if each not in taken)


def names_like(pattern: str, names: Iterable[str]) -> list[str]:
    """
    List the names in which a pattern is found.

    Parameters
    ----------
    pattern : str
        Regular expression; empty for all.
    names : iterable of str
        Names of robots.

    Raises
    ------
    NamePatternInvalid
        If the pattern is none, or a search for it might take for ever.
    """
    repeats, groups = len(re.findall(r'[*+?{]', pattern)), pattern.count('(')
    if groups > 1 or (groups and repeats):
        # What follows a group is tried for each of its alternatives.
        repeats += pattern.count('|')
    if len(pattern) > _LONGEST_PATTERN or repeats > _MOST_REPETITIONS:
        valid = (
            f'{_LONGEST_PATTERN} characters, and {_MOST_REPETITIONS} repetitions or alternatives '
            'in groups, are the most'
        )
        raise NamePatternInvalid(pattern, valid)
    if re.search(r'\)[*+?{]|\\\d', pattern):
        raise NamePatternInvalid(pattern, 'groups can neither be repeated nor referred to')
    try:
        found = re.compile(pattern)
    except (re.error, ValueError, OverflowError) as error:
        # Of flags that exclude each other, and of numbers that are too large, Python says so.
        raise NamePatternInvalid(pattern, str(error)) from None
    return [name for name in names if found.search(name)]


def _valid_name(text: str) -> str:
    """Make a name of a text."""
    name = re.sub(r'\W', '_', text, flags=re.ASCII)[:50]
    return name if ROBOT_NAME.fullmatch(name) else f'robot_{name}'
