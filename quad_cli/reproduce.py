"""
``quadwalk reproduce``: measure and draw papers' figures again, beside the papers' values.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from quad_cli.arguments import folder_argument
from quad_lab.papers import reproduction
from quad_lab.papers.results import Results, Shown, counted
from quad_lab.tools.criterion import make_console

ALL = 'all'

EXAMPLES = """examples:
  quadwalk reproduce S3
  quadwalk reproduce all --quick
  quadwalk reproduce S4 --output pictures --json
  quadwalk reproduce all --output docs

The papers' titles are in docs/references.md. The folder gets reproduction.md, which is the page,
its pictures, and its numbers as JSON; papers that are not measured again stay as they were there.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        'paper',
        nargs='?',
        default=ALL,
        choices=(*reproduction.PAPERS, ALL),
        help='key of the paper; all if not given',
    )
    parser.add_argument(
        '--output',
        type=folder_argument,
        default=Path('reproduced'),
        help='folder for the page and its pictures',
    )
    parser.add_argument('--quick', action='store_true', help='leave out what walks in a simulator')
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if every row has a number, and what is worse an explanation."""
    console = make_console(stderr=arguments.json)
    papers = reproduction.PAPERS if arguments.paper == ALL else (arguments.paper,)
    results = reproduction.reproduce(
        papers, arguments.output, arguments.quick, lambda line: console.print(line, highlight=False)
    )
    failures = reproduction.failures(results)
    page = arguments.output / reproduction.PAGE
    if arguments.json:
        document = {'parts': json.loads(results.text()), 'failures': failures, 'page': str(page)}
        print(json.dumps(document))
    else:
        _print_results(console, papers, results)
        for failure in failures:
            console.print(f'failed: {failure}', markup=False, highlight=False)
        console.print(f'written: {page}', markup=False, highlight=False, soft_wrap=True)
    return 1 if failures else 0


def _print_results(console: Console, papers: Sequence[str], results: Results) -> None:
    """Print a table for each paper, and how many rows are better, equal and worse."""
    every: list[Shown] = []
    orders = reproduction.orders()
    for paper in papers:
        exhibits = results.exhibits(paper, orders[paper])
        every += exhibits
        table = Table(
            '',
            'what',
            'the paper',
            'here',
            'difference',
            'verdict',
            title=f'quadwalk reproduce {paper}',
        )
        for shown in exhibits:
            for row in shown.exhibit.rows:
                cells = (shown.exhibit.label, row.what, *row.texts, row.difference, row.verdict)
                table.add_row(*map(escape, cells))
        console.print(table)
    counts = ', '.join(f'{count} {verdict}' for verdict, count in counted(every).items())
    console.print(f'rows: {counts}', highlight=False)
