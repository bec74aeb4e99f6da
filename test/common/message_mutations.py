"""Every message that differs from a valid one in one field, which holds something hostile."""

from __future__ import annotations

import copy
import math
from array import array
from collections.abc import Iterator
from typing import Any

import numpy as np

FLOATS = (math.nan, math.inf, -math.inf, 1e308, -1e308, 1.4e154, -1e154, 5e-324, -0.0, 0.0, -1.0)
SINGLES = (math.nan, math.inf, -math.inf, 3.4e38, -3.4e38, 1e-45, -0.0, 0.0, -1.0)
TEXTS = ('', 'moon', 'x' * 100_000, '\x00\n\x1b[31m', '\u202e\ud7ff')


def integers(kind: str) -> tuple[int, ...]:
    """Return the ends of an integer type, for example ``uint32``, and what is near 0."""
    bits = int(''.join(c for c in kind if c.isdigit()) or 8)
    if kind.startswith('u') or kind in ('byte', 'octet', 'char'):
        return (0, 1, 2**bits - 1, 2 ** (bits - 1))
    return (0, 1, -1, 2 ** (bits - 1) - 1, -(2 ** (bits - 1)))


def mutations(message: Any) -> Iterator[tuple[str, Any]]:
    """
    Yield a message for each field and each hostile value of it.

    Parameters
    ----------
    message : Any
        A valid ROS message; it stays as it is.

    Yields
    ------
    tuple of str and Any
        Which field and what it holds, and a message of its own.
    """
    for path, kind, value in _leaves(message, ()):
        for hostile in _hostile(kind, value):
            mutated = copy.deepcopy(message)
            owner = mutated
            for step in path[:-1]:
                owner = owner[step] if isinstance(step, int) else getattr(owner, step)
            if isinstance(path[-1], int):
                owner[path[-1]] = hostile
            else:
                setattr(owner, path[-1], hostile)
            yield f'{".".join(map(str, path))} = {_short(hostile)}', mutated


def _leaves(message: Any, path: tuple[Any, ...]) -> Iterator[tuple[tuple[Any, ...], str, Any]]:
    for name, kind in message.get_fields_and_field_types().items():
        value, here = getattr(message, name), (*path, name)
        if hasattr(value, 'get_fields_and_field_types'):
            yield from _leaves(value, here)
            continue
        yield here, kind, value
        if isinstance(value, list) and value and hasattr(value[0], 'get_fields_and_field_types'):
            # The first and the last stand for all.
            for index in sorted({0, len(value) - 1}):
                yield from _leaves(value[index], (*here, index))


def _hostile(kind: str, value: Any) -> Iterator[Any]:
    if isinstance(value, (list, array, np.ndarray)):
        yield from _hostile_sequences(kind, value)
    elif isinstance(value, str):
        yield from TEXTS
    elif isinstance(value, bool):
        yield not value
    elif isinstance(value, bytes):
        yield from (b'\x00', b'\xff')
    elif isinstance(value, float):
        yield from SINGLES if kind == 'float' else FLOATS
    else:
        yield from integers(kind)


def _hostile_sequences(kind: str, value: Any) -> Iterator[Any]:
    is_fixed = isinstance(value, np.ndarray)
    if not is_fixed:
        shorter, longer = copy.deepcopy(value), copy.deepcopy(value)
        yield copy.deepcopy(value)[:0]
        if len(value):
            shorter.pop()
            longer.append(copy.deepcopy(value[-1]))
            yield shorter
            yield longer
            yield value * 3
    if len(value) and isinstance(value[0], str):
        for text in TEXTS:
            yield [text, *value[1:]]
    elif len(value) and isinstance(value[0], (float, np.floating)):
        for number in FLOATS:
            for index in sorted({0, len(value) - 1}):
                changed = copy.deepcopy(value)
                changed[index] = number
                yield changed
    elif kind.startswith('sequence<int8'):
        for number in (-128, -2, 101, 127):
            changed = copy.deepcopy(value)
            changed[0] = number
            yield changed


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) < 40 else f'{text[:40]}... ({type(value).__name__})'
