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
from rclpy.qos import QoSCompatibility, qos_check_compatible
from rclpy.signals import SignalHandlerOptions

from quad_common.ros.guarded_node import GuardedNode
from quad_common.ros.run_node import make_executor
from quad_lab.topic_walk.draining import drain
from quad_lab.topic_walk.node_processes import in_simulated_time
from quad_lab.topic_walk.standstill import Standstill
from quad_lab.topic_walk.walk_observer import WalkObserver
from quad_planner.session.immediate_request import ImmediateRequest

_NODES = {
    'planner_node': ('quad_planner.planner_node', 'PlannerNode'),
    'gait_node': ('quad_gait.gait_node', 'GaitNode'),
    'sim_node': ('quad_sim.sim_node', 'SimNode'),
    'ceiling_camera_node': ('quad_perception.ceiling_camera_node', 'CeilingCameraNode'),
}
"""Module and class of each node."""

_SETTLING = 0.3
"""Time on the wall clock for what is latched, once all have found one another [s]."""

_LONGEST_SEARCH = 30.0
"""Time on the wall clock after which those that have not found one another never will [s]."""

_LONGEST_STAND = 0.5
"""Time on the wall clock for which simulated time may stand still [s]: it does while paused."""

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
        """Go on for some simulated time [s], or until that has stood still for a while."""
        simulator: Any = self._nodes['sim_node']
        end = simulator.time + duration
        standstill = Standstill(simulator.time)
        while simulator.time < end and standstill.duration(simulator.time) < _LONGEST_STAND:
            simulator.drive()
            self._drain()

    def _settle(self) -> None:
        """Run callbacks, without the simulation, until all have received what is latched."""
        # Not until nothing comes: heartbeats and diagnostics come on the wall clock all the time.
        begin = met = time.monotonic()
        while (now := time.monotonic()) - met < _SETTLING:
            self._drain()
            if now - begin < _LONGEST_SEARCH and not self._have_met():
                met = now
            time.sleep(_SHORT_WAIT)

    def _have_met(self) -> bool:
        """Return whether each publisher knows every subscription of these nodes that fits it."""
        nodes = self.executor.get_nodes()
        subscriptions = [subscription for node in nodes for subscription in node.subscriptions]
        for publisher in (publisher for node in nodes for publisher in node.publishers):
            fitting = sum(_fit(publisher, subscription) for subscription in subscriptions)
            if publisher.get_subscription_count() < fitting:
                return False
        return True

    def _drain(self) -> None:
        """Run callbacks until none is left."""
        drain(self.executor, self._calls)

    def _calls(self) -> int:
        received = sum(observer.received for observer in self._observers)
        return received + sum(node.callbacks for node in self._nodes.values())


def _fit(publisher: Any, subscription: Any) -> bool:
    """Return whether a subscription receives what is published."""
    if publisher.topic_name != subscription.topic_name:
        return False
    compatibility, _ = qos_check_compatible(publisher.qos_profile, subscription.qos_profile)
    return bool(compatibility != QoSCompatibility.ERROR)
