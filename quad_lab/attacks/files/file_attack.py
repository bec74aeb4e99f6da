"""
The attack on files and command lines: every kind of file and command, changed in many ways.

Cases are numbered, and each is drawn from the seed, its kind and its number alone: one that is
found can be repeated by itself. They run in a process of their own, which has a limited time
for each of them.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field

from rich.console import Console

from quad_common.process.temporary_folder import temporary_folder
from quad_lab.attacks.files.argument_cases import wrong_end
from quad_lab.attacks.files.file_cases import (
    ARGUMENTS,
    HANG,
    NAMES,
    NONSENSE,
    TRACEBACK,
    Fault,
    command_line,
    write_all,
)
from quad_lab.attacks.files.file_worker import Worker
from quad_lab.tools.criterion import Criterion, at_most, figure

TIME_LIMIT = 2.0
"""Of the processor, for a case [s]."""

_PATIENCE = 20.0
"""For a command in a process of its own, whose start takes longest on a busy machine [s]."""

_KEPT = 5
"""Faults of a kind that are told of."""

_COUNT = 300
_QUICK_COUNT = 12
_COMMANDS = 40
_QUICK_COMMANDS = 1
"""Cases of each kind, and commands that are run in processes of their own."""

Progress = Callable[[str, int, int], None]
"""It is told the kind, the cases done of it, and how many there are."""


@dataclass
class FileAttackResult:
    """What an attack found."""

    cases: int = 0
    """Number of files and command lines that were tried."""
    duration: float = 0.0
    """Time that it took [s]."""
    faults: list[Fault] = field(default_factory=list)
    """All that went wrong, in the order of the cases."""

    def count(self, what: str) -> int:
        """Return how many faults there are of one sort."""
        return sum(fault.what == what for fault in self.faults)

    def kept(self) -> list[dict[str, object]]:
        """Return the first few faults of each sort, as JSON has them."""
        sorts = (TRACEBACK, HANG, NONSENSE)
        kept = [[fault for fault in self.faults if fault.what == what][:_KEPT] for what in sorts]
        return [fault.as_dict() for faults in kept for fault in faults]


def attack_files(
    seed: int,
    count: int,
    on_progress: Progress | None = None,
    commands: int = 0,
    kinds: tuple[str, ...] = NAMES,
) -> FileAttackResult:
    """
    Attack every kind of file, and the command line.

    Parameters
    ----------
    seed : int
        Of what is drawn at random.
    count : int
        Cases of each kind.
    on_progress : callable, optional
        Called after each case.
    commands : int
        How many command lines are also run in processes of their own.
    kinds : tuple of str
        What is attacked, of :data:`quad_lab.attacks.files.file_cases.NAMES`.

    Returns
    -------
    FileAttackResult
        How many cases there were, and all that went wrong.
    """
    began = time.monotonic()
    result = FileAttackResult()
    with Worker(seed) as worker:
        for kind in kinds:
            for index in range(count):
                fault = worker.run(kind, index, TIME_LIMIT)
                result.cases += 1
                if fault is not None:
                    result.faults.append(fault)
                if on_progress is not None:
                    on_progress(kind, index + 1, count)
    result.faults += _run_commands(seed, commands)
    result.cases += commands
    result.duration = time.monotonic() - began
    return result


def measure_files(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Attack, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A small sample of every kind.
    seed : int
        Of what is drawn at random.

    Returns
    -------
    tuple
        The bars, and for JSON what went wrong.
    """

    def show(kind: str, done: int, count: int) -> None:
        if done == count:
            console.print(f'{kind}: {count} cases')

    count, commands = (_QUICK_COUNT, _QUICK_COMMANDS) if quick else (_COUNT, _COMMANDS)
    result = attack_files(seed, count, show, commands)
    kept = result.kept()
    for fault in kept:
        console.print(f'{fault["what"]}: {fault["sentence"]}', markup=False, soft_wrap=True)
    bars = [
        at_most('tracebacks', result.count(TRACEBACK), '', 0.0),
        at_most('hangs over 2 s', result.count(HANG), '', 0.0),
        at_most('nonsense accepted', result.count(NONSENSE), '', 0.0),
        figure('files and command lines', result.cases, ''),
        figure('duration', result.duration, 's'),
    ]
    return bars, {'faults': kept}


def _run_commands(seed: int, count: int) -> list[Fault]:
    """Run command lines that must be refused as a user does, one after the other."""
    faults = []
    with temporary_folder() as folder:
        write_all(folder)
        for index in range(count):
            # An argument of a process can hold neither a null byte nor more than 128 kB.
            line = command_line(seed, index, only_failing=True)
            what, wrong = TRACEBACK, ''
            try:
                ended = subprocess.run(
                    [sys.executable, '-m', 'quad_cli', *line.arguments],
                    cwd=folder,
                    stdin=subprocess.DEVNULL,
                    capture_output=True,
                    text=True,
                    errors='replace',
                    timeout=_PATIENCE,
                    check=False,
                )
                wrong = wrong_end(line, ended.returncode, ended.stderr)
            except subprocess.TimeoutExpired:
                what, wrong = HANG, f'no end within {_PATIENCE:g} s'
            if wrong:
                faults.append(Fault(what, ARGUMENTS, seed, index, f'{line.arguments}: {wrong}'))
    return faults
