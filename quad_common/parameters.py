"""
Parameters of nodes, as data: one table gives default, unit, range and description.

A node's parameters are a frozen dataclass whose fields are made by :func:`parameter`.
From it come the ROS declarations and their checks, the commented file in ``config/``,
and the page in ``msg_docs/``.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from numbers import Real
from typing import Any, TypeVar

from quad_common.errors import ParameterError

Value = bool | int | float | str | list[float]


@dataclass(frozen=True)
class Parameter:
    """One parameter of a node."""

    name: str
    """Name of the parameter."""
    default: Value
    """Value if none is set."""
    description: str
    """Sentence that says what it does."""
    unit: str = ''
    """Unit of its value; empty for none."""
    lower: float | None = None
    """Least valid value, inclusive."""
    upper: float | None = None
    """Largest valid value, inclusive."""
    choices: tuple[str, ...] = ()
    """Valid values of a text; empty if any will do."""
    length: int | None = None
    """Number of elements of a list; one whose default is empty may also be empty."""
    is_dynamic: bool = False
    """Whether it may be set while the node runs."""

    def check(self, value: object) -> Value:
        """
        Return a value as the parameter's type, if it is valid.

        Parameters
        ----------
        value : object
            What was given.

        Returns
        -------
        bool, int, float, str or list of float
            The value, of the default's type.

        Raises
        ------
        ParameterError
            Saying what would be valid.
        """
        if isinstance(self.default, bool):
            if not isinstance(value, bool):
                raise ParameterError(self.name, value, 'true or false')
            return value
        if isinstance(self.default, str):
            if not isinstance(value, str) or (self.choices and value not in self.choices):
                choices = f'one of {", ".join(self.choices)}' if self.choices else 'a text'
                raise ParameterError(self.name, value, choices)
            return value
        if isinstance(self.default, list):
            return self._check_list(value)
        return self._check_number(value)

    def _check_list(self, value: object) -> list[float]:
        valid = f'{self.length} finite numbers'
        lengths = {self.length}
        if not self.default:
            valid += ', or none'
            lengths.add(0)
        if isinstance(value, str) or not isinstance(value, Iterable):
            raise ParameterError(self.name, value, valid)
        items = list(value)
        are_numbers = all(isinstance(item, Real) and not isinstance(item, bool) for item in items)
        if len(items) not in lengths or not are_numbers or not all(map(math.isfinite, items)):
            raise ParameterError(self.name, value, valid)
        return [float(item) for item in items]

    def _check_number(self, value: object) -> float | int:
        is_integer = isinstance(self.default, int)
        if isinstance(value, bool) or not isinstance(value, int if is_integer else (int, float)):
            raise ParameterError(self.name, value, self._valid_number())
        low = -math.inf if self.lower is None else self.lower
        high = math.inf if self.upper is None else self.upper
        if not math.isfinite(value) or not low <= value <= high:
            raise ParameterError(self.name, value, self._valid_number())
        return int(value) if is_integer else float(value)

    def _valid_number(self) -> str:
        kind = 'a whole number' if isinstance(self.default, int) else 'a finite number'
        unit = f' {self.unit}' if self.unit else ''
        if self.lower is not None and self.upper is not None:
            return f'{kind} from {self.lower:g} to {self.upper:g}{unit}'
        if self.lower is not None:
            return f'{kind} of at least {self.lower:g}{unit}'
        return kind if self.upper is None else f'{kind} of at most {self.upper:g}{unit}'


def parameter(
    default: Value,
    description: str,
    unit: str = '',
    lower: float | None = None,
    upper: float | None = None,
    choices: tuple[str, ...] = (),
    is_dynamic: bool = False,
    length: int | None = None,
) -> Any:
    """
    Make the field of a parameter dataclass; arguments as in :class:`Parameter`.

    A list is as long as its default unless a length is given.

    Returns
    -------
    dataclasses.Field
        Its name becomes the parameter's name.
    """
    metadata = {
        'parameter': Parameter(
            name='',
            default=default,
            description=description,
            unit=unit,
            lower=lower,
            upper=upper,
            choices=choices,
            length=len(default) if length is None and isinstance(default, list) else length,
            is_dynamic=is_dynamic,
        )
    }
    if isinstance(default, list):
        elements = list(default)
        return dataclasses.field(default_factory=lambda: list(elements), metadata=metadata)
    return dataclasses.field(default=default, metadata=metadata)


def parameters_of(table: type) -> tuple[Parameter, ...]:
    """List the parameters of a parameter dataclass, in order."""
    return tuple(
        dataclasses.replace(field.metadata['parameter'], name=field.name)
        for field in dataclasses.fields(table)
    )


Table = TypeVar('Table')


def checked_parameters(table: type[Table], values: Mapping[str, object]) -> Table:
    """
    Check values against a node's table and fill in the defaults.

    Parameters
    ----------
    table : type
        A parameter dataclass.
    values : mapping of str to object
        What was given.

    Returns
    -------
    table
        With one valid value for each parameter.

    Raises
    ------
    ParameterError
        If a value is not valid, or a name is not in the table.
    """
    known = {parameter.name: parameter for parameter in parameters_of(table)}
    for name, value in values.items():
        if name not in known:
            raise ParameterError(name, value, f'left out; parameters are {", ".join(known)}')
    return table(
        **{
            name: parameter.check(values.get(name, parameter.default))
            for name, parameter in known.items()
        }
    )


def yaml_from_parameters(node: str, table: Iterable[Parameter]) -> str:
    """
    Write a node's parameters as a commented ROS parameter file.

    Parameters
    ----------
    node : str
        Name of the node.
    table : iterable of Parameter
        Its parameters.

    Returns
    -------
    str
        The file's text, holding the defaults.
    """
    lines = [
        f'# Parameters of {node}: the defaults, as the node declares them.',
        f'# Written by: quadwalk parameters {node}',
        f'/**/{node}:',
        '  ros__parameters:',
    ]
    for parameter in table:
        lines.append(f'    # {_comment(parameter)}')
        lines.append(f'    {parameter.name}: {_yaml(parameter.default)}')
    return '\n'.join(lines) + '\n'


def valid_range(parameter: Parameter) -> str:
    """Say in a few words which values a parameter takes."""
    if parameter.choices:
        return ', '.join(parameter.choices)
    if isinstance(parameter.default, list):
        return f'{parameter.length} numbers' + ('' if parameter.default else ', or none')
    if isinstance(parameter.default, (bool, str)):
        return ''
    low = '' if parameter.lower is None else f'{parameter.lower:g}'
    high = '' if parameter.upper is None else f'{parameter.upper:g}'
    if low and high:
        return f'{low} to {high}'
    return f'at least {low}' if low else f'at most {high}' if high else ''


def _comment(parameter: Parameter) -> str:
    dynamic = 'may be set while the node runs' if parameter.is_dynamic else ''
    notes = [note for note in (parameter.unit, valid_range(parameter), dynamic) if note]
    return parameter.description + (f' [{"; ".join(notes)}]' if notes else '')


def _yaml(value: Value) -> str:
    if isinstance(value, bool):
        return 'true' if value else 'false'
    if isinstance(value, str):
        return "'" + value.replace("'", "''") + "'"
    if isinstance(value, list):
        return '[' + ', '.join(_yaml(float(item)) for item in value) + ']'
    # YAML 1.1 takes 1e-05 for a text: its numbers have a point.
    mantissa, exponent, power = repr(value).partition('e')
    return f'{mantissa}.0e{power}' if exponent and '.' not in mantissa else repr(value)
