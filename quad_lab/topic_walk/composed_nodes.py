"""
All nodes of a walk in one process and one executor, in step with the simulator.

The simulator goes on when everything that was published has been received and answered. So nothing
comes late however fast it goes, and a walk repeats bit for bit.
"""

from __future__ import annotations

import importlib
import time
from typing import Any

import rclpy
from rclpy.parameter import Parameter
from rclpy.signals import SignalHandlerOptions

from quad_common.ros.guarded_node import GuardedNode
from quad_common.ros.run_node import make_executor
from quad_lab.topic_walk.node_processes import in_simulated_time
from quad_lab.topic_walk.walk_observer import WalkObserver
from quad_planner.session.immediate_request import ImmediateRequest

_NODES = {
    'planner_node': ('quad_planner.planner_node', 'PlannerNode'),
    'gait_node': ('quad_gait.gait_node', 'GaitNode'),
    'sim_node': ('quad_sim.sim_node', 'SimNode'),
    'ceiling_camera_node': ('quad_perception.ceiling_camera_node', 'CeilingCameraNode'),
}
"""Module and class of each node."""

_QUIET = 3
"""Looks in a row at an executor that has nothing more to do."""

_SETTLING = 0.3
"""Time on the wall clock in which nothing comes any more [s]: all have found one another."""

_SHORT_WAIT = 0.005
"""Between two looks for what comes from outside the process [s], on the wall clock."""


class ComposedNodes:
    """
    Nodes that take the place of :class:`~quad_lab.topic_walk.node_processes.NodeProcesses`.

    One of them must be sim_node, which goes on in :meth:`listen` only.
    """

    def __init__(self) -> None:
        # Their words would stand between the command's own.
        quiet = ['--ros-args', '--disable-stdout-logs']
        rclpy.init(args=quiet, signal_handler_options=SignalHandlerOptions.NO)
        self.executor = make_executor()
        """What runs their callbacks."""
        self._nodes: dict[str, GuardedNode] = {}
        self._observers: list[WalkObserver] = []

    def __enter__(self) -> ComposedNodes:
        return self

    def __exit__(self, *_: object) -> None:
        self.executor.shutdown()
        for node in self._nodes.values():
            node.destroy_node()
        rclpy.try_shutdown()

    def start(self, name: str, **parameters: object) -> None:
        """Make a node; parameters as those of its table."""
        module, kind = _NODES[name]
        # Plans are there when the callback that asks for them ends, not when a thread is through.
        others = {'requests': ImmediateRequest()} if name == 'planner_node' else {}
        given = in_simulated_time(name, parameters)
        overrides = [Parameter(key, value=value) for key, value in given.items()]
        make: Any = getattr(importlib.import_module(module), kind)
        node = make(parameter_overrides=overrides, **others)
        self._nodes[name] = node
        self.executor.add_node(node)

    def check(self) -> None:
        """Do nothing: what goes wrong in a node is on diagnostics, and ends none of them."""

    def tell(self, observer: WalkObserver) -> None:
        """Wait for what an observer in the same executor receives, too."""
        self._observers.append(observer)
        self._settle()

    def listen(self, duration: float) -> None:
        """Go on for some simulated time [s]."""
        simulator: Any = self._nodes['sim_node']
        end = simulator.time + duration
        while simulator.time < end:
            simulator.drive()
            self._drain()

    def _settle(self) -> None:
        """Run callbacks, without the simulation, until nothing has come for a while."""
        quiet_since = time.monotonic()
        while time.monotonic() - quiet_since < _SETTLING:
            if self._drain():
                quiet_since = time.monotonic()
            time.sleep(_SHORT_WAIT)

    def _drain(self) -> bool:
        """Run callbacks until none is left; return whether there were any."""
        called = False
        idle = 0
        while idle < _QUIET:
            before = self._calls()
            self.executor.spin_once(timeout_sec=0.0)
            idle = idle + 1 if self._calls() == before else 0
            called = called or idle == 0
        return called

    def _calls(self) -> int:
        received = sum(observer.received for observer in self._observers)
        return received + sum(node.callbacks for node in self._nodes.values())
