"""
Errors of parameters, arguments and entries of files.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from quad_common.errors.base import QuadError
from quad_common.errors.quoting import quoted, shown


class ParameterError(QuadError, ValueError):
    """
    A parameter or an argument is outside what is valid.

    Parameters
    ----------
    name : str
        Name of the parameter.
    value : object
        The value that was refused.
    valid : str
        What would be valid, as the end of the sentence "it must be ...".
    where : str
        Beginning of the sentence that says where it stands, for example ``gait file x.yaml: ``.
    """

    def __init__(self, name: str, value: object, valid: str, where: str = '') -> None:
        self.name = name
        self.value = value
        self.valid = valid
        self.where = where
        super().__init__(f"{where}'{name}' is {shown(value)}; it must be {valid}")

    def at(self, where: str) -> ParameterError:
        """Return the same error with a beginning that says where the value stands."""
        return ParameterError(self.name, self.value, self.valid, where)


class OutOfRange(ParameterError):
    """
    A quantity is no number of its range.

    Parameters
    ----------
    name : str
        Name of the quantity; dotted where it is a part of another, for example ``origin.x``.
    value : object
        The value that was refused.
    lower, upper : float
        Least and largest valid value.
    unit : str
        Unit of the value and its range; empty for a plain number.
    where : str
        Beginning of the sentence that says where it stands.
    """

    def __init__(
        self,
        name: str,
        value: object,
        lower: float,
        upper: float,
        unit: str = '',
        where: str = '',
    ) -> None:
        self.lower = lower
        self.upper = upper
        self.unit = unit
        of_unit = f' {unit}' if unit else ''
        valid = f'a finite number from {lower:g} to {upper:g}{of_unit}'
        super().__init__(name, value, valid, where)

    def at(self, where: str, kind: type[OutOfRange] | None = None) -> OutOfRange:
        """Return the error as one of another kind, with a beginning that says where it stands."""
        kind = kind or type(self)
        return kind(self.name, self.value, self.lower, self.upper, self.unit, where)


class UnknownKey(ParameterError):
    """
    A file has a key that means nothing.

    Parameters
    ----------
    section : str
        Name of the part of the file that has it; empty for the whole.
    key : str
        The key.
    known : iterable of str
        The keys that would mean something.
    where : str
        Beginning of the sentence that says where it stands.
    """

    def __init__(self, section: str, key: str, known: Iterable[str], where: str = '') -> None:
        self.section = section
        self.key = key
        self.known = tuple(known)
        dotted = f'{section}.{key}' if section else key
        super().__init__(dotted, key, f'one of {", ".join(self.known)}', where)
        self.args = (
            f'{where}the key {shown(dotted)} means nothing; valid keys'
            f'{f" of {section!r}" if section else ""} are {", ".join(self.known)}',
        )

    def at(self, where: str) -> UnknownKey:
        """Return the same error with a beginning that says where the key stands."""
        return UnknownKey(self.section, self.key, self.known, where)


@dataclass(eq=False, repr=False)
class MissingKey(QuadError):
    """A file lacks a key that it must have."""

    key: str
    """Name of the key."""
    hint: str = ''
    """Remark on how to get it; empty for none."""

    def sentence(self) -> str:
        """Say which key is missing."""
        return f"the key '{self.key}' is missing{f'; {self.hint}' if self.hint else ''}"


@dataclass(eq=False, repr=False)
class ThresholdsCrossed(QuadError):
    """The thresholds of a map file are in the wrong order."""

    free: float
    """Occupancy up to which a cell is free."""
    occupied: float
    """Occupancy from which on a cell is occupied."""

    def sentence(self) -> str:
        """Say in which order they must be."""
        return (
            f"'free_thresh' is {self.free:g} and 'occupied_thresh' {self.occupied:g}; "
            'they must be 0 <= free_thresh <= occupied_thresh <= 1'
        )


@dataclass(eq=False, repr=False)
class MatrixSizeWrong(QuadError):
    """The rows and columns of a matrix in a file do not make its numbers."""

    key: str
    """Name of the matrix."""
    shape: list[object]
    """Rows and columns as the file has them."""
    count: int
    """Number of numbers that the matrix has."""

    def sentence(self) -> str:
        """Say what rows and columns must make together."""
        return (
            f"'{self.key}' has rows and cols of {shown(self.shape)}; "
            f'together they must make {self.count}'
        )


@dataclass(eq=False, repr=False)
class NumbersInvalid(QuadError):
    """A list of numbers in a file is too short or too long, or holds none."""

    key: str
    """Name of the list."""
    value: object
    """Value that the file has."""
    count: int
    """Number of numbers that it must hold."""

    def sentence(self) -> str:
        """Say what the list must hold."""
        return f"'{self.key}' is {shown(self.value)}; it must hold {self.count} finite numbers"


@dataclass(eq=False, repr=False)
class ArgumentNotText(QuadError):
    """A command-line argument is not text."""

    argument: str
    """Argument as it was given, with surrogates for the bytes that are no UTF-8."""

    def sentence(self) -> str:
        """Quote the argument, and say what it must be."""
        return f'the argument {quoted(self.argument)} is not valid UTF-8'


@dataclass(eq=False, repr=False)
class ParameterFixed(QuadError):
    """A parameter was to change that is taken at the start of its node only."""

    name: str
    """Name of the parameter."""
    value: object
    """Value that it has, and keeps."""

    def sentence(self) -> str:
        """Say that a restart is needed."""
        return (
            f"'{self.name}' is {shown(self.value)}, which is fixed while the node runs: "
            f'restart it to change that'
        )


@dataclass(eq=False, repr=False)
class ParameterUnknown(QuadError):
    """A parameter was to be set that the node does not have."""

    name: str
    """Name that was given."""

    def sentence(self) -> str:
        """Say how to find those that there are."""
        return (
            f"{quoted(self.name)} is no parameter of this node; 'ros2 param list' says which it has"
        )


@dataclass(eq=False, repr=False)
class TooManyWalks(QuadError):
    """A campaign has more walks than one may have."""

    combinations: int
    """Number of combinations of what varies."""
    walks: int
    """Walks of each combination."""
    most: int
    """Largest number of walks of a campaign."""

    def sentence(self) -> str:
        """Say how the number comes about, and which is possible."""
        each = '1 walk' if self.walks == 1 else f'{self.walks} walks'
        return (
            f'{self.combinations} combinations of what varies, {each} of each, make '
            f'{self.combinations * self.walks} walks; at most {self.most} are possible'
        )
