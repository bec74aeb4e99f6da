"""
Hostile command lines: valid ones with one argument changed.

The work behind a command is left out where it takes long: what counts is whether its arguments
end in a sentence, or are let through to the work.
"""

from __future__ import annotations

import contextlib
import importlib
import io
from collections.abc import Iterator
from dataclasses import dataclass
from unittest import mock

import numpy as np

from quad_common.errors import QuadError

_LINES = (
    'plan POSES --map room --method mesh --robot titan_viii',
    'plan POSES --gait crawl --safety-distance 0.1 --path-deviation 0.1',
    'plan POSES --height-map hills.yaml --step-height 0 --largest-slope 0.3',
    'plan POSES --picture plan.png --potential paper --method potential',
    'demo POSES --map room --robot titan_viii --gait crawl --seed 1',
    'demo --terrain bumps --safety-distance 0.2 --real-time-factor 1',
    'demo --output demo --method mesh --turning arc --perception truth',
    'reproduce S3 --output reproduced',
    'reproduce all --quick --output reproduced --json',
    'bench walk --seed 1 --quick',
    'calibrate --robot cuhk --gait trot --motion 0.1,0,0 --output my.yaml',
    'gait list',
    'gait check crawl --robot titan_viii --least-margin 0.01',
    'gait pace crawl --robot titan_viii --output pace.yaml',
    'camera masks room.png --output masks.png --colors colors.yaml',
    'camera map room.png --camera camera.yaml --bounds 0,0,3,3',
    'camera map room.png --camera camera.yaml --resolution 0.1 --every 1',
    'camera map room.png --camera camera.yaml --output m.yaml --drawn d.png',
    'camera calibrate --camera camera.yaml --points points.txt --output o.yaml',
    'robot check titan_viii',
    'robot urdf genibo --json',
    'robot urdf imported.yaml',
    'robot import description.urdf --output mine.yaml --effort 3 --speed 8 --no-picture',
    'view --map room --robot titan_viii --gait crawl --robots 2 --port 8080',
    'view --start 1.2,1.2,0 --host 127.0.0.1 --real-time-factor 1 --method mesh',
    'parameters gait_node',
    'evaluate folder --namespace robot1 --json',
    'replay folder --namespace robot1 --port 8080',
    'record --output kept --namespace robot1 --duration 5',
)

COMMANDS = tuple(
    tuple(line.replace('POSES', '--start 1.2,1.2,0 --goal 6.8,4.8,0').split()) for line in _LINES
)
"""Valid command lines, for a folder with the files that they name."""

_NUMBERS = ('nan', 'inf', '-inf', '1e300', '-1e300', '1e-300', '9' * 310, '-' + '9' * 5000, '0x10')
_TEXTS = (
    '', ' ', '-1', '0', 'x', '~no_such_user/x', '/', '.', '..', '/dev/zero', '/dev/stdin', 'pipe',
    'a\udcffb', 'x' * 5000, 'x' * 100_000, '/proc/1/x', 'room.png/x', 'folder', '\n', '%s', '{}',
    'loop', '1,2', '1,2,3,4', '1,2,nan', '1e300,0,0', '0,0,1e300', ',,,', '1,2,3deg', 'deg',
    '0,0,infdeg', 'bumps:height=nan', 'bumps:seed=' + '9' * 5000, 'bumps+' * 500 + 'bumps',
    'boxes:size=1e-300', ':', 'hills.yaml:a=b', '--', '--json', '-h', '\u202e', 'bad.yaml', '0,0,0',
)  # fmt: skip

REACHED = 'error: the work was reached'
"""What stands on stderr if arguments were let through to work that is left out."""

_NUMERIC = (
    '--safety-distance', '--path-deviation', '--step-height', '--largest-slope', '--seed',
    '--real-time-factor', '--least-margin', '--resolution', '--every', '--bounds', '--start',
    '--goal', '--motion', '--effort', '--speed', '--robots', '--port',
    '--duration',
)  # fmt: skip
"""Options that take numbers; none of them has a range that holds what is not finite."""


