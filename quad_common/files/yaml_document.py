"""
One reader for every YAML file: keys and values, within bounds.

Files that people write or download may be damaged or hostile. Size, depth and the number of
values are bounded, those that aliases repeat included; integers have at most 64 bits; dates are
text, for none of our formats has any; and a key may stand in a mapping once.
"""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any

import yaml
from yaml.composer import Composer
from yaml.constructor import SafeConstructor
from yaml.resolver import Resolver

from quad_common.errors import FileEntryInvalid, FileUnusable, OutOfRange, QuadError, UnknownKey
from quad_common.errors.quoting import clipped, shown
from quad_common.files.bounded_file import LARGEST_TEXT, read_text

LARGEST_DEPTH = 20
"""Largest depth of mappings and lists in one another; shipped files have 4."""

MOST_VALUES = 4_000
"""Keys, values, mappings and lists of a file, counted as often as aliases repeat them; of files
that programs write there may be more."""

_TAG = 'tag:yaml.org,2002:'
_TAGS = tuple(f'{_TAG}{kind}' for kind in ('null', 'bool', 'int', 'float', 'str', 'seq', 'map'))
_MERGE = f'{_TAG}merge'
_TIMESTAMP = f'{_TAG}timestamp'

_LONGEST_INTEGER = 66
"""Characters of an integer of 64 bits in the longest notation, binary with its sign."""

_LONGEST_KEY = 100
"""Characters of the longest key that is told of."""


def read_yaml(
    path: Path,
    what: str,
    example: str,
    limit: int = LARGEST_TEXT,
    most_values: int = MOST_VALUES,
) -> dict[str, Any]:
    """
    Read a YAML file that holds keys.

    Parameters
    ----------
    path : Path
        The file.
    what : str
        What it is, for the error's sentence, for example ``map file``.
    example : str
        What it must hold, as the end of the sentence "it must hold ...".
    limit : int
        Largest size [bytes].
    most_values : int
        Largest number of keys, values, mappings and lists.

    Returns
    -------
    dict of str to object
        Its keys and values: None, bool, int, float, str, lists and dictionaries of them.

    Raises
    ------
    FileUnusable
        If it cannot be read, is not YAML, holds no keys, or is beyond a bound.
    """
    text = read_text(path, what, limit)
    try:
        document = _loaded(text, most_values)
    except yaml.MarkedYAMLError as error:
        raise FileUnusable(what, path, f'is not YAML: {_place(error)}') from error
    except (yaml.YAMLError, ValueError, LookupError, TypeError) as error:
        # Values that do not suit their explicit tags, such as !!bool 7.
        reason = clipped(' '.join(str(error).split()))
        raise FileUnusable(what, path, f'is not YAML: {reason}') from error
    if not isinstance(document, dict) or not document:
        raise FileUnusable(what, path, f'must hold {example}')
    return document


def check_keys(document: Mapping[str, Any], valid: Collection[str], name: str = '') -> None:
    """
    Refuse keys that mean nothing.

    Parameters
    ----------
    document : mapping
        What a file holds, or a part of it.
    valid : collection of str
        The keys that mean something.
    name : str
        Of the part; empty for the whole.

    Raises
    ------
    UnknownKey
        Naming the first key that means nothing, and those that do.
    """
    for key in document:
        if key not in valid:
            raise UnknownKey(name, key, valid)


def in_file(
    error: QuadError, what: str, path: Path, kind: type[FileEntryInvalid], ranged: type[OutOfRange]
) -> QuadError:
    """
    Return an error about an entry as one about the file that it stands in.

    Parameters
    ----------
    error : QuadError
        What is wrong with the entry.
    what : str
        What the file is.
    path : Path
        The file.
    kind : type
        Error of this kind of file about any other entry.
    ranged : type
        Error of this kind of file about a quantity outside its range.

    Returns
    -------
    QuadError
        Of one of the two kinds.
    """
    if isinstance(error, OutOfRange):
        return error.at(f'{what} {path}: ', ranged)
    return kind(what, path, error)


def _loaded(text: str, most_values: int) -> Any:
    """
    Load a document.

    By libyaml's parser, where PyYAML has it, in a sixth of the time; PyYAML's own says what is
    wrong, so that it is said in the same words everywhere.
    """
    if _QUICK_LOADER is not None:
        with contextlib.suppress(yaml.YAMLError, ValueError, LookupError, TypeError):
            return _document(_QUICK_LOADER(text, most_values))
    return _document(_BoundedLoader(text, most_values))


def _document(loader: Any) -> Any:
    try:
        return loader.get_single_data()
    finally:
        loader.dispose()


