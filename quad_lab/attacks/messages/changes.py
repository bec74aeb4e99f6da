"""
The ways in which the value of one field of a message can be changed.

By its ROS type alone: numbers that are no numbers, huge, tiny, at the ends of their range and
right beside the true one; texts that are empty, foreign and far too long; sequences that are
too short, too long, in another order.
"""

from __future__ import annotations

import copy
import math
import re
from array import array
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

_LONG_TEXT = 1_000_000
_GIANT_SEQUENCE = 200_000
_GIANT_COMPOSITE = 100_000
"""Lengths of what is far too long."""

_GIANT, _GIANT_TEXT = 'giant', f'a text of {_LONG_TEXT} letters'
GIANTS = (_GIANT, _GIANT_TEXT)
"""Words for the changes that make a message far too long."""

_DOUBLES = (
    math.nan, math.inf, -math.inf, 1e308, -1e308, 1.4e154, -1.4e154, 1e300, 1e30, -1e30, 1e9,
    -1e9, 1e4, -1e4, 7.85, -7.85, 1.0, -1.0, 0.0, -0.0, 1e-9, 5e-324,
)  # fmt: skip
_SINGLES = (math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1.9e19, 1e9, -1e9, 1.0, 0.0, -0.0)

_FRACTIONS = (1.0 + 1e-9, 1.001, 1.1, 2.0, -1.0, 0.5)
"""By which a number is multiplied: right at a limit, and just beyond."""

_TEXTS = (
    '', ' ', 'moon', 'base_link', 'odom', 'map', '/', 'a\nb', '%s%n{}', 'nan', '../..',
    'ä\u2603\U0001f41c', '1e308', "'; --", 'x' * 1000,
)  # fmt: skip

_SECONDS = (-1, 0, 1, 2**31 - 1, -(2**31))
"""Of stamps, besides those near to the present one."""

_INTEGER = re.compile(r'(u?)int(8|16|32|64)$')
_SEQUENCE = re.compile(r'sequence<([^,>]+)(?:, *\d+)?>$')
_ARRAY = re.compile(r'(.+)\[\d+\]$')


Change = tuple[str, Callable[[], object]]


def changes_of(value: Any, kind: str) -> Iterator[Change]:
    """List the ways to change a value, each with a word for it."""
    if kind == 'stamp':
        yield from _stamp_changes(value)
    elif _ARRAY.match(kind):
        yield from _array_changes(value)
    elif _SEQUENCE.match(kind):
        yield from _sequence_changes(value, str(element_kind(kind)))
    elif kind in ('double', 'float'):
        numbers = _DOUBLES if kind == 'double' else _SINGLES
        near = [float(value) * factor for factor in _FRACTIONS] if value else []
        yield from ((f'{number!r}', _constant(number)) for number in (*numbers, *near))
    elif kind == 'boolean':
        yield f'{not value}', _constant(not value)
    elif kind == 'octet':
        yield from ((f'{byte!r}', _constant(byte)) for byte in (b'\x00', b'\x01', b'\xff'))
    elif kind.startswith(('string', 'wstring')):
        yield from ((f'{text[:20]!r}', _constant(text)) for text in _TEXTS if text != value)
        yield _GIANT_TEXT, lambda: 'x' * _LONG_TEXT
    elif match := _INTEGER.match(kind):
        unsigned, bits = bool(match.group(1)), int(match.group(2))
        low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
        near_by = (value - 1, value + 1, 2 * value, 0, 1, 255, 65_536, low, high)
        for number in sorted({n for n in near_by if low <= n <= high and n != value}):
            yield str(number), _constant(number)
    else:
        raise TypeError(f"fields of type '{kind}' are not known here")


def element_kind(kind: str) -> str | None:
    """Return the type of the elements of a sequence or an array; None of anything else."""
    match = _SEQUENCE.match(kind) or _ARRAY.match(kind)
    return match.group(1) if match else None


def _constant(value: object) -> Callable[[], object]:
    return lambda: value


def _stamp_changes(stamp: Any) -> Iterator[Change]:
    def at(seconds: int, nanoseconds: int | None = None) -> Callable[[], object]:
        def make() -> object:
            changed = copy.copy(stamp)
            changed.sec = max(-(2**31), min(2**31 - 1, seconds))
            changed.nanosec = stamp.nanosec if nanoseconds is None else nanoseconds
            return changed

        return make

    for seconds in _SECONDS:
        yield f'{seconds} s', at(seconds)
    for shift in (-1000, -10, -1, 1, 10, 1000):
        yield f'{shift:+d} s', at(stamp.sec + shift)
    yield 'zero', at(0, 0)
    yield 'nanoseconds over', at(stamp.sec, 2**32 - 1)


def _array_changes(values: Any) -> Iterator[Change]:
    """Change an array whose length is fixed."""
    if not np.issubdtype(np.asarray(values).dtype, np.floating):
        yield 'zeros', lambda: np.zeros_like(values)
        return
    for number in (math.nan, math.inf, 1e308, -1.0, 0.0):
        yield f'all {number!r}', _filled(values, number)
    yield 'reversed', lambda: values[::-1].copy()


def _filled(values: Any, number: float) -> Callable[[], object]:
    return lambda: np.full_like(values, number)


def _sequence_changes(values: Any, kind: str) -> Iterator[Change]:
    """Change a sequence of any length as a whole."""
    few = list(values) if len(values) <= _GIANT_COMPOSITE else []
    yield 'empty', lambda: values[:0]
    if len(values):
        yield 'one less', lambda: values[:-1]
        yield 'one more', lambda: values + values[-1:]
        yield 'reversed', lambda: values[::-1]
        yield 'twice', lambda: values + values
    if len(few) > 1:
        yield 'all alike', lambda: _like(values, few[:1] * len(few))
        yield 'first two swapped', lambda: _like(values, [few[1], few[0], *few[2:]])
    if isinstance(values, array):
        if values.typecode in 'df':
            for number in (math.nan, math.inf, 1e308, 7.85, -7.85):
                yield f'all {number!r}', _like_later(values, number)
        one = values[:1] or array(values.typecode, [0])
        yield _GIANT, lambda: one * _GIANT_SEQUENCE
    elif len(values):
        yield _GIANT, lambda: values[:1] * _GIANT_COMPOSITE
    elif kind.startswith('string'):
        yield _GIANT, lambda: ['x'] * _GIANT_COMPOSITE


def _like_later(values: array[Any], number: float) -> Callable[[], object]:
    return lambda: array(values.typecode, [number]) * len(values)


def _like(values: Any, elements: list[Any]) -> object:
    """Return elements in the kind of sequence that values are in."""
    return array(values.typecode, elements) if isinstance(values, array) else elements
