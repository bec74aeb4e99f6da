"""
Runs a node from its making to its end.
"""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.signals import SignalHandlerOptions

from quad_common.errors import QuadError
from quad_common.guarded_node import GuardedNode


def run_node(
    make_node: Callable[[], GuardedNode],
    args: list[str] | None = None,
    drive: Callable[[Any], float] | None = None,
) -> int:
    """
    Run a node until it is interrupted; end quietly.

    Parameters
    ----------
    make_node : callable
        Makes the node.
    args : list of str, optional
        Command-line arguments; those of the process if not given.
    drive : callable, optional
        Called with the node between callbacks; returns how long it has nothing to do [s].

    Returns
    -------
    int
        Exit code: 0, or 2 if the node could not be made.
    """
    # Signals are only noted. rclpy's own handlers end its context at once, from another
    # thread and in the middle of whatever publishes; Python's exception could come anywhere,
    # also in the clean-up: under ros2 launch a second interrupt follows the first.
    signals: list[int] = []
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, lambda number, frame: signals.append(number))
    node = None
    try:
        try:
            rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        except RuntimeError as error:
            print(f'error: {error}', file=sys.stderr)
            return 2
        node = make_node()
        executor = make_executor()
        executor.add_node(node)
        while not signals and rclpy.ok():
            node.turn(executor, drive)
    except (QuadError, ParameterException) as error:
        print(f'error: {error}', file=sys.stderr)
        return 2
    finally:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()
        _ignore_signals()
    return 0


def _ignore_signals() -> None:
    """Ignore further signals: while Python ends, it restores the handlers that kill."""
    hook = sys.unraisablehook
    # A signal that comes just now makes Python complain of a race; it is ignored all the same.
    sys.unraisablehook = lambda _: None
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.SIG_IGN)
    sys.unraisablehook = hook


def make_executor(context: Any = None) -> Any:
    """
    Make the executor with the least cost per message that rclpy has.

    Parameters
    ----------
    context : rclpy.Context, optional
        The default one if not given.

    Returns
    -------
    rclpy.executors.Executor
        Call its ``spin_once`` in a loop: its ``spin`` runs no callbacks in some releases.
    """
    try:
        from rclpy.experimental import EventsExecutor
    except ImportError:
        from rclpy.executors import SingleThreadedExecutor

        return SingleThreadedExecutor(context=context)
    return EventsExecutor(context=context)
