"""
Hostile files: valid documents with one thing changed, and damaged bytes.
"""

from __future__ import annotations

import math
import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

Key = tuple[str | int, ...]
"""Where a value stands in a document: keys of mappings and places in lists."""

_PLACE = 'the-place-of-the-hostile-value'

_BOMB = '[&a [1], ' + ', '.join(
    f'&{b} [{", ".join([f"*{a}"] * 9)}]' for a, b in zip('abcdefgh', 'bcdefghi')
) + ']'  # fmt: skip
"""Aliases of aliases: nine to the power of nine values."""

NUMBERS = (
    '.nan', '.inf', '-.inf', '1.0e+300', '-1.0e+300', '1e300', '1e-300', '5.0e-324', '0', '-0.0',
    '-1', '1.0e+6', '-1.0e+6', '1.0e+12', '7', '1e400', '9' * 310, '9' * 5000, '-' + '9' * 310,
    '0x' + 'f' * 400, '1:' * 150 + '1', '0.0',
)  # fmt: skip
"""Numbers as YAML, most of them beyond any range."""

OTHERS = (
    'null', 'true', '[]', '{}', '""', 'moon', '[1, 2, 3]', '{a: 1}', '2001-99-99', '2001-01-01',
    '"a\\0b"', '"~no_such_user/x"', '/', '.', '/dev/zero', '/dev/stdin', 'pipe', 'folder',
    '../../../etc/passwd', '*undefined', '&a [*a]', _BOMB, '[' * 3000, '[' * 15 + ']' * 15,
    '!!python/object/apply:os.getcwd []', '!!timestamp x', '!!binary "%"', '!!int ""',
    '!!bool 7', '!!set {a}', 'x' * 10000, '"\\ud800"', '"\\u202e"', '"a\\nb"', '? [a]', '\t', '=',
    '<<', '[.nan, .nan, .nan]', '[1e300, -1e300, 1e300]', '[[[[]]]]',
)  # fmt: skip
"""Everything else that may stand in a number's place, as YAML."""

_WHOLE = (
    b'', b'\0', b'\xff\xfe', b'\xef\xbb\xbf', b'[' * 100_000, b'{a: ' * 50_000, b'- ' * 50_000,
    b'a: ' + b'9' * 200_000, b'? ' * 10_000, b'&a ' * 1000, b'a: &a [*a]', b'#' * 300_000,
    b'a: b: c: d', b'"' + b'x' * 100_000, b'%YAML 9.9\n---\n', b'---\n---\n---\n', b'- 1\n- 2\n',
    b'a: 1\n' * 1000, b'<<: [1]', b'<<: {<<: {<<: 3}}', b'\xed\xa0\x80: 1', b'1: 2', b'? {a: b}',
    'a: ä'.encode('utf-16'), b'a: |\n' + b' x\n' * 20_000, b'a: ' + b'\\' * 1000,
)  # fmt: skip
"""Whole files that are no documents, or hostile ones."""


@dataclass(frozen=True)
class Change:
    """What was done to a document."""

    text: str
    """Description for people."""
    key: Key = ()
    """Place of the value that was replaced or added; empty if it was something else."""
    number: float | None = None
    """The number that was put there; None if it was no number."""
    is_unknown_key: bool = False
    """Whether a key was added, or one was written twice."""


def numbers_and_others(rng: np.random.Generator, old: object) -> str:
    """Draw a hostile value as YAML; some are near to the old one."""
    draw = rng.random()
    if draw < 0.25 and isinstance(old, (int, float)) and not isinstance(old, bool):
        factor = float(rng.choice([-1.0, 1e3, -1e3, 1e6, 1e9, 1e30, 1e100, 1e-3, 1e-9, 1e-30]))
        return yaml.safe_dump(old * factor).split('\n')[0]
    return str(rng.choice(NUMBERS if draw < 0.65 else OTHERS))