class _Bounds:
    """What a loader refuses: the too large, the too deep and the ambiguous."""

    yaml_constructors = {  # noqa: RUF012 as PyYAML declares it
        tag: constructor
        for tag, constructor in yaml.SafeLoader.yaml_constructors.items()
        if tag is None or tag in _TAGS
    }
    yaml_implicit_resolvers = {  # noqa: RUF012 as PyYAML declares it
        first: [(tag, pattern) for tag, pattern in resolvers if tag != _TIMESTAMP]
        for first, resolvers in yaml.SafeLoader.yaml_implicit_resolvers.items()
    }

    def begin(self, most_values: int) -> None:
        """Count from nothing up to a number of keys and values."""
        self._most_values = most_values
        self._depth = 0
        self._count = 0
        self._counts: dict[int, int] = {}

    def compose_node(self, parent: yaml.Node | None, index: Any) -> yaml.Node | None:
        """Compose a node, and count what it holds with the aliases in it written out."""
        event = self.peek_event()  # type: ignore[attr-defined]
        if self._depth >= LARGEST_DEPTH:
            raise _beyond(f'it is nested deeper than {LARGEST_DEPTH}, which is the limit', event)
        is_alias = isinstance(event, yaml.AliasEvent)
        before = self._count
        self._depth += 1
        node: yaml.Node | None = super().compose_node(parent, index)  # type: ignore[misc]
        self._depth -= 1
        if is_alias:
            # A node that is not counted yet is one that the alias stands in.
            if id(node) not in self._counts:
                raise _beyond('an alias stands in what it repeats', event)
            self._count += self._counts[id(node)]
        else:
            self._count += 1
            self._counts[id(node)] = self._count - before
        if self._count > self._most_values:
            raise _beyond(
                f'it holds more than {self._most_values} keys and values, aliases written out, '
                'which is the limit',
                event,
            )
        return node

    def compose_mapping_node(self, anchor: Any) -> yaml.MappingNode:
        """Compose a mapping whose keys are texts that differ."""
        node: yaml.MappingNode = super().compose_mapping_node(anchor)  # type: ignore[misc]
        seen = set()
        for key, _ in node.value:
            if key.tag == _MERGE:
                continue
            if not isinstance(key, yaml.ScalarNode) or key.tag != f'{_TAG}str':
                raise yaml.MarkedYAMLError(None, None, 'a key is not a text', key.start_mark)
            if key.value in seen:
                told = shown(key.value, _LONGEST_KEY)
                raise yaml.MarkedYAMLError(
                    None, None, f'the key {told} is there twice', key.start_mark
                )
            seen.add(key.value)
        return node

    def construct_yaml_int(self, node: yaml.ScalarNode) -> int:
        """Make an integer of at most 64 bits."""
        text = str(self.construct_scalar(node))  # type: ignore[attr-defined]
        if len(text) <= _LONGEST_INTEGER:
            value = int(super().construct_yaml_int(node))  # type: ignore[misc]
            if -(2**63) <= value < 2**64:
                return value
        raise yaml.MarkedYAMLError(
            None,
            None,
            f'an integer of {len(text)} digits; integers have at most 64 bits',
            node.start_mark,
        )


_Bounds.yaml_constructors[f'{_TAG}int'] = _Bounds.construct_yaml_int


class _BoundedLoader(_Bounds, yaml.SafeLoader):
    """PyYAML's safe loader within the bounds."""

    def __init__(self, stream: str, most_values: int) -> None:
        yaml.SafeLoader.__init__(self, stream)
        self.begin(most_values)


def _quick_loader() -> Any:
    """Return the same by libyaml's parser; None where PyYAML is built without it."""
    if not yaml.__with_libyaml__:
        return None
    parser: Any = importlib.import_module('yaml.cyaml').CParser

    class QuickLoader(_Bounds, Composer, parser, SafeConstructor, Resolver):  # type: ignore[misc]
        """Composes in Python, where the bounds are, what libyaml parses."""

        def __init__(self, stream: str, most_values: int) -> None:
            parser.__init__(self, stream)
            for part in (Composer, SafeConstructor, Resolver):
                part.__init__(self)
            self.begin(most_values)

    return QuickLoader


_QUICK_LOADER = _quick_loader()


def _beyond(problem: str, event: Any) -> yaml.MarkedYAMLError:
    return yaml.MarkedYAMLError(None, None, problem, event.start_mark)


def _place(error: yaml.MarkedYAMLError) -> str:
    """Say what is wrong and where, on one line."""
    mark = error.problem_mark or error.context_mark
    parts = [error.context, error.problem]
    said = ' '.join(' '.join(part.split()) for part in parts if part)
    if mark is None:
        return clipped(said)
    return clipped(f'{said} (line {mark.line + 1}, column {mark.column + 1})')
