"""
``quadwalk bench``: measurements, each a table or, with ``--json``, one object of bars.
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
from dataclasses import asdict, dataclass
from types import ModuleType

from rich.console import Console
from rich.table import Table

from quad_cli.arguments import seed_argument
from quad_common.errors import ParameterError

BENCHMARKS = {
    'walk': 'quad_cli.bench_walk',
    'gaits': 'quad_cli.bench_gaits',
    'planner': 'quad_cli.bench_planner',
    'camera': 'quad_cli.bench_camera',
    'terrain': 'quad_cli.bench_terrain',
    'localisation': 'quad_cli.bench_localisation',
    'faults': 'quad_cli.bench_faults',
    'matrix': 'quad_cli.bench_matrix',
}
"""The module of each benchmark."""

EXAMPLES = """examples:
  quadwalk bench walk --quick
  quadwalk bench walk --json > walk.json
  quadwalk bench gaits
  quadwalk bench planner --quick
  quadwalk bench camera --quick
  quadwalk bench terrain --quick
  quadwalk bench localisation --quick
  quadwalk bench faults --only messages kills
  quadwalk bench matrix --only pukyong wave
"""


@dataclass(frozen=True)
class Bar:
    """One figure, and what it should be."""

    name: str
    value: float | None
    """None if it could not be measured."""
    unit: str
    bar: str
    """What it should be, for example ``<= 0.05``; empty if it is only to be known."""
    holds: bool | None
    """None where there is no bar."""


def at_most(name: str, value: float | None, unit: str, limit: float) -> Bar:
    """Make a bar that a value must not exceed."""
    return _bar(name, value, unit, f'<= {limit:g}', value is not None and value <= limit)


def at_least(name: str, value: float | None, unit: str, limit: float) -> Bar:
    """Make a bar that a value must reach."""
    return _bar(name, value, unit, f'>= {limit:g}', value is not None and value >= limit)


def figure(name: str, value: float | None, unit: str) -> Bar:
    """Make an entry for a value that is only to be known."""
    return _bar(name, value, unit, '', None)


def _bar(name: str, value: float | None, unit: str, bar: str, holds: bool | None) -> Bar:
    """Make a bar of Python's own numbers: NumPy's do not go into JSON."""
    number = None if value is None or not math.isfinite(value) else float(value)
    return Bar(name, number, unit, bar, None if holds is None else bool(holds))


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('benchmark', choices=sorted(BENCHMARKS))
    parser.add_argument('--quick', action='store_true', help='a sample that ends within 45 s')
    parser.add_argument('--seed', type=seed_argument, default=0, help='of what is drawn at random')
    parser.add_argument(
        '--only', nargs='+', default=[], metavar='PART', help='of benchmarks that have parts'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if every bar holds."""
    console = make_console(stderr=arguments.json)
    module = importlib.import_module(BENCHMARKS[arguments.benchmark])
    only = _parts(arguments.benchmark, module, arguments.only)
    bars, details = module.measure(console, arguments.quick, arguments.seed, **only)
    if arguments.json:
        print(json.dumps({'bars': [asdict(bar) for bar in bars], **details}))
    else:
        print_bars(console, f'quadwalk bench {arguments.benchmark}', bars)
    return 0 if all(bar.holds is not False for bar in bars) else 1


def _parts(benchmark: str, module: ModuleType, wanted: list[str]) -> dict[str, tuple[str, ...]]:
    """Return the argument ``only`` of a benchmark that is run in part; ParameterError if not so."""
    if not wanted:
        return {}
    parts = tuple(getattr(module, 'PARTS', ()))
    for name in wanted:
        if name not in parts:
            valid = f'one of {", ".join(parts)}' if parts else f'left out: {benchmark} has no parts'
            raise ParameterError('--only', name, valid)
    return {'only': tuple(wanted)}


def make_console(stderr: bool) -> Console:
    """Make a console that does not squeeze tables where there is no terminal."""
    console = Console(stderr=stderr)
    return console if console.is_terminal else Console(stderr=stderr, width=160)


def print_bars(console: Console, title: str, bars: list[Bar]) -> None:
    """Print bars as a table."""
    table = Table('measured', 'value', 'unit', 'bar', 'holds', title=title)
    for bar in bars:
        value = 'not measured' if bar.value is None else f'{bar.value:.4g}'
        holds = {True: 'yes', False: 'NO', None: ''}[bar.holds]
        table.add_row(bar.name, value, bar.unit, bar.bar, holds)
    console.print(table)
