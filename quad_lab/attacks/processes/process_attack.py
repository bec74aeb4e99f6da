"""
Attack by signals: every node and the commands, at random moments from their start on.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import numpy as np
from rich.console import Console

from quad_common.process.early_signals import SIGNALS
from quad_common.process.end_signals import blocked_signals
from quad_common.process.temporary_folder import temporary_folder
from quad_lab.attacks.processes.endings import Ending, ending_bars, is_bad
from quad_lab.attacks.processes.traces import Traces
from quad_lab.tools.criterion import Criterion
from quad_lab.tools.workers import end_with_parent
from quad_lab.topic_walk.node_processes import NODES, NodeProcess, isolated_domain

STOPS = 200
"""Of each node."""

COMMANDS = 40
"""Ends of each command by each signal."""

_QUICK_ENDS = ((signal.SIGKILL, 'demo'), (signal.SIGTERM, 'terrain'))
"""Of the quick sample, once each; and one stop of each node."""

_QUICK_PACE = 0.3
"""Fraction of the usual delays before the signals of the quick sample."""

_LATEST_STOP = 3.0
"""After the start of a node [s]."""

_LATEST_END = 8.0
"""After the start of a command [s], unless a demo was measured."""

_PATIENCE = 20.0
"""After which what does not end is killed [s]."""

_LOOK_PERIOD = 0.01
"""Between two looks at what belongs to a process [s]."""

_DEMO = ('demo', '--backend', 'kinematic', '--json', '--start', '1.2,1.2,0', '--goal', '1.6,1.2,0')

_COMMANDS = {
    'demo': _DEMO,
    'walk': ('bench', 'walk', '--quick'),
    'terrain': ('bench', 'terrain', '--quick'),
}
"""What is ended, by a short name."""

_LAST_WORDS = {
    'demo': '"arrived"',
    'walk': 'quadwalk bench walk',
    'terrain': 'quadwalk bench terrain',
}
"""What each prints when it is through."""


def attack_nodes(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    End every node, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A small sample.
    seed : int
        Of signals and moments.

    Returns
    -------
    tuple
        The bars, and details for JSON: every ending.
    """
    rng, say = np.random.default_rng(seed), _Speaker(console, quick)
    if quick:
        stops = attack_starts_and_stops(rng, 1, say, _QUICK_PACE)
    else:
        stops = attack_starts_and_stops(rng, STOPS, say)
    return ending_bars('node', stops), {'endings': [asdict(ending) for ending in stops]}


