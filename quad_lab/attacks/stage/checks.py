"""
What must hold of every message, whoever published it: numbers are finite, texts are short.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

LONGEST_TEXT = 2000
"""Of a sentence on diagnostics or in the log [letters]; what is quoted of input is shorter."""

_FLOATS = ('double', 'float')


def numbers_not_finite(message: Any) -> list[str]:
    """
    Find numbers that are NaN or infinite.

    Parameters
    ----------
    message : message
        Of any class that has ``get_fields_and_field_types``.

    Returns
    -------
    list of str
        Path and value of each; of an array the first one only.
    """
    return [f'{field.lstrip(".")} is {value!r}' for field, value in _not_finite(message, '')]


def texts_too_long(message: Any) -> list[str]:
    """Find texts of more than `LONGEST_TEXT` letters; return path and length of each."""
    return [
        f'{field.lstrip(".")} has {length} letters'
        for field, length in _lengths(message, '')
        if length > LONGEST_TEXT
    ]


def _not_finite(message: Any, path: str) -> Iterator[tuple[str, float]]:
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        here = f'{path}.{name}'
        if kind in _FLOATS:
            if not math.isfinite(value):
                yield here, float(value)
        elif hasattr(value, 'get_fields_and_field_types'):
            yield from _not_finite(value, here)
        elif any(kind.startswith((f'sequence<{k}', f'{k}[')) for k in _FLOATS):
            bad = np.flatnonzero(~np.isfinite(np.asarray(value, float)))
            if bad.size:
                yield f'{here}[{bad[0]}]', float(value[int(bad[0])])
        elif '/' in kind:
            for index, element in enumerate(value):
                yield from _not_finite(element, f'{here}[{index}]')


def _lengths(message: Any, path: str) -> Iterator[tuple[str, int]]:
    for name, kind in message.get_fields_and_field_types().items():
        value = getattr(message, name)
        here = f'{path}.{name}'
        if kind == 'string':
            yield here, len(value)
        elif hasattr(value, 'get_fields_and_field_types'):
            yield from _lengths(value, here)
        elif kind.startswith('sequence<string'):
            yield from ((f'{here}[{index}]', len(text)) for index, text in enumerate(value))
        elif kind.startswith('sequence<') and '/' in kind:
            for index, element in enumerate(value):
                yield from _lengths(element, f'{here}[{index}]')
