"""
What a person may say of a robot that its description leaves open, and what was found in it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field

DIRECTIONS = ('+x', '-x', '+y', '-y', '+z', '-z')
"""Directions of the root link's axes."""

KNEES = ('forward', 'backward', 'inward', 'outward')
"""Where knees may point: all alike, toward the robot's middle, or away from it."""

ASSUMED = '# assumed: '
"""Beginning of a line of an imported robot's data file that says what was assumed."""

_LONGEST_NAME = 64
"""Characters of a robot's name."""


def file_name(name: str) -> str:
    """Make of any text a name that robots and files may have: no folders, no control characters."""
    plain = re.sub(r'[^\w.+-]', '_', name)[:_LONGEST_NAME].strip('.')
    return plain or 'robot'


@dataclass(frozen=True)
class ImportOptions:
    """What is to be taken in place of what a description says, or where it says nothing."""

    name: str = ''
    """Name of the robot; the description's own if empty."""
    effort: tuple[float, ...] = ()
    """Largest torques of a leg's three joints, or one for all; the description's if empty [N m]."""
    speed: tuple[float, ...] = ()
    """Largest speeds of a leg's joints, as the torques [rad/s]."""
    mass: float = 0.0
    """Mass of the whole robot, for descriptions that state none of some parts; 0 if it is not
    known [kg]."""
    forward: str = ''
    """Direction in which the robot walks, one of :data:`DIRECTIONS`; found if empty."""
    knees: str = ''
    """Where the knees point, one of :data:`KNEES`; found if empty."""
    arguments: tuple[tuple[str, str], ...] = ()
    """Names and values of a xacro file's arguments."""


@dataclass
class Notes:
    """What was found in a description, and what was assumed for want of it."""

    found: list[str] = field(default_factory=list)
    """Sentences on what the description says."""
    assumed: list[str] = field(default_factory=list)
    """Sentences on what it does not say, and how to choose otherwise."""

    def assume(self, sentence: str) -> None:
        """Add an assumption, once."""
        if sentence not in self.assumed:
            self.assumed.append(sentence)
