"""
Figures of a benchmark, each with what it should be, and the table that shows them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from rich.console import Console
from rich.table import Table


@dataclass(frozen=True)
class Criterion:
    """One figure, and what it should be."""

    name: str
    value: float | None
    """None if it could not be measured."""
    unit: str
    bar: str
    """What it should be, for example ``<= 0.05``; empty if it is only to be known."""
    holds: bool | None
    """None where there is no bar."""


def at_most(name: str, value: float | None, unit: str, limit: float) -> Criterion:
    """Make a bar that a value must not exceed."""
    return _bar(name, value, unit, f'<= {limit:g}', value is not None and value <= limit)


def at_least(name: str, value: float | None, unit: str, limit: float) -> Criterion:
    """Make a bar that a value must reach."""
    return _bar(name, value, unit, f'>= {limit:g}', value is not None and value >= limit)


def figure(name: str, value: float | None, unit: str) -> Criterion:
    """Make an entry for a value that is only to be known."""
    return _bar(name, value, unit, '', None)


def _bar(name: str, value: float | None, unit: str, bar: str, holds: bool | None) -> Criterion:
    """Make a bar of Python's own numbers: NumPy's do not go into JSON."""
    number = None if value is None or not math.isfinite(value) else float(value)
    return Criterion(name, number, unit, bar, None if holds is None else bool(holds))


def make_console(stderr: bool) -> Console:
    """Make a console that does not squeeze tables where there is no terminal."""
    console = Console(stderr=stderr)
    return console if console.is_terminal else Console(stderr=stderr, width=160)


def print_bars(console: Console, title: str, bars: list[Criterion]) -> None:
    """Print bars as a table."""
    table = Table('measured', 'value', 'unit', 'bar', 'holds', title=title)
    for bar in bars:
        value = 'not measured' if bar.value is None else f'{bar.value:.4g}'
        holds = {True: 'yes', False: 'NO', None: ''}[bar.holds]
        table.add_row(bar.name, value, bar.unit, bar.bar, holds)
    console.print(table)
