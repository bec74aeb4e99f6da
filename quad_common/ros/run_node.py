"""
Runs a node from its making to its end.
"""

from __future__ import annotations

import gc
import os
import sys
import threading
from collections.abc import Callable
from typing import Any

import rclpy
from rclpy.exceptions import ParameterException
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.signals import SignalHandlerOptions

from quad_common.errors import ArgumentNotText, QuadError
from quad_common.network.reach import (
    check_security,
    library_without_security,
    reach_of,
)
from quad_common.network.transport import leave_shared_memory
from quad_common.process.end_signals import ignore_signals
from quad_common.process.entry import node_end
from quad_common.process.native_end import ended_natively_after
from quad_common.ros.guarded_node import GuardedNode

_LONGEST_END = 3.0
"""Time in which the middleware has to let go of a node [s]; rarely it never does."""

_COLLECTED_AFTER = 100_000
"""Number of new objects after which the garbage collector looks for cycles among them."""


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
    end = node_end()
    node = executor = None
    code = 0
    try:
        if end.is_wanted():
            return 0
        check_middleware()
        leave_shared_memory(os.environ)
        check_text(sys.argv if args is None else args)
        try:
            rclpy.init(args=args, signal_handler_options=SignalHandlerOptions.NO)
        except RuntimeError as error:
            print(f'error: {error}', file=sys.stderr)
            return 2
        node = make_node()
        keep_for_good()
        end.expect_running()
        node.get_logger().info(reach_of(os.environ))
        executor = make_executor()
        executor.add_node(node)
        # The context itself is behind two locks, and would be asked before each message.
        is_shut_down = threading.Event()
        rclpy.get_default_context().on_shutdown(is_shut_down.set)
        while not (end.is_wanted() or is_shut_down.is_set()):
            node.turn(executor, drive)
    except (QuadError, ParameterException, rclpy_implementation.RCLError) as error:
        print(f'error: {error}', file=sys.stderr)
        code = 2
    finally:
        with ended_natively_after(_LONGEST_END, code):
            if executor is not None:
                # It uses what the node has, and must let go of it before that is destroyed.
                executor.shutdown()
            if node is not None:
                node.destroy_node()
            rclpy.try_shutdown()
        ignore_signals()
    return code


def keep_for_good() -> None:
    """
    Take what is there at the start out of the garbage collector's sight.

    Modules, gaits and maps stay until the end, and looking through them takes 4 to 12 ms: in a
    simulation at 18 times real time that is up to two thirds of the time that a decision has.
    What comes later it looks through less often: Python's own threshold has it go through a message
    of a hundred thousand parts hundreds of times while rclpy makes it, which takes a third longer.
    """
    gc.collect()
    gc.freeze()
    gc.set_threshold(_COLLECTED_AFTER)


def check_text(arguments: list[str]) -> None:
    """Raise ArgumentNotText for a command-line argument that no message could hold."""
    for argument in arguments:
        try:
            argument.encode()
        except UnicodeEncodeError as error:
            raise ArgumentNotText(argument) from error


def check_middleware() -> None:
    """
    Refuse to start without the security that the environment asks for.

    Raises
    ------
    SecurityUnavailable, SecuritySettingUnknown
        See :func:`quad_common.network.reach.check_security`.
    """

    def library_without() -> str | None:
        # Asking for its name loads it.
        rclpy.get_rmw_implementation_identifier()
        return library_without_security()

    check_security(os.environ, library_without)


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
