"""
Sends a node hostile messages and requests, to all its subscriptions and services.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Iterator
from typing import Any

import numpy as np
from nav_msgs.srv import GetPlan
from rcl_interfaces.msg import Parameter
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import Parameter as RosParameter
from rclpy.qos import DurabilityPolicy, QoSProfile
from rclpy.serialization import serialize_message

from quad_common.planar_pose import Pose2D
from quad_lab.attacks.messages.mutations import Mutation, Mutator, giants_of, random_bytes
from quad_lab.attacks.stage.examples import example_of, made_up, plan_request
from quad_lab.attacks.stage.graph import Interface, inputs_of
from quad_lab.attacks.stage.stage import Stage
from quad_planner.parameters import FOOTPRINTS, PLANNING_METHODS

_DAMAGED_FRACTION = 0.08
"""Fraction of messages whose bytes are damaged, instead of a field."""

_DISCOVERY = 0.5
"""Time in which publishers and clients are found by the node [s]."""

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)

_SOMEWHERE = Pose2D(1.2, 1.2, 0.0)
"""On the map, where no odometry was received yet."""

_ROBOTS = '/fleet/robots'
"""Topic on which planners say where their robots are."""

_LONGEST_NAME = 1000
"""Number of letters from which on the name of a robot is too long for sure."""

_NOT_CHANGED = ('use_sim_time',)
"""Parameters that are not attacked: what they change is which time is meant at all."""


class Attacker:
    """
    Attacks one node.

    Parameters
    ----------
    stage : Stage
        Where it runs.
    name : str
        Of the node.
    rng : numpy.random.Generator
        Of what is sent.
    """

    def __init__(self, stage: Stage, name: str, rng: np.random.Generator) -> None:
        self._stage = stage
        self.name = name
        """Of the node."""
        self._rng = rng
        self._publishers: dict[str, Any] = {}
        self._latched: list[Interface] = []
        self._clients: dict[str, Any] = {}
        self._mutators: dict[str, Mutator] = {}
        self._parameters: list[Parameter] = []
        self.inputs: list[Interface] = []
        """What is attacked."""
        self.recent: list[str] = []
        """What was sent last, the newest last."""
        self.slow: list[str] = []
        """Requests that were answered late or never."""
        self.robots: set[str] = set()
        """Names of robots that it said to be there."""
        self._connect()
        self._turns = itertools.cycle(self.inputs)

    def shoot(self) -> None:
        """Send the next message or request."""
        target = next(self._turns)
        if target.is_service:
            self._request(target)
        else:
            self._publish(target)

    def send_giants(self) -> Iterator[None]:
        """Send each message and request far too long, in one field after the other."""
        for target in self.inputs:
            for mutation in giants_of(self.example(target)):
                if target.is_service:
                    self._send_request(target, mutation)
                else:
                    self.send(target, mutation.message, f'{target} {mutation}')
                yield

    def load_all(self) -> None:
        """
        Let a planner plan once in every way: what it needs for one it loads then, and keeps.

        Of another node nothing is asked.
        """
        if '/get_plan' not in [target.name for target in self.inputs]:
            return
        request = plan_request(self._stage.pose or _SOMEWHERE)
        for method, footprint, any_angle in itertools.product(
            PLANNING_METHODS, FOOTPRINTS, (False, True)
        ):
            wanted = {'method': method, 'footprint': footprint, 'any_angle': any_angle}
            parameters = [RosParameter(n, value=v).to_parameter_msg() for n, v in wanted.items()]
            change = SetParameters.Request(parameters=parameters)
            self._stage.call(f'{self.name}/set_parameters', SetParameters, change)
            self._stage.call('/get_plan', GetPlan, request)
        self.restore_parameters()

    def restore_parameters(self) -> None:
        """Give the node back the parameters that it had."""
        request = SetParameters.Request(parameters=self._parameters)
        self._stage.call(f'{self.name}/set_parameters', SetParameters, request)

    def renew_latched(self) -> None:
        """Take back what is latched: a late subscriber must not receive it."""
        node = self._stage.node
        for target in self._latched:
            if target.name in self._publishers:
                node.destroy_publisher(self._publishers[target.name])
            self._publishers[target.name] = node.create_publisher(
                target.type, target.name, _LATCHED
            )
        publishers = self._publishers.values()
        # A node under attack may have lost one.
        self._stage.spin_until(
            lambda: all(each.get_subscription_count() for each in publishers), _DISCOVERY
        )

    def close(self) -> None:
        """End all publishers and clients, and with them what is latched."""
        for publisher in self._publishers.values():
            self._stage.node.destroy_publisher(publisher)
        for client in self._clients.values():
            self._stage.node.destroy_client(client)

    def _connect(self) -> None:
        node = self._stage.node
        self._parameters = self._read_parameters()
        for target in inputs_of(node, self.name):
            self.inputs.append(target)
            self._mutators[target.name] = Mutator(self._rng)
            if target.is_service:
                self._clients[target.name] = node.create_client(target.type, target.name)
                continue
            readers = node.get_subscriptions_info_by_topic(target.name)
            if any(reader.qos_profile.durability == _LATCHED.durability for reader in readers):
                self._latched.append(target)
            else:
                qos = QoSProfile(depth=10)
                self._publishers[target.name] = node.create_publisher(target.type, target.name, qos)
        self.renew_latched()
        # For services too, whose node cannot be asked whether it has found a client.
        self._stage.spin(_DISCOVERY)

    def _read_parameters(self) -> list[Parameter]:
        listed = self._stage.call(f'{self.name}/list_parameters', ListParameters)
        names = [] if listed is None else [n for n in listed.result.names if n not in _NOT_CHANGED]
        request = GetParameters.Request(names=names)
        answer = self._stage.call(f'{self.name}/get_parameters', GetParameters, request)
        values = [] if answer is None else answer.values
        return [Parameter(name=name, value=value) for name, value in zip(names, values)]

    def _publish(self, target: Interface) -> None:
        message = self.example(target)
        if self._rng.random() < _DAMAGED_FRACTION:
            what, data = random_bytes(serialize_message(message), self._rng)
            self._send_bytes(target, data, f'{target} {what}')
        else:
            mutation = self._mutators[target.name].draw(message)
            self.send(target, mutation.message, f'{target} {mutation}')

    def send(self, target: Interface, message: Any, what: str) -> None:
        """
        Publish a message that is not meant well.

        Parameters
        ----------
        target : Interface
            One of the node's topics.
        message : message
            Of that topic's type.
        what : str
            The message in words.
        """
        if target.name == _ROBOTS:
            # Longer names than any robot has are refused anyway.
            self.robots.update(m.ns for m in message.markers if len(m.ns) < _LONGEST_NAME)
        self._send_bytes(target, serialize_message(message), what)

    def _send_bytes(self, target: Interface, data: bytes, what: str) -> None:
        self._note(what)
        self._stage.listener.ignore(data)
        # Not everything passes the middleware itself.
        with contextlib.suppress(RuntimeError):
            self._publishers[target.name].publish(data)

    def _request(self, target: Interface) -> None:
        self._send_request(target, self._mutators[target.name].draw(self.example(target)))

    def _send_request(self, target: Interface, mutation: Mutation) -> None:
        client = self._clients[target.name]
        self._note(f'{target} {mutation}')
        if not client.service_is_ready():
            return
        if target.name == '/reset':
            self._stage.listener.forget_robot()
        reaction = self._stage.reaction(self.name, client.call_async(mutation.message))
        if reaction.is_hang and self.name not in self._stage.dead_nodes():
            self.slow.append(f'{target} {mutation}: {reaction}')

    def example(self, target: Interface) -> Any:
        """Return a valid message: the last one that was received, or one that is made up."""
        if target.name.endswith(('/set_parameters', '/set_parameters_atomically')):
            few = self._parameters
            chosen = [few[int(self._rng.integers(len(few)))]] if few else []
            return target.type.Request(parameters=chosen)
        if target.name == '/get_plan':
            return plan_request(self._stage.pose or _SOMEWHERE)
        if target.is_service:
            return example_of(target.type.Request)
        received = self._stage.listener.last
        if target.name in received:
            return received[target.name]
        made = made_up(target.name, self._stage.pose or _SOMEWHERE, received.get('/joint_states'))
        return example_of(target.type) if made is None else made

    def _note(self, what: str) -> None:
        self.recent = [*self.recent[-19:], what]
        self._stage.listener.context = f'after {what}'
