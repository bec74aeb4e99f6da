"""
The numbers of a robot's data file: where they stand, which ranges they have.

Each is given as ``{value: ..., source: ...}`` and is known by its dotted name, for example
``leg.thigh_length``. The ranges hold robots of a few centimetres as of some metres.
"""

from __future__ import annotations

import fnmatch
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from quad_common.errors import (
    RobotNumberMissing,
    RobotNumberWithoutSource,
    RobotValueInvalid,
    UnknownKey,
)
from quad_common.files.yaml_document import check_keys
from quad_common.quantity import ANGLE, CYCLE_PERIOD, Quantity
from quad_common.robot.robot_build import JOINTS_PER_LEG

Array = NDArray[np.float64]

_LENGTH = Quantity(1e-3, 10.0, 'm')
_RADIUS = Quantity(1e-4, 2.0, 'm')
_OFFSET = Quantity(-2.0, 2.0, 'm')
_MASS = Quantity(1e-4, 1e4, 'kg')
_SPEED = Quantity(0.01, 200.0, 'rad/s')
_EFFORT = Quantity(1e-3, 1e5, 'N m')
_INERTIA = Quantity(-1e4, 1e4, 'kg m^2')

QUANTITIES: Mapping[str, Quantity] = {
    'body.hip_half_length': _LENGTH,
    'body.hip_half_width': _LENGTH,
    'body.length': _LENGTH,
    'body.width': _LENGTH,
    'body.height': _LENGTH,
    'body.center_height': _OFFSET,
    'body.center_forward': _OFFSET,
    'body.center_left': _OFFSET,
    'body.mass': _MASS,
    'body.center_of_mass': _OFFSET,
    'leg.hip_offset': _OFFSET,
    'leg.hip_drop': _OFFSET,
    'leg.lateral_offset': _OFFSET,
    'leg.forward_offset': _OFFSET,
    'leg.thigh_length': _LENGTH,
    'leg.calf_length': _LENGTH,
    'leg.*_radius': _RADIUS,
    'leg.*_mass': _MASS,
    'joints.*.lower': ANGLE,
    'joints.*.upper': ANGLE,
    'joints.*.velocity': _SPEED,
    'joints.*.effort': _EFFORT,
    'initial_posture.*': ANGLE,
    'legs.*.hip': _OFFSET,
    'legs.*.first_axis': Quantity(-1.0, 1.0),
    'legs.*.radial_direction': Quantity(-1.0, 1.0),
    'legs.*.*_offset': _OFFSET,
    'legs.*.*_length': _LENGTH,
    'legs.*.axes': Quantity(-1.0, 1.0),
    'legs.*.points': _OFFSET,
    'legs.*.foot': _OFFSET,
    'legs.*.zeros': ANGLE,
    'legs.*.lower': ANGLE,
    'legs.*.upper': ANGLE,
    'legs.*.velocity': _SPEED,
    'legs.*.effort': _EFFORT,
    'legs.*.initial_posture': ANGLE,
    'legs.*.masses': Quantity(0.0, 1e4, 'kg'),
    'legs.*.centers_of_mass': _OFFSET,
    'legs.*.inertias': _INERTIA,
    'gait.roughness': Quantity(0.0, 2.0, 'm'),
    'gaits.*.cycle_period': CYCLE_PERIOD,
    'gaits.*.largest_fractions': Quantity(0.01, 1.0),
    'gaits.*.swing_height': Quantity(1e-4, 5.0, 'm'),
}
"""Ranges by dotted names; a star stands for the name of a joint, a link or a gait."""


def quantity_of(name: str) -> Quantity:
    """Return the range of a number by its dotted name."""
    return next(
        quantity for pattern, quantity in QUANTITIES.items() if fnmatch.fnmatchcase(name, pattern)
    )


