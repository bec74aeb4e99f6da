"""
``quadwalk replay-walk``: one walk of a campaign again.
"""

from __future__ import annotations

import argparse
import json
import time
from contextlib import nullcontext
from dataclasses import fields

from rich.console import Console
from rich.table import Table

from quad_cli.arguments import folder_argument
from quad_cli.campaigns.campaign import default_folder
from quad_lab.campaigns.replayed_walk import differing, find_walk
from quad_lab.campaigns.spec_file import load_campaign
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.seeded_walks.walk_figures import WalkFigures
from quad_lab.seeded_walks.walk_task import run_walk
from quad_lab.tools.criterion import make_console
from quad_sim.engines.registry import in_window
from quad_sim.engines.simulator import Observation

EXAMPLES = """examples:
  quadwalk replay-walk reliability 1234567890
  quadwalk replay-walk reliability 1234567890 --gui
  quadwalk replay-walk my_campaign.yaml 1234567890 --json
  quadwalk replay-walk tune_trot 3f2a9c --output tuned
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('campaign', help='a campaign file, or the name of one that ships')
    parser.add_argument(
        'walk', metavar='SEED', help="the walk's seed, or the beginning of its result's key"
    )
    parser.add_argument(
        '--output',
        type=folder_argument,
        metavar='FOLDER',
        help="where the campaign's results are, to compare with (default: campaigns/ and its name)",
    )
    parser.add_argument(
        '--gui', action='store_true', help="show the walk in the engine's window, in real time"
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Walk again; return 0 if figures are those that were kept, or none were."""
    console = make_console(stderr=arguments.json)
    spec = load_campaign(arguments.campaign)
    folder = arguments.output or default_folder(spec.name)
    job, kept = find_walk(spec, folder / 'results', arguments.walk)
    with in_window() if arguments.gui else nullcontext():
        result = run_walk(job, in_real_time if arguments.gui else lambda loop: None)
    different = [] if kept is None else differing(result.figures, kept.figures)
    if arguments.json:
        print(json.dumps({
            'seed': job.seed, 'case': dict(job.case), 'figures': result.figures.as_dict(),
            'kept': kept is not None, 'different': different,
        }))  # fmt: skip
    else:
        _print(console, dict(job.case), result.figures)
        if kept is None:
            console.print('no result was kept of this walk: nothing to compare with')
        elif different:
            console.print(f'other than the result that was kept: {", ".join(different)}')
        else:
            console.print('the same figures as were kept, bit for bit')
    return 1 if different else 0


def in_real_time(loop: ClosedLoop) -> None:
    """Have a walk wait after each measurement until as much time has gone by as it simulated."""
    began = time.monotonic()

    def wait(seen: Observation) -> None:
        time.sleep(max(0.0, began + seen.time - time.monotonic()))

    loop.on_observation.append(wait)


def _print(console: Console, case: dict[str, object], figures: WalkFigures) -> None:
    table = Table('', 'value')
    for name, value in case.items():
        table.add_row(name, str(value))
    table.add_section()
    for item in fields(figures):
        table.add_row(item.name, str(getattr(figures, item.name)))
    console.print(table)
