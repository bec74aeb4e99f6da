"""
The cases of the attack on files: each is drawn from a seed, its kind and its number.
"""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
import shutil
import traceback
import zlib
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from quad_common.errors import QuadError
from quad_common.errors.quoting import clipped
from quad_lab.attacks.files.argument_cases import (
    CommandLine,
    changed_command,
    run_in_process,
    without_work,
)
from quad_lab.attacks.files.file_kinds import KINDS, FileKind, document_of
from quad_lab.attacks.files.hostile import Change, changed_document, damaged, put_something_else

TRACEBACK = 'traceback'
HANG = 'hang'
NONSENSE = 'nonsense'
"""What may go wrong."""

ARGUMENTS = 'command line'
"""Name of the kind that is no file."""

NAMES = (*(kind.name for kind in KINDS), ARGUMENTS)
"""Every kind that is attacked."""


@dataclass(frozen=True)
class Fault:
    """One case that went wrong."""

    what: str
    """:data:`TRACEBACK`, :data:`HANG` or :data:`NONSENSE`."""
    kind: str
    """Name of the kind of file."""
    seed: int
    """Seed of the attack."""
    index: int
    """Number of the case within its kind."""
    sentence: str
    """What was done, and what came of it."""

    def as_dict(self) -> dict[str, object]:
        """Return the fields as JSON has them."""
        return asdict(self)


def run_case(seed: int, kind: str, index: int, folder: Path) -> Fault | None:
    """
    Try one case.

    Parameters
    ----------
    seed : int
        Seed of the attack.
    kind : str
        One of :data:`NAMES`.
    index : int
        Number of the case.
    folder : Path
        An empty folder, which is the current one; it is left full of files.

    Returns
    -------
    Fault or None
        None if all went well.
    """
    if kind == ARGUMENTS:
        return _run_arguments(seed, index, folder)
    file_kind = next(entry for entry in KINDS if entry.name == kind)
    rng = _rng(seed, kind, index)
    path = file_kind.write(folder, index)
    change = _attack(rng, file_kind, path)
    try:
        read = file_kind.read(path)
    except QuadError as error:
        return _wrong_sentence(seed, kind, index, change, str(error))
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        sentence = f'{change.text}: {type(error).__name__} in {place.name}: {error}'
        return Fault(TRACEBACK, kind, seed, index, clipped(sentence))
    range_ = file_kind.range_of(change.key) if change.key else None
    is_outside = (
        range_ is not None
        and change.number is not None
        and not range_.lower <= change.number <= range_.upper
    )
    if is_outside or (change.is_unknown_key and not file_kind.may_have(change.key)):
        return Fault(NONSENSE, kind, seed, index, f'{change.text} was accepted')
    where = _not_finite(read)
    if where:
        return Fault(NONSENSE, kind, seed, index, f'{change.text} made {where} not finite')
    return None


def command_line(seed: int, index: int, only_failing: bool = False) -> CommandLine:
    """Draw the command line of a case."""
    return changed_command(_rng(seed, ARGUMENTS, index), only_failing)


def write_all(folder: Path) -> None:
    """Write a valid file of each kind into a folder, and what is no file."""
    for kind in KINDS:
        kind.write(folder, 0)
    os.mkfifo(folder / 'pipe')
    (folder / 'folder').mkdir()
    (folder / 'loop').symlink_to(folder / 'loop')
    (folder / 'bad.yaml').write_bytes(b'\xff\0')


def _run_arguments(seed: int, index: int, folder: Path) -> Fault | None:
    write_all(folder)
    line = command_line(seed, index)
    told = clipped(f'quadwalk {" ".join(word[:100] for word in line.arguments)}')
    try:
        with without_work():
            wrong = run_in_process(line)
    except Exception as error:
        place = traceback.extract_tb(error.__traceback__)[-1]
        sentence = f'{told}: {type(error).__name__} in {place.name}: {error}'
        return Fault(TRACEBACK, ARGUMENTS, seed, index, clipped(sentence))
    if not wrong:
        return None
    what = NONSENSE if 'let through' in wrong else TRACEBACK
    return Fault(what, ARGUMENTS, seed, index, clipped(f'{told}: {wrong}'))


def _attack(rng: np.random.Generator, kind: FileKind, path: Path) -> Change:
    """Change a file, or the image beside it, or put something else in its place."""
    draw = rng.random()
    image = path.with_name(kind.image) if kind.image else path
    if draw < 0.08:
        target = image if rng.random() < 0.5 else path
        return Change(f'{target.name}: {put_something_else(rng, target)}')
    if not kind.is_document or draw < 0.3:
        target = image if rng.random() < 0.5 else path
        content, what = damaged(rng, target.read_bytes())
        target.write_bytes(content)
        return Change(f'{target.name}: {what}')
    with contextlib.suppress(FileExistsError):
        os.mkfifo(path.with_name('pipe'))
        path.with_name('folder').mkdir()
    content, change = changed_document(rng, document_of(path))
    path.write_bytes(content)
    return change


def _wrong_sentence(
    seed: int, kind: str, index: int, change: Change, sentence: str
) -> Fault | None:
    """Refuse refusals that are no sentence."""
    if '\n' not in sentence and 0 < len(sentence) <= 2000:
        return None
    told = f'{change.text}: told in {len(sentence)} characters on several lines'
    return Fault(TRACEBACK, kind, seed, index, told)


def _not_finite(value: object, name: str = '') -> str:
    """Name the first number of a value that is not finite; empty if there is none."""
    if isinstance(value, float) and not math.isfinite(value):
        return name or 'a number'
    if isinstance(value, np.ndarray) and value.dtype.kind == 'f':
        # Heights may be unknown.
        wrong = np.isinf(value) if name.endswith('heights') else ~np.isfinite(value)
        return name if wrong.any() else ''
    for key, part in _parts(value):
        found = _not_finite(part, f'{name}.{key}' if name else str(key))
        if found:
            return found
    return ''


def _parts(value: object) -> Iterator[tuple[object, object]]:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        yield from ((entry.name, getattr(value, entry.name)) for entry in dataclasses.fields(value))
    elif isinstance(value, dict):
        yield from value.items()
    elif isinstance(value, (list, tuple)):
        yield from enumerate(value)


def _rng(seed: int, kind: str, index: int) -> np.random.Generator:
    """Return what decides about one case."""
    # By its name: cases stay what they are where another kind joins.
    return np.random.default_rng((seed, zlib.crc32(kind.encode()), index))


def emptied(folder: Path) -> Path:
    """Remove all that is in a folder."""
    for path in folder.iterdir():
        if path.is_dir() and not path.is_symlink():
            shutil.rmtree(path)
        else:
            path.unlink()
    return folder