def attack_demos_and_benches(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """End the commands that start nodes and workers; otherwise as :func:`attack_nodes`."""
    rng, say = np.random.default_rng(seed), _Speaker(console, quick)
    if quick:
        ends = attack_commands(rng, 1, say, _QUICK_PACE, _QUICK_ENDS)
    else:
        ends = attack_commands(rng, COMMANDS, say)
    return ending_bars('command', ends), {'endings': [asdict(ending) for ending in ends]}


class _Speaker:
    """Says how things ended: each that is bad, and of the others one now and then."""

    def __init__(self, console: Console, says_all: bool) -> None:
        self._console, self._says_all = console, says_all

    def __call__(self, number: int, count: int, ending: Ending) -> None:
        if not self._says_all and not is_bad(ending) and number % 20:
            return
        self._console.print(
            f'{number}/{count} {ending.what}: {ending.signal} after {ending.delay:.2f} s, '
            f'ended in {ending.duration:.2f} s with {ending.code}'
            + (f', left {", ".join(ending.left)}' if ending.left else ''),
            highlight=False,
        )


def attack_starts_and_stops(
    rng: np.random.Generator,
    count: int,
    on_ending: Callable[[int, int, Ending], None] = lambda number, of, ending: None,
    pace: float = 1.0,
) -> list[Ending]:
    """
    Start each node, and end it by a signal at a random moment.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws signals and moments.
    count : int
        Times for each node.
    on_ending : callable
        Told each ending, with its number and how many there will be.
    pace : float
        Fraction of the usual delays before the signals.

    Returns
    -------
    list of Ending
        In the order in which they were tried.
    """
    endings = []
    with isolated_domain(), _place() as place:
        for _ in range(count):
            for node in NODES:
                number = SIGNALS[rng.integers(len(SIGNALS))]
                ending = _stop(node, number, pace * rng.uniform(0.0, _LATEST_STOP), place)
                endings.append(ending)
                on_ending(len(endings), count * len(NODES), ending)
    return endings


def attack_commands(
    rng: np.random.Generator,
    count: int,
    on_ending: Callable[[int, int, Ending], None] = lambda number, of, ending: None,
    pace: float = 1.0,
    ends: tuple[tuple[signal.Signals, str], ...] | None = None,
) -> list[Ending]:
    """
    Start demos and benches, and end them by signals at random moments.

    Parameters
    ----------
    rng : numpy.random.Generator
        Draws the moments.
    count : int
        Times for each signal and command.
    on_ending : callable
        Told each ending, with its number and how many there will be.
    pace : float
        Fraction of the usual delays before the signals.
    ends : tuple of (Signals, str), optional
        Signals and commands. If not given, each with each, at any moment of a demo that is
        measured first.

    Returns
    -------
    list of Ending
        In the order in which they were tried.
    """
    latest = _LATEST_END
    endings = []
    with _place() as place:
        if ends is None:
            ends = tuple((n, name) for n in (*SIGNALS, signal.SIGKILL) for name in _COMMANDS)
            # On a busy machine the nodes take long to start, and the walk is to be met too.
            began = time.monotonic()
            _start(_DEMO, place / 'output').communicate()
            latest = time.monotonic() - began
        for _ in range(count):
            for number, name in ends:
                ending = _end(name, number, pace * rng.uniform(0.0, latest), place)
                endings.append(ending)
                on_ending(len(endings), count * len(ends), ending)
    return endings


def _stop(node: str, number: signal.Signals, delay: float, place: Path) -> Ending:
    """Start a node, end it, and see what is left."""
    log = place / 'node.log'
    log.unlink(missing_ok=True)
    process = NodeProcess(node, {}, log)
    traces = Traces(process.pid)
    duration = _send(process.pid, number, delay, traces)
    code = process.wait(_PATIENCE)
    words = process.log_tail(10_000)
    log.unlink()
    return Ending(
        node, number.name, delay, duration, code, code == 0, 'Traceback' in words,
        _left(traces, place),
    )  # fmt: skip


def _end(name: str, number: signal.Signals, delay: float, place: Path) -> Ending:
    """Start a command, end it, see what is left, and whether the next one works."""
    output = place / 'output'
    with blocked_signals():
        process = _start(_COMMANDS[name], output)
    traces = Traces(process.pid)
    duration = _send(process.pid, number, delay, traces)
    if process.poll() is None:
        process.kill()
    words = process.communicate()[0]
    code = process.returncode
    right = -number if number == signal.SIGKILL else 128 + number
    # A command that was through when the signal came has a code of its own.
    is_right = code == right or (code in (0, 1) and _LAST_WORDS[name] in words)
    left = [] if number == signal.SIGKILL else list(_left(traces, place, ('output',)))
    left += [f'process {pid}' for pid in traces.running()]
    next_run = None
    if name == 'demo':
        following = _start(_DEMO, output)
        following.communicate()
        next_run = following.returncode == 0
        # What a kill leaves is removed by the next run.
        left += _temporary(place, ('output',))
    return Ending(
        name, number.name, delay, duration, code, is_right, 'Traceback' in words,
        tuple(left), next_run,
    )  # fmt: skip


def _start(command: tuple[str, ...], output: Path) -> subprocess.Popen[str]:
    where = ('--output', str(output)) if command[0] == 'demo' else ()
    environment = {k: v for k, v in os.environ.items() if k != '_ROS_WHEELS_BOOTSTRAP_COMPLETE'}
    return subprocess.Popen(
        [sys.executable, '-m', 'quad_cli', *command, *where],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        errors='replace',
        env=environment,
        start_new_session=True,
        preexec_fn=end_with_parent,
    )


def _send(pid: int, number: signal.Signals, delay: float, traces: Traces) -> float:
    """Send a signal after a while; return how long the process and its own take to end [s]."""
    due = time.monotonic() + delay
    traces.look()
    while (left := due - time.monotonic()) > 0.0 and traces.running():
        time.sleep(min(left, _LOOK_PERIOD))
        traces.look()
    if not traces.running():
        return 0.0
    os.kill(pid, number)
    began = time.monotonic()
    while traces.running() and time.monotonic() - began < _PATIENCE:
        time.sleep(_LOOK_PERIOD)
        traces.look()
    return time.monotonic() - began


def _left(traces: Traces, place: Path, expected: tuple[str, ...] = ()) -> tuple[str, ...]:
    return (*traces.shared_memory(), *_temporary(place, expected))


def _temporary(place: Path, expected: tuple[str, ...]) -> list[str]:
    return [path.name for path in place.iterdir() if path.name not in expected]


@contextmanager
def _place() -> Iterator[Path]:
    """Have what is started here make its temporary files where nothing else does."""
    before = os.environ.get('TMPDIR')
    hangup = signal.getsignal(signal.SIGHUP)
    with temporary_folder() as folder:
        place = folder / 'place'
        place.mkdir()
        os.environ['TMPDIR'] = str(place)
        if hangup == signal.SIG_IGN:
            # What is started would inherit it from nohup; a handler ends with exec.
            signal.signal(signal.SIGHUP, lambda number, frame: None)
        try:
            yield place
        finally:
            signal.signal(signal.SIGHUP, hangup)
            if before is None:
                del os.environ['TMPDIR']
            else:
                os.environ['TMPDIR'] = before
