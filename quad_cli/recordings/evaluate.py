"""
``quadwalk evaluate``: the figures of walks from their recording alone.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from rich.console import Console

from quad_cli.arguments import namespace_argument
from quad_cli.output.walk_table import print_walk
from quad_common.files.bounded_file import user_path

EXAMPLES = """examples:
  quadwalk evaluate demo/recording
  quadwalk evaluate demo/recording --json
  quadwalk evaluate my_bag --namespace robot1
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('recording', help='folder of a recording, of quadwalk or of ros2 bag')
    parser.add_argument(
        '--namespace', type=namespace_argument, default='', help='namespace of the robot'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if the robot arrived in every walk."""
    # Here, so that 'quadwalk --help' works where rclpy is absent.
    from quad_lab.topic_walk.recorded_walk import read_walks

    folder = user_path(arguments.recording, 'recording')
    recorded = read_walks(folder, arguments.namespace)
    place = str(recorded.facts.get('map') or Path(folder).name)
    summaries = [{'map': place, **walk.result().as_dict()} for walk in recorded.walks]
    if arguments.json:
        left_out = {left.topic: left.count for left in recorded.left_out}
        print(
            json.dumps(
                {'recording': str(folder), 'walks': summaries, 'messages_left_out': left_out}
            )
        )
    else:
        for summary in summaries:
            print_walk(Console(), summary)
        for left in recorded.left_out:
            Console().print(str(left), highlight=False, markup=False)
    return 0 if all(summary['arrived'] for summary in summaries) else 1
