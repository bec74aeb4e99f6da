"""
Calls a function in a process of its own and within bounds.

A few characters of a description can ask its reader for any time and any memory, or have it wait
for a pipe, and no signal interrupts what is computed in one go. What a reader cannot bear ends the
process, not the program.
"""

from __future__ import annotations

import contextlib
import os
import pickle
import resource
import signal
import subprocess
import sys
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

_ONE_THREAD = {'OPENBLAS_NUM_THREADS': '1', 'OMP_NUM_THREADS': '1'}
"""Each of NumPy's threads takes address space, which is bounded."""


class Bounds(NamedTuple):
    """What a call may take."""

    seconds: int
    """Processor time [s]."""
    memory: int
    """Address space [bytes]."""
    patience: float = 60.0
    """Time on the wall clock, for it may wait for files [s]."""


class CallFailed(Exception):
    """
    A call raised what is no error of this package.

    Parameters
    ----------
    kind : str
        Name of the exception's class.
    message : str
        What it said.
    """

    def __init__(self, kind: str, message: str) -> None:
        super().__init__(f'{kind}: {message}')
        self.kind, self.message = kind, message


class BeyondBounds(Exception):
    """A call took or waited longer than it may, needed more memory, or crashed."""


def call_in_bounds(function: Callable[..., Any], *arguments: object, bounds: Bounds) -> Any:
    """
    Call a function in a process of its own.

    Parameters
    ----------
    function : callable
        At the top level of a module.
    *arguments : object
        Its arguments; they and what it returns are pickled.
    bounds : Bounds
        What it may take.

    Returns
    -------
    object
        What it returned.

    Raises
    ------
    QuadError
        If it raised that.
    CallFailed
        If it raised anything else.
    BeyondBounds
        If it took longer, needed more memory, or crashed.
    """
    order = function.__module__, function.__name__, arguments, tuple(bounds)[:2]
    try:
        done = subprocess.run(
            [sys.executable, '-m', __name__],
            input=pickle.dumps(order),
            env={**os.environ, **_ONE_THREAD},
            # Where this package is found, whatever lies in the user's folder.
            cwd=Path(__file__).parents[2],
            capture_output=True,
            timeout=bounds.patience,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise BeyondBounds(f'it takes, or waits, more than {bounds.patience:.0f} s') from None
    try:
        result, error = pickle.loads(done.stdout)
    except (EOFError, pickle.UnpicklingError):
        raise BeyondBounds(_end(done.returncode, bounds)) from None
    if isinstance(error, Exception):
        raise error
    if error is not None:
        raise CallFailed(*error)
    return result


def _end(code: int, bounds: Bounds) -> str:
    """Say why a process ended without an answer, by its exit code."""
    if code < 0 and -code not in (signal.SIGXCPU, signal.SIGKILL, signal.SIGABRT):
        return f'its reader has ended by {signal.Signals(-code).name}'
    return f'it takes more than {bounds.seconds} s, or too much memory'


def _main() -> None:
    """Take an order by the standard input, and answer by the standard output."""
    from quad_common.errors import QuadError

    module, name, arguments, (seconds, memory) = pickle.load(sys.stdin.buffer)
    for limit, most in ((resource.RLIMIT_CPU, seconds), (resource.RLIMIT_AS, memory)):
        hard = resource.getrlimit(limit)[1]
        is_lower = hard == resource.RLIM_INFINITY or most < hard
        resource.setrlimit(limit, (most if is_lower else hard, hard))
    # Whatever is printed meanwhile, by libraries too, is no answer.
    answer = os.dup(1)
    os.dup2(2, 1)
    result: object = None
    error: object = None
    with contextlib.redirect_stdout(sys.stderr):
        try:
            result = getattr(import_module(module), name)(*arguments)
        except QuadError as raised:
            error = raised
        # What it evaluates for a file lets pass whatever that raises.
        except (Exception, SystemExit) as raised:
            error = type(raised).__name__, str(raised)
    with os.fdopen(answer, 'wb') as stream:
        pickle.dump((result, error), stream)


if __name__ == '__main__':
    _main()
