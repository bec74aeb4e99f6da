"""
The ``quadwalk`` command.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes a while to import; signals count before.
    from quad_cli.__main__ import main as start

    raise SystemExit(start())

import argparse
import importlib
import io
import os
import sys
from types import ModuleType

from quad_cli.arguments import CommandParser, PrintVersion, with_negative_values
from quad_common.errors import QuadError
from quad_common.errors.quoting import clipped

COMMANDS = {
    'demo': 'walk from a start to a goal in simulation, and say how well it went',
    'view': 'show robots on a page in the browser, and let them walk by a click',
    'record': 'keep what a robot publishes, for ros2 bag, Foxglove and evaluate',
    'evaluate': 'say how walks went, from their recording alone',
    'replay': 'show a recording on a page in the browser, with a slider for the time',
    'plan': 'plan a path on a map, and draw it',
    'reproduce': "draw a paper's figures again, and print its numbers",
    'bench': 'measure what quadwalk does, and compare it with what it should do',
    'campaign': 'walk thousands of walks over what varies, on any number of machines',
    'replay-walk': 'run one walk of a campaign again, bit for bit',
    'calibrate': 'measure in simulation how far a gait goes, and keep it with the robot',
    'gait': 'list the gaits, or check one on a robot',
    'camera': 'see what a ceiling camera shows: colors, map, robot and goal, or where it is',
    'robot': 'import a robot from its URDF, xacro or MJCF; list, check or export robots',
    'doctor': 'say what works on this machine, what is missing, and what mends it',
    'parameters': "print a node's parameters as a commented YAML file",
}
"""The commands."""

_ROOMS = {
    **dict.fromkeys(('record', 'evaluate', 'replay'), 'recordings.'),
    **dict.fromkeys(('campaign', 'replay-walk'), 'campaigns.'),
}
"""Rooms of commands that are not in ``quad_cli`` itself."""


def command_module(name: str) -> ModuleType:
    """Import the module of a command, one of :data:`COMMANDS`."""
    return importlib.import_module(f'quad_cli.{_ROOMS.get(name, "")}{name.replace("-", "_")}')


def main(args: list[str] | None = None) -> int:
    """
    Run the command.

    Parameters
    ----------
    args : list of str, optional
        Arguments; those of the process if not given.

    Returns
    -------
    int
        0 if all went well, 1 if it did not, 2 if it could not be tried.
    """
    _print_anything()
    try:
        arguments = _parsed(sys.argv[1:] if args is None else args)
        code: int = arguments.run(arguments)
        # Even a closed stdout, which is None, has nothing against this.
        print(end='', flush=True)
        return code
    except QuadError as error:
        print(f'error: {error}', file=sys.stderr)
        return 2
    except BrokenPipeError:
        # Whoever read the output, for example 'head', has had enough.
        return 1
    except OSError as error:
        # A full disk, a folder that went away: what could be known before is checked before.
        print(f'error: {clipped(str(error))}', file=sys.stderr)
        return 2
    except MemoryError:
        print('error: there is not enough memory for that', file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:
        if error.name is None or error.name.startswith('quad_'):
            raise
        print(f'error: this needs the package {error.name}: {_advice(error.name)}', file=sys.stderr)
        return 2
    finally:
        _drop_unwritable()


def _parsed(args: list[str]) -> argparse.Namespace:
    """Read the arguments, with those of the one command that is run."""
    parser = CommandParser(
        prog='quadwalk', description='Walk a quadruped robot from a map to a goal.'
    )
    parser.add_argument(
        '--version', action=PrintVersion, nargs=0, help='print the version and exit'
    )
    commands = parser.add_subparsers(dest='command', metavar='command', required=True)
    for name, summary in COMMANDS.items():
        command = commands.add_parser(
            name,
            help=summary,
            description=summary[0].upper() + summary[1:] + '.',
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        # Some commands are slow to import: only the one that is run is.
        if args[:1] == [name]:
            module = command_module(name)
            command.epilog = module.EXAMPLES
            module.add_arguments(command)
            command.set_defaults(run=module.run)
    parser.check_values(args)
    return parser.parse_args(with_negative_values(args))


def _drop_unwritable() -> None:
    """Let output that cannot be written go nowhere: at its end the interpreter fails over it."""
    try:
        print(end='', flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _print_anything() -> None:
    """Let names of files be printed that are not text in the terminal's encoding."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors='backslashreplace')


def _advice(module: str) -> str:
    if module in ('rclpy', 'rosgraph_msgs') or module.endswith('_msgs'):
        return "source a ROS 2 installation, or pip install 'quadwalk[ros]'"
    return f'pip install {module}'
