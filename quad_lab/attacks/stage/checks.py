"""
What must hold of every message, whoever published it: numbers are finite, texts are short.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from functools import cache
from typing import Any

import numpy as np

from quad_lab.attacks.stage.graph import class_of

LONGEST_TEXT = 2000
"""Of a sentence on diagnostics or in the log [letters]; what is quoted of input is shorter."""

_FLOATS = ('double', 'float')

_SEVERAL = re.compile(r'sequence<([^,>]+)(?:, *\d+)?>$|(.+)\[\d+\]$')
"""Types of several elements: a sequence, perhaps with a bound, or an array."""


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
    for name, form in _forms(message.__class__).numbers:
        value = getattr(message, name)
        here = f'{path}.{name}'
        if form is _Form.SINGLE:
            if not math.isfinite(value):
                yield here, float(value)
        elif form is _Form.SEQUENCE:
            bad = np.flatnonzero(~np.isfinite(np.asarray(value, float)))
            if bad.size:
                yield f'{here}[{bad[0]}]', float(value[int(bad[0])])
        elif form is _Form.MESSAGE:
            yield from _not_finite(value, here)
        else:
            for index, element in enumerate(value):
                yield from _not_finite(element, f'{here}[{index}]')


def _lengths(message: Any, path: str) -> Iterator[tuple[str, int]]:
    for name, form in _forms(message.__class__).texts:
        value = getattr(message, name)
        here = f'{path}.{name}'
        if form is _Form.SINGLE:
            yield here, len(value)
        elif form is _Form.SEQUENCE:
            yield from ((f'{here}[{index}]', len(text)) for index, text in enumerate(value))
        elif form is _Form.MESSAGE:
            yield from _lengths(value, here)
        else:
            for index, element in enumerate(value):
                yield from _lengths(element, f'{here}[{index}]')


class _Form(Enum):
    """What a field holds."""

    SINGLE = 'one number or text'
    SEQUENCE = 'several of them'
    MESSAGE = 'a message that holds some'
    MESSAGES = 'several messages that hold some'


@dataclass(frozen=True)
class _Forms:
    """The fields of a class of messages that hold numbers or texts, at any depth."""

    numbers: tuple[tuple[str, _Form], ...]
    texts: tuple[tuple[str, _Form], ...]


@cache
def _forms(kind: Any) -> _Forms:
    """Look through the fields of a class once: it is asked for with every message."""
    numbers: list[tuple[str, _Form]] = []
    texts: list[tuple[str, _Form]] = []
    for name, declared in kind.get_fields_and_field_types().items():
        several = _SEVERAL.match(declared)
        element = several[1] or several[2] if several else declared
        if '/' in element:
            package, inner = element.split('/')
            inside = _forms(class_of(f'{package}/msg/{inner}'))
            form = _Form.MESSAGES if several else _Form.MESSAGE
            holds = (bool(inside.numbers), bool(inside.texts))
        else:
            form = _Form.SEQUENCE if several else _Form.SINGLE
            holds = (element in _FLOATS, element.startswith('string'))
        for fields, is_held in zip((numbers, texts), holds):
            if is_held:
                fields.append((name, form))
    return _Forms(tuple(numbers), tuple(texts))
