"""
Which gait, turning style and planning method a robot's nodes have now.
"""

from __future__ import annotations

from typing import Any

from rcl_interfaces.msg import ParameterEvent
from rcl_interfaces.srv import GetParameters
from rclpy.parameter import parameter_value_to_python
from rclpy.task import Future

from quad_common.ros.ros_node import QuadNode
from quad_view.scene.commands import OPTIONS
from quad_view.scene.robot_view import RobotView

_DEPTH = 100
"""Changes of parameters that may wait: nodes that start tell of all they have."""


_LONGEST = 500
"""Characters of a value that is shown; that of a file is a path."""


class OptionTopics:
    """
    Asks the nodes once, and then listens to what changes, by whomever.

    Parameters
    ----------
    node : QuadNode
        The node.
    view : RobotView
        The robot that is shown; it gets the values.
    """

    def __init__(self, node: QuadNode[Any], view: RobotView) -> None:
        self._node = node
        self._view = view
        self._prefix = f'/{view.name}/' if view.name else '/'
        self._clients: dict[str, Any] = {
            name: node.create_client(GetParameters, f'{self._prefix}{name}/get_parameters')
            for name in OPTIONS
        }
        self._asked: list[Any] = []
        self._events = node.create_subscription(
            ParameterEvent, '/parameter_events', self._on_event, _DEPTH
        )

    def ask(self) -> None:
        """Ask those that are there and were not asked yet; called now and then."""
        for name, client in list(self._clients.items()):
            if client.service_is_ready():
                self._asked.append(self._clients.pop(name))
                future = client.call_async(GetParameters.Request(names=list(OPTIONS[name])))
                self._take_answer(name, future)

    def end(self) -> None:
        """Ask and receive nothing more."""
        self._node.destroy_subscription(self._events)
        for client in (*self._clients.values(), *self._asked):
            self._node.destroy_client(client)
        self._clients, self._asked = {}, []

    def _take_answer(self, name: str, future: Future) -> None:
        def take(answered: Future) -> None:
            values = getattr(answered.result(), 'values', ())
            self._note(dict(zip(OPTIONS[name], map(parameter_value_to_python, values))))

        future.add_done_callback(self._node.guarded(take, 'an answer'))

    def _on_event(self, message: ParameterEvent) -> None:
        node = message.node.removeprefix(self._prefix)
        if node in OPTIONS:
            changed = [*message.new_parameters, *message.changed_parameters]
            self._note({p.name: parameter_value_to_python(p.value)
                        for p in changed if p.name in OPTIONS[node]})  # fmt: skip

    def _note(self, values: dict[str, Any]) -> None:
        chosen = {
            name: value
            for name, value in values.items()
            if isinstance(value, str) and len(value) <= _LONGEST
        }
        if chosen:
            self._view.note(options={**self._view.options, **chosen})
