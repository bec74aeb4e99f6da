"""
``quadwalk replay``: a recording on a page in the browser, with a slider for the time.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from rich.console import Console

from quad_cli.arguments import (
    count_argument,
    namespace_argument,
    output_argument,
    quantity_argument,
)
from quad_cli.view import add_page_arguments, page_place
from quad_common.errors import ParameterError, QuadError
from quad_common.errors.quoting import clipped, quoted
from quad_common.files.bounded_file import user_path
from quad_common.quantity import Quantity
from quad_common.robot_files.robot_file import load_robot
from quad_sim.engines.registry import AUTO, ENGINES, engines_with, resolved

EXAMPLES = """examples:
  quadwalk replay demo/recording
  quadwalk replay my_bag --namespace robot1 --port 8090
  quadwalk replay demo/recording --film walk.mp4 --speed 8
  quadwalk replay demo/recording --film walk.gif --first 20 --last 30 --width 480
"""


_RATES = {'.mp4': 25.0, '.gif': 12.5}
"""Pictures in a second by the kind of film, whose name ends like this [Hz]: GIF grows fast."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('recording', help='folder of a recording, of quadwalk or of ros2 bag')
    parser.add_argument(
        '--namespace', type=namespace_argument, default='', help='namespace of the robot'
    )
    add_page_arguments(parser)
    film = parser.add_argument_group('a film in place of the page')
    film.add_argument(
        '--film', type=film_argument, metavar='FILE', help='write it to a file, *.mp4 or *.gif'
    )
    film.add_argument(
        '--robot', default='', help='the robot; the one that was recorded if not given'
    )
    for name, default, text in (
        ('first', 0.0, 'time from which it goes, from the beginning of the recording on [s]'),
        ('last', 1e6, 'time up to which it goes [s]'),
    ):
        reader = quantity_argument(name, Quantity(0.0, 1e6, 's'))
        film.add_argument(f'--{name}', type=reader, default=default, help=text)
    film.add_argument(
        '--speed',
        type=quantity_argument('speed', Quantity(0.1, 100.0)),
        default=1.0,
        help='recorded over shown time (default 1)',
    )
    film.add_argument('--width', type=count_argument, default=1280, help='in pixels (default 1280)')


def film_argument(text: str) -> Path:
    """Read the path of a film that can be written; raise argparse.ArgumentTypeError."""
    path = output_argument(text)
    if path.suffix.lower() not in _RATES:
        raise argparse.ArgumentTypeError(f'{quoted(text)} must end in {" or ".join(_RATES)}')
    return path


def run(arguments: argparse.Namespace) -> int:
    """Show the recording until it is interrupted, or make a film of it."""
    return _film(arguments) if arguments.film else _show(arguments)


def _film(arguments: argparse.Namespace) -> int:
    from rich.progress import Progress

    from quad_lab.recordings.film import FilmOptions, make_film
    from quad_lab.recordings.recorded_messages import RecordedMessages
    from quad_lab.recordings.recorded_robot import recorded_robot

    if not 64 <= arguments.width <= 4096:
        raise ParameterError('--width', arguments.width, 'a whole number from 64 to 4096')
    if arguments.first > arguments.last:
        raise ParameterError('--first', arguments.first, f'at most --last, {arguments.last:g}')
    folder = user_path(arguments.recording, 'recording')
    messages = RecordedMessages(folder, arguments.namespace)
    robot = load_robot(arguments.robot) if arguments.robot else recorded_robot(folder, messages)
    width = arguments.width - arguments.width % 2
    options = FilmOptions(
        arguments.first,
        arguments.last,
        arguments.speed,
        (width, 2 * round(width * 9 / 32)),
        _RATES[arguments.film.suffix.lower()],
    )
    console = Console()
    with Progress(console=console) as progress:
        task = progress.add_task('drawing', total=1.0)
        count = make_film(
            arguments.film, messages, robot, _drawing_backend(), options,
            lambda done: progress.update(task, completed=done),
        )  # fmt: skip
    console.print(f'{arguments.film}: {count} pictures', highlight=False)
    return 0


def _drawing_backend() -> str:
    """Return the engine that draws fastest of those that are installed."""
    able = [name for name in engines_with('has_pictures') if ENGINES[name].is_installed]
    return 'mujoco' if 'mujoco' in able else resolved(AUTO)


def _show(arguments: argparse.Namespace) -> int:
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
