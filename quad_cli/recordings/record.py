"""
``quadwalk record``: keep what a robot publishes, until Ctrl-C.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Sequence
from pathlib import Path

from rich.console import Console

from quad_cli.arguments import folder_argument, namespace_argument, quantity_argument
from quad_common.errors import QuadError
from quad_common.process.end_signals import Interrupted
from quad_common.quantity import Quantity

EXAMPLES = """examples:
  quadwalk record                        # what the nodes of this ROS_DOMAIN_ID publish
  quadwalk record --namespace robot1 --output first_walk
  quadwalk record --everything --duration 60
  quadwalk evaluate recording
"""

_LOOK_PERIOD = 0.5
"""Between two lines of progress [s]."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        '--output', type=folder_argument, default=Path('recording'), help='folder to write'
    )
    parser.add_argument(
        '--namespace', type=namespace_argument, default='', help='namespace of the robot'
    )
    parser.add_argument(
        '--everything',
        action='store_true',
        help='also what nodes publish for subscribers only, which takes them time',
    )
    parser.add_argument(
        '--duration',
        type=quantity_argument('duration', Quantity(0.1, 1e6, 's')),
        default=None,
        help="time after which it ends, on the machine's clock [s]; Ctrl-C if left out",
    )


def run(arguments: argparse.Namespace) -> int:
    """Record until it is interrupted."""
    return _record(arguments)


def _record(arguments: argparse.Namespace) -> int:
    # Here, so that 'quadwalk --help' works where rclpy is absent.
    from quad_lab.recordings.recorder import Recorder

    console = Console()
    with Recorder(arguments.output, arguments.namespace, arguments.everything) as recorder:
        console.print(f'recording to {arguments.output}; Ctrl-C ends', highlight=False)
        counts, said = recorder.recording.counts, 0
        end = None if arguments.duration is None else time.monotonic() + arguments.duration
        try:
            with console.status('') as status:
                while end is None or time.monotonic() < end:
                    recorder.listen(_LOOK_PERIOD)
                    status.update(f'{sum(counts.values())} messages of {len(counts)} topics')
                    said = _say(console, recorder.recording.remarks, said)
        except Interrupted:
            # That is how it ends.
            pass
    _say(console, recorder.recording.remarks, said)
    for name, count in sorted(counts.items()):
        console.print(f'  {name:28} {count}', highlight=False)
    return 0


def _say(console: Console, remarks: Sequence[QuadError], said: int) -> int:
    """Print what was not said yet; return how many have been said."""
    for remark in remarks[said:]:
        console.print(str(remark), highlight=False, markup=False)
    return len(remarks)
