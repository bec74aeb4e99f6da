"""
Starts a node: signals count from here, before the seconds that its imports take.
"""

from __future__ import annotations

import importlib
import os
import signal
import threading
import time

from quad_common.process.end_signals import EndSignals, end_process

PARENT = 'QUADWALK_PARENT'
"""Environment variable: id of the process with which a node is to end."""

_PATIENCE_MAKING = 1.0
"""Time for a node to end after a signal that came while it was made [s]."""

_PATIENCE = 2.5
"""Time for a node that runs to end after a signal [s]."""

_LAST_WAIT = 1.0
"""Time for its threads to come to an end, then [s]."""

_PARENT_PERIOD = 0.3
"""Time between two checks whether the parent is still there [s]."""


class NodeEnd:
    """
    When the node of this process is to end, and how.

    Until `is_wanted` is called for the first time there is nothing to be given back, and a
    signal ends the process where it stands. From then on signals are only noted: an
    exception could come anywhere, in the middle of what publishes and in the clean-up too.
    A node that is being made has done nothing yet, and is waited for less long.
    """

    def __init__(self) -> None:
        self._is_asked = False
        self._signals = EndSignals(self._react, lambda number: 0, _PATIENCE_MAKING)
        self._signals.install()

    def is_wanted(self) -> bool:
        """Return whether the node is to end."""
        self._is_asked = True
        return bool(self._signals.noted)

    def expect_running(self) -> None:
        """Give the node, which is made, its time to end in good order."""
        self._signals.patience = _PATIENCE

    def _react(self, number: int) -> None:
        if not self._is_asked:
            end_process(0)


_end: NodeEnd | None = None


def node_end() -> NodeEnd:
    """Return what tells the node of this process when to end; signals are noted from now on."""
    global _end
    if _end is None:
        _end = NodeEnd()
    return _end


def start_node(module: str, args: list[str] | None = None) -> int:
    """
    Run a node's ``main`` in this process, and end the process with it.

    Parameters
    ----------
    module : str
        The node's module.
    args : list of str, optional
        Command-line arguments; those of the process if not given.

    Returns
    -------
    int
        Never: the process has ended. The type is that of an entry point.
    """
    node_end()
    _end_with_parent()
    code: int = importlib.import_module(module).main(args)
    _join_threads(_LAST_WAIT)
    end_process(code)
    return code


def _join_threads(timeout: float) -> None:
    """Wait for threads that work; compiling may take them longer than anybody waits."""
    deadline = time.monotonic() + timeout
    for thread in threading.enumerate():
        if thread is not threading.main_thread() and not thread.daemon:
            thread.join(max(0.0, deadline - time.monotonic()))


def _end_with_parent() -> None:
    """Have this process end when the one does that started it, even if that is killed."""
    # Linux's own signal for it comes when the parent's *thread* ends, and not at all if the
    # parent ended before this was requested.
    parent = os.environ.pop(PARENT, '')

    def watch() -> None:
        while os.getppid() == int(parent):
            time.sleep(_PARENT_PERIOD)
        os.kill(os.getpid(), signal.SIGTERM)

    if parent:
        threading.Thread(target=watch, name='parent', daemon=True).start()
