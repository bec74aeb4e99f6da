"""
``quadwalk doctor``: what works on this machine, what is missing, and what mends it.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Iterator
from dataclasses import asdict

from rich.console import Console
from rich.table import Table

from quad_lab.doctor.engine_checks import check_engines
from quad_lab.doctor.finding import Finding, State
from quad_lab.doctor.machine_checks import (
    check_files,
    check_port,
    check_processors,
    check_python,
)
from quad_lab.doctor.ros_checks import check_ros

EXAMPLES = """examples:
  quadwalk doctor
  quadwalk doctor --json
"""

CHECKS: tuple[Callable[[], Iterator[Finding]], ...] = (
    check_python,
    check_ros,
    check_engines,
    check_files,
    check_port,
    check_processors,
)
"""What is checked, in this order."""

_SUBJECT = 21
"""Width of the column of what was looked at."""

_MARKS = {
    State.GOOD: '[green]ok[/green]',
    State.OPTIONAL: '[yellow]--[/yellow]',
    State.WRONG: '[red]NO[/red]',
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if whatever everybody needs works."""
    console = Console(stderr=arguments.json)
    findings: list[Finding] = []
    with console.status('looking ...'):
        for check in CHECKS:
            for found in check():
                findings.append(found)
                if not arguments.json:
                    _print(console, found)
    works = all(found.state is not State.WRONG for found in findings)
    if arguments.json:
        told = [{**asdict(found), 'state': found.state.value} for found in findings]
        print(json.dumps({'works': works, 'findings': told}))
    elif works:
        console.print('quadwalk works here; "--" marks what only some need')
    else:
        console.print('quadwalk does not work here yet: mend what is marked NO')
    return 0 if works else 1


def _print(console: Console, found: Finding) -> None:
    """Print what a check has found at once: on a busy machine the next one takes its time."""
    from rich.markup import escape

    table = Table(show_header=False, box=None)
    table.add_column()
    table.add_column(width=_SUBJECT)
    table.add_column()
    table.add_row(_MARKS[found.state], found.subject, escape(found.said))
    if found.mend:
        table.add_row('', '', f'[bold]{escape(found.mend)}[/bold]')
    console.print(table)
    console.file.flush()
