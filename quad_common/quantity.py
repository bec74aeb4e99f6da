"""
Ranges of physical quantities, and numbers as they stand in files.

Each kind of file has a table of :class:`Quantity` beside its reader: what lies outside is a
slip of the pen or damage, and is refused before anything is made of it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from numbers import Real

from quad_common.errors import OutOfRange, ParameterError

_NUMBER = re.compile(r'[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?', re.ASCII)

_LONGEST_TEXT = 64
"""Characters of a text that may be a number."""


@dataclass(frozen=True)
class Quantity:
    """The range of a physical quantity, both ends inclusive."""

    lower: float
    """Least valid value, in the quantity's unit."""
    upper: float
    """Largest valid value, in the quantity's unit."""
    unit: str = ''
    """Unit of the quantity; empty for a plain number."""

    def check(self, name: str, value: object) -> float:
        """
        Return a value as a number, if it is one of the range.

        Parameters
        ----------
        name : str
            Name of the quantity, for the error.
        value : object
            What was given: a number, or a text that is one.

        Returns
        -------
        float
            The number, in the quantity's unit.

        Raises
        ------
        OutOfRange
            If it is no finite number, or outside the range.
        """
        number = number_from(value)
        if not self.lower <= number <= self.upper:
            raise OutOfRange(name, value, self.lower, self.upper, self.unit)
        return number

    def check_each(self, name: str, value: object, parts: Sequence[str]) -> list[float]:
        """
        Return a list of numbers, one for each part.

        Parameters
        ----------
        name : str
            Name of the whole.
        value : object
            What was given.
        parts : sequence of str
            Names of the parts; with the whole's they make the names for the error.

        Returns
        -------
        list of float
            As many numbers as there are parts.

        Raises
        ------
        OutOfRange
            If a part is outside the range.
        ParameterError
            If it is no list of as many parts.
        """
        listed = list_of(name, value, parts)
        return [self.check(f'{name}.{part}', item) for part, item in zip(parts, listed)]


COORDINATE = Quantity(-1e6, 1e6, 'm')
"""Places in the world."""

ANGLE = Quantity(-2.0 * math.pi, 2.0 * math.pi, 'rad')
"""Headings and joint angles: a whole turn on both sides."""

CELL_SIZE = Quantity(1e-4, 10.0, 'm')
"""Sides of the cells of maps and height maps."""

CYCLE_PERIOD = Quantity(0.05, 120.0, 's')
"""Periods of gaits."""


def number_from(value: object) -> float:
    """
    Return what a file says as a number; nan if it is none.

    A text is tried too: YAML 1.1 takes 5e-2 for a text, and ROS's own parser for a number.
    """
    if isinstance(value, str):
        is_number = len(value) <= _LONGEST_TEXT and _NUMBER.fullmatch(value)
        return float(value) if is_number else math.nan
    if isinstance(value, bool) or not isinstance(value, Real):
        return math.nan
    try:
        return float(value)
    except OverflowError:
        return math.nan


def list_of(name: str, value: object, parts: Sequence[str]) -> list[object]:
    """Return a list that has as many items as there are parts; raise ParameterError."""
    if not isinstance(value, list) or len(value) != len(parts):
        raise ParameterError(name, value, f'[{", ".join(parts)}]')
    return value
