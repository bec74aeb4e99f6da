"""
``quadwalk reproduce``: draw a paper's figures again, and print its numbers.
"""

from __future__ import annotations

import argparse
import importlib
import json
from pathlib import Path

from quad_cli.arguments import folder_argument

PAPERS = {
    'S3': 'quad_lab.papers.s3',
}
"""The module of each paper; it has ``reproduce(output)``, which returns figures and pictures."""

EXAMPLES = """examples:
  quadwalk reproduce S3
  quadwalk reproduce S3 --output pictures --json

The papers' titles are in docs/references.md.
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('paper', choices=sorted(PAPERS), help='key of the paper')
    parser.add_argument(
        '--output', type=folder_argument, default=Path('reproduced'), help='folder for the pictures'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command."""
    module = importlib.import_module(PAPERS[arguments.paper])
    reproduction = module.reproduce(arguments.output)
    pictures = [str(path) for path in reproduction.pictures]
    if arguments.json:
        print(json.dumps({'rows': reproduction.rows, 'pictures': pictures}))
        return 0
    print(reproduction.summary)
    _print_rows(reproduction.rows)
    for picture in pictures:
        print(f'drawn: {picture}')
    return 0


def _print_rows(rows: list[dict[str, str | float]]) -> None:
    """Print rows in columns, headed by their keys."""
    table = [list(rows[0]), *([_cell(value) for value in row.values()] for row in rows)]
    widths = [max(len(row[column]) for row in table) for column in range(len(table[0]))]
    for row in table:
        print('  '.join(cell.rjust(width) for cell, width in zip(row, widths)))


def _cell(value: str | float) -> str:
    return value if isinstance(value, str) else f'{value:.3f}'
