"""
``quadwalk replay``: a recording on a page in the browser, with a slider for the time.
"""

from __future__ import annotations

import argparse

from rich.console import Console

from quad_cli.arguments import namespace_argument
from quad_cli.view import add_page_arguments, page_place
from quad_common.errors import QuadError
from quad_common.errors.quoting import clipped
from quad_common.files.bounded_file import user_path

EXAMPLES = """examples:
  quadwalk replay demo/recording
  quadwalk replay my_bag --namespace robot1 --port 8090
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('recording', help='folder of a recording, of quadwalk or of ros2 bag')
    parser.add_argument(
        '--namespace', type=namespace_argument, default='', help='namespace of the robot'
    )
    add_page_arguments(parser)


def run(arguments: argparse.Namespace) -> int:
    """Show the recording until it is interrupted."""
    # Here, so that 'quadwalk --help' works where rclpy and viser are absent.
    from quad_lab.recordings.replay import Replay
    from quad_view.scene.page_options import PageOptions

    console = Console()
    place = page_place(arguments)
    folder = user_path(arguments.recording, 'recording')
    replay = Replay(folder, PageOptions(place.host, place.port), arguments.namespace)
    duration = replay.timeline.duration
    console.print(f'{folder}: {duration:.1f} s; {replay.page.invitation()}', highlight=False)
    said: set[str] = set()

    def report(problem: QuadError) -> None:
        sentence = clipped(str(problem))
        if sentence not in said:
            said.add(sentence)
            console.print(sentence, highlight=False, markup=False)

    replay.run(report)
    return 0
