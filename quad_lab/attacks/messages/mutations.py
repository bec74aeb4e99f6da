"""
Hostile messages: valid ones in which one field is changed.

Fields are found from the message classes themselves, so that every message type is covered,
and one that is new as well. Nothing here needs a running ROS.
"""

from __future__ import annotations

import copy
from collections import Counter
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from quad_lab.attacks.messages.changes import GIANTS, changes_of, element_kind

Path = tuple[str | int, ...]
Item = TypeVar('Item')

UNCHANGED = 'unchanged'
"""Kind of a mutation that leaves the message as it is."""

_SHARE_UNCHANGED = 0.05
"""Of messages that are sent as they are."""

_FEW = 3
"""Elements of a sequence whose own fields are changed: the first, the last and one between."""


@dataclass(frozen=True)
class Mutation:
    """A message with one field changed."""

    field: str
    """Path of the field, for example ``pose.pose.position.x`` or ``points[0].positions``."""
    kind: str
    """What was done to it, in a word or two."""
    message: Any
    """The changed message; its parts that are not changed belong to the original too."""

    def __str__(self) -> str:
        return f'{self.field}: {self.kind}'


@dataclass(frozen=True)
class Leaf:
    """A field of a message that can be changed."""

    path: Path
    """How to get there: names of fields, and indices of sequences."""
    kind: str
    """Its ROS type, for example ``double`` or ``sequence<string>``."""

    @property
    def name(self) -> str:
        """The path as text."""
        text = ''
        for part in self.path:
            text += f'[{part}]' if isinstance(part, int) else f'.{part}'
        return text.lstrip('.')


def leaves_of(message: Any) -> list[Leaf]:
    """
    List the fields of a message that can be changed.

    Parameters
    ----------
    message : message
        Of any class that has ``get_fields_and_field_types``.

    Returns
    -------
    list of Leaf
        Numbers, texts, sequences as a whole, and the fields of some of their elements.
    """
    return list(_leaves(message, ()))


class Mutator:
    """
    Changes fields of messages of one topic, so that all fields take turns.

    Parameters
    ----------
    rng : numpy.random.Generator
        Of what is changed how.
    """

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._uses: Counter[tuple[str, str]] = Counter()
        """How often a field was changed (with an empty word), and how often in which way."""

    def draw(self, message: Any) -> Mutation:
        """
        Change a field that was changed least often so far, in a way that is as new.

        Parameters
        ----------
        message : message
            A valid one; it is left as it is.

        Returns
        -------
        Mutation
            Now and then, and of a message without fields, the message unchanged.
        """
        leaves = leaves_of(message)
        if not leaves or self._rng.random() < _SHARE_UNCHANGED:
            return Mutation('', UNCHANGED, message)
        leaf = self._least_used(leaves, lambda leaf: (leaf.name, ''))
        changes = list(changes_of(_get(message, leaf.path), leaf.kind))
        kind, make = self._least_used(changes, lambda change: (leaf.name, change[0]))
        self._uses[leaf.name, ''] += 1
        self._uses[leaf.name, kind] += 1
        return Mutation(leaf.name, kind, replaced(message, leaf.path, make()))

    def _least_used(self, items: list[Item], key: Callable[[Item], tuple[str, str]]) -> Item:
        uses = [self._uses[key(item)] for item in items]
        least = [item for item, count in zip(items, uses) if count == min(uses)]
        return least[int(self._rng.integers(len(least)))]


def giants_of(message: Any) -> Iterator[Mutation]:
    """
    Make a message far too long, in one field after the other.

    Parameters
    ----------
    message : message
        A valid one; it is left as it is.

    Yields
    ------
    Mutation
        One for each field that is a text or a sequence.
    """
    for leaf in leaves_of(message):
        for kind, make in changes_of(_get(message, leaf.path), leaf.kind):
            if kind in GIANTS:
                yield Mutation(leaf.name, kind, replaced(message, leaf.path, make()))


def random_bytes(data: bytes, rng: np.random.Generator) -> tuple[str, bytes]:
    """
    Damage a message as it is sent.

    Parameters
    ----------
    data : bytes
        A valid message (CDR).
    rng : numpy.random.Generator
        Of the damage.

    Returns
    -------
    tuple of str and bytes
        What was done, and the result.
    """
    kind = ('cut off', 'flipped bits', 'noise', 'longer')[int(rng.integers(4))]
    # The first four bytes say how it is encoded; without them it is no message at all.
    head, body = data[:4], np.frombuffer(data[4:], np.uint8).copy()
    if kind == 'cut off':
        body = body[: int(rng.integers(len(body) + 1))]
    elif kind == 'flipped bits' and len(body):
        places = rng.integers(len(body), size=int(rng.integers(1, 9)))
        body[places] ^= rng.integers(1, 256, size=len(places)).astype(np.uint8)
    elif kind == 'noise':
        body = rng.integers(0, 256, size=int(rng.integers(1, 400))).astype(np.uint8)
    else:
        body = np.concatenate([body, np.zeros(int(rng.integers(1, 400)), np.uint8)])
    return kind, head + body.tobytes()


def replaced(message: Any, path: Path, value: object) -> Any:
    """
    Copy a message with another value at a place.

    Parameters
    ----------
    message : message or sequence
        Left as it is.
    path : tuple of str or int
        The place.
    value : object
        What stands there in the copy.

    Returns
    -------
    message or sequence
        The copy.
    """
    if not path:
        return value
    first, *rest = path
    changed = copy.copy(message)
    if isinstance(first, int):
        changed[first] = replaced(message[first], tuple(rest), value)
    else:
        setattr(changed, first, replaced(getattr(message, first), tuple(rest), value))
    return changed


def _leaves(message: Any, path: Path) -> Iterator[Leaf]:
    for name, kind in message.get_fields_and_field_types().items():
        here = (*path, name)
        value = getattr(message, name)
        if hasattr(value, 'get_fields_and_field_types'):
            if set(value.get_fields_and_field_types()) == {'sec', 'nanosec'}:
                yield Leaf(here, 'stamp')
            yield from _leaves(value, here)
        else:
            yield Leaf(here, kind)
            yield from _element_leaves(value, element_kind(kind), here)


def _element_leaves(values: Any, kind: str | None, path: Path) -> Iterator[Leaf]:
    if kind is None:
        return
    count = len(values)
    for index in sorted({0, count // 2, count - 1} if count >= _FEW else set(range(count))):
        if hasattr(values[index], 'get_fields_and_field_types'):
            yield from _leaves(values[index], (*path, index))
        else:
            yield Leaf((*path, index), kind)


def _get(message: Any, path: Path) -> Any:
    for part in path:
        message = message[part] if isinstance(part, int) else getattr(message, part)
    return message