def changed_document(rng: np.random.Generator, document: dict[str, Any]) -> tuple[bytes, Change]:
    """
    Change one thing in a document.

    Parameters
    ----------
    rng : numpy.random.Generator
        What decides.
    document : dict
        A valid document; it stays as it is.

    Returns
    -------
    content : bytes
        The changed document as YAML.
    change : Change
        What was done.
    """
    copy = yaml.safe_load(yaml.safe_dump(document))
    places = list(_places(copy))
    key, old = places[int(rng.integers(len(places)))]
    parent = _at(copy, key[:-1])
    draw = rng.random()
    if draw < 0.08:
        del parent[key[-1]]
        return _dumped(copy), Change(f'without {dotted(key)}')
    if draw < 0.16 and isinstance(parent, dict):
        parent[f'{key[-1]}_'] = old
        return _dumped(copy), Change(
            f'{dotted(key)}_ added', (*key[:-1], f'{key[-1]}_'), is_unknown_key=True
        )
    if draw < 0.22:
        name = str(next(iter(copy)))
        twice = _dumped({name: copy[name]})
        return _dumped(copy) + twice, Change(f'{name} twice', (name, name), is_unknown_key=True)
    value = numbers_and_others(rng, old)
    parent[key[-1]] = _PLACE
    text = _dumped(copy).decode().replace(_PLACE, value)
    shown = value if len(value) <= 60 else f'{value[:60]}...'
    return text.encode('utf-8', 'surrogatepass'), Change(
        f'{dotted(key)}: {shown}', key, _number(value)
    )


def damaged(rng: np.random.Generator, content: bytes) -> tuple[bytes, str]:
    """Damage a file's bytes; return them and what was done."""
    what = int(rng.integers(6))
    if what == 0:
        at = int(rng.integers(len(content)))
        return content[:at], f'cut after {at} bytes'
    if what == 1:
        index = int(rng.integers(len(_WHOLE)))
        return _WHOLE[index], f'replaced by {_WHOLE[index][:20]!r}'
    if what == 2:
        noise = rng.integers(0, 256, int(rng.integers(1, 2000)), dtype=np.uint8).tobytes()
        return noise, f'{len(noise)} bytes of noise'
    if what == 3:
        at, end = sorted(int(k) for k in rng.integers(0, len(content), 2))
        return content[:at] + content[at:end] * 20 + content[end:], f'{at} to {end} repeated'
    bytes_ = bytearray(content)
    # The first bytes tell format and size: they are hit as often as all others together.
    within = min(64, len(bytes_)) if what == 4 else len(bytes_)
    places = rng.integers(0, within, int(rng.integers(1, 9)))
    for at in places:
        bytes_[int(at)] = int(rng.choice([0, 255, 127, 128, int(rng.integers(256))]))
    return bytes(bytes_), f'bytes {sorted({int(at) for at in places})} changed'


def put_something_else(rng: np.random.Generator, path: Path) -> str:
    """Put something that is no regular file in a file's place; return what it is."""
    path.unlink(missing_ok=True)
    kind = str(rng.choice(['pipe', 'folder', 'loop', 'device', 'nothing', 'nowhere']))
    if kind == 'pipe':
        os.mkfifo(path)
    elif kind == 'folder':
        path.mkdir()
    elif kind != 'nothing':
        targets = {'loop': path, 'device': Path('/dev/zero'), 'nowhere': Path('/no/such/file')}
        path.symlink_to(targets[kind])
    return f'{kind} in its place'


def dotted(key: Key) -> str:
    """Return the name of a place in a document, for example ``origin.2``."""
    return '.'.join(map(str, key))


def _places(node: Any, key: Key = ()) -> Iterator[tuple[Key, Any]]:
    """List every place of a document with what stands there."""
    items: Any = node.items() if isinstance(node, dict) else enumerate(node)
    for name, child in items:
        yield (*key, name), child
        if isinstance(child, (dict, list)):
            yield from _places(child, (*key, name))


def _at(node: Any, key: Key) -> Any:
    for name in key:
        node = node[name]
    return node


def _dumped(document: Any) -> bytes:
    return yaml.safe_dump(document, sort_keys=False, width=10**9).encode()


def _number(value: str) -> float | None:
    """Return what a value is as a number; None if it is none."""
    if value in OTHERS:
        return None
    # Whole numbers of hundreds of digits, in whatever notation, are beyond any range.
    number = yaml.safe_load(value) if len(value) < 100 else math.inf
    return float(number)