class RobotNumbers:
    """
    Looks numbers up by their dotted name and remembers where they come from.

    Parameters
    ----------
    document : mapping
        What the file holds.
    path : Path
        The file, for the sentences of errors.
    """

    def __init__(self, document: Mapping[str, Any], path: Path) -> None:
        self._document = document
        self._path = path
        self.sources: dict[str, str] = {}
        self._empty: set[str] = set()
        self._asked: set[str] = set()

    def __call__(self, name: str) -> float:
        """
        Look up a number and compare it with its range in :data:`QUANTITIES`.

        Parameters
        ----------
        name : str
            Its dotted name.

        Returns
        -------
        float
            The number, in its quantity's unit.

        Raises
        ------
        OutOfRange
            If it is no number of its range.
        RobotModelError
            If it is not in the file, or has no source.
        """
        return quantity_of(name).check(name, self._value(name))

    def vector(self, name: str, length: int = 3) -> Array:
        """
        Look up numbers of one quantity that are given as a list.

        Parameters
        ----------
        name : str
            Their dotted name.
        length : int
            Count of the numbers.

        Returns
        -------
        ndarray, shape (length,)
            In the quantity's unit.
        """
        values = self._value(name)
        if not isinstance(values, list) or len(values) != length:
            raise self.invalid(name, values, f'a list of {length} numbers')
        quantity = quantity_of(name)
        return np.array([quantity.check(f'{name}[{k}]', v) for k, v in enumerate(values)])

    def has(self, name: str) -> bool:
        """Whether the file has a number, or a mapping, of that name."""
        self._asked.add(name)
        node: Any = self._document
        for key in name.split('.'):
            if not isinstance(node, Mapping) or key not in node:
                return False
            node = node[key]
        return True

    def names_under(self, section: str) -> tuple[str, ...]:
        """List the keys of an optional section; none if it is left out or empty."""
        self._asked.add(section)
        node: Any = self._document
        for key in section.split('.'):
            node = node.get(key)
            if node is None:
                self._empty.add(section)
                return ()
        if not isinstance(node, Mapping):
            raise self.invalid(section, node, 'a mapping')
        return tuple(str(key) for key in node)

    def check_all_used(self, but: tuple[str, ...]) -> None:
        """Raise UnknownKey if the file holds a number that means nothing: it may be misspelt."""
        for name in _leaves(self._document, but):
            if name not in self.sources and name not in self._empty:
                section, _, key = name.rpartition('.')
                raise UnknownKey(section, key, self._names_in(section, but))

    def _names_in(self, section: str, but: tuple[str, ...]) -> tuple[str, ...]:
        """List what was looked for in a section, and at the top also what is no number."""
        prefix = f'{section}.' if section else ''
        asked = {name for name in self._asked if name.startswith(prefix)}
        names = {name[len(prefix) :].partition('.')[0] for name in asked}
        return tuple(sorted(names | (set() if section else set(but))))

    def or_zero(self, name: str) -> float:
        """Look up a number that is 0 if it is left out."""
        return self(name) if self.has(name) else 0.0

    def sign(self, name: str) -> float:
        """Look up +1 or -1; +1 if it is left out."""
        value = self._value(name) if self.has(name) else 1.0
        if isinstance(value, bool) or value not in (1, -1):
            raise self.invalid(name, value, '1 or -1')
        return float(value)

    def signs(self, name: str) -> tuple[float, float, float]:
        """Look up three of +1 or -1; +1 if they are left out."""
        value = self._value(name) if self.has(name) else [1, 1, 1]
        if (
            not isinstance(value, list)
            or len(value) != JOINTS_PER_LEG
            or any(isinstance(sign, bool) or sign not in (1, -1) for sign in value)
        ):
            raise self.invalid(name, value, 'three numbers, each 1 or -1')
        first, pitch, knee = (float(sign) for sign in value)
        return first, pitch, knee

    def is_true(self, name: str) -> bool:
        """Look up true or false; false if it is left out."""
        if not self.has(name):
            return False
        value = self._value(name)
        if not isinstance(value, bool):
            raise self.invalid(name, value, 'true or false')
        return value

    def invalid(self, name: str, value: object, valid: str) -> RobotValueInvalid:
        """Return the error of a value of a dotted name, and what would be valid."""
        return RobotValueInvalid(name, value, valid, f'{self._path}: ')

    def _value(self, name: str) -> Any:
        self._asked.add(name)
        node: Any = self._document
        for key in name.split('.'):
            if not isinstance(node, Mapping) or key not in node:
                raise RobotNumberMissing(self._path, name)
            node = node[key]
        if not isinstance(node, Mapping) or not node.get('source') or 'value' not in node:
            raise RobotNumberWithoutSource(self._path, name)
        check_keys(node, ('value', 'source'), name)
        self.sources[name] = str(node['source'])
        return node['value']


def _leaves(node: Mapping[str, Any], but: tuple[str, ...] = (), prefix: str = '') -> Iterator[str]:
    """List the dotted names of a document's numbers."""
    for key, value in node.items():
        if not prefix and key in but:
            continue
        if isinstance(value, Mapping) and 'value' not in value:
            yield from _leaves(value, prefix=f'{prefix}{key}.')
        else:
            yield f'{prefix}{key}'