@dataclass(frozen=True)
class CommandLine:
    """A command line, and what should become of it."""

    arguments: tuple[str, ...]
    """Words after ``quadwalk``."""
    must_fail: bool
    """Whether it holds a number that no range holds."""


def changed_command(rng: np.random.Generator, only_failing: bool = False) -> CommandLine:
    """
    Change one argument of a command line.

    Parameters
    ----------
    rng : numpy.random.Generator
        What decides.
    only_failing : bool
        Only such that must be refused.

    Returns
    -------
    CommandLine
        The command line.
    """
    while True:
        words = list(COMMANDS[int(rng.integers(len(COMMANDS)))])
        place = int(rng.integers(len(words)))
        is_number = rng.random() < 0.5
        value = str(rng.choice(_NUMBERS if is_number else _TEXTS))
        option = words[place - 1] if place else ''
        # 1e-300 is a number like 0 where 0 is valid.
        must_fail = is_number and option in _NUMERIC and value != '1e-300'
        if must_fail or not only_failing:
            words[place] = value
            return CommandLine(tuple(words), must_fail)


@dataclass(eq=False, repr=False)
class WorkReached(QuadError):
    """Arguments were let through to work that is left out."""

    def sentence(self) -> str:
        """Say that arguments were let through."""
        return 'the work was reached'


@contextlib.contextmanager
def without_work() -> Iterator[None]:
    """Leave out what takes long behind the commands."""
    with contextlib.ExitStack() as stack:
        for name in (
            'quad_cli.plan._attempt',
            'quad_cli.calibrate.calibrate_motion',
            'quad_cli.calibrate._check_reach',
            'quad_cli.gait.derive_paces',
            'quad_cli.gait.check_gait',
            'quad_lab.papers.reproduction.reproduce',
            'quad_cli.bench._parts',
            'quad_cli.demo._walk',
            'quad_cli.view._show',
            'quad_cli.recordings.record._record',
        ):
            stack.enter_context(mock.patch(name, side_effect=WorkReached))
        yield


def warm_up() -> None:
    """Import what the commands need."""
    with without_work():
        for name in {words[0] for words in COMMANDS}:
            importlib.import_module('quad_cli.main').command_module(name)
        run_in_process(CommandLine(('plan', '--start', '1,1,0', '--goal', '2,2,0'), False))


def run_in_process(line: CommandLine) -> str:
    """
    Run a command line in this process, and say what is wrong with how it ended.

    Parameters
    ----------
    line : CommandLine
        The command line.

    Returns
    -------
    str
        Empty if nothing is.
    """
    # The command stands above this package: it is found by its name, as an entry point is.
    main = importlib.import_module('quad_cli.main').main
    said, complained = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(said), contextlib.redirect_stderr(complained):
        try:
            code: object = main(list(line.arguments))
        except SystemExit as error:
            code = error.code
    return wrong_end(line, code, complained.getvalue())


def wrong_end(line: CommandLine, code: object, complaint: str) -> str:
    """
    Say what is wrong with a command's end.

    Parameters
    ----------
    line : CommandLine
        The command line.
    code : object
        Its exit code.
    complaint : str
        What stood on stderr.

    Returns
    -------
    str
        Empty if nothing is.
    """
    last = complaint.strip().rpartition('\n')[2]
    if 'Traceback' in complaint:
        return f'a traceback: {last}'
    if code not in (0, 1, 2):
        return f'exit code {code}: {last}'
    if code == 2 and 'error: ' not in last:
        return f'no sentence: {last}'
    if line.must_fail and (code != 2 or REACHED in complaint):
        return 'a number outside every range was let through'
    if len(last) > 2000:
        return f'a sentence of {len(last)} characters'
    return ''
