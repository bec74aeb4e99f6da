"""
What a running node subscribes to, serves and publishes: read from the graph, not from a list.
"""

from __future__ import annotations

import importlib
from dataclasses import dataclass
from typing import Any

UNHEARD = ('/parameter_events',)
"""Topics that rclpy itself subscribes to, and only for the node's own parameters."""


_PARTS = {'SendGoal': 'SendGoalService', 'GetResult': 'GetResultService'}
"""What rclpy calls the services of an action."""

_ANSWERED_LATER = '/_action/get_result'
"""Services that answer when a goal has ended, and not before."""


@dataclass(frozen=True)
class Interface:
    """A topic or a service of a node."""

    name: str
    """Full name, for example ``/goal_pose``."""
    type_name: str
    """For example ``geometry_msgs/msg/PoseStamped``."""
    is_service: bool = False

    @property
    def type(self) -> Any:
        """The class of its messages, or of the service."""
        return class_of(self.type_name)

    def __str__(self) -> str:
        return self.name.lstrip('/')


def class_of(type_name: str) -> Any:
    """
    Find the class of a ROS type.

    Parameters
    ----------
    type_name : str
        ``package/msg/Name`` or ``package/srv/Name``; or what an action is made of,
        ``package/action/Name_SendGoal`` for example.

    Returns
    -------
    type
        The Python class.
    """
    package, folder, name = type_name.split('/')
    module = importlib.import_module(f'{package}.{folder}')
    if folder == 'action':
        action, _, part = name.rpartition('_')
        return getattr(getattr(module, action).Impl, _PARTS.get(part, part))
    return getattr(module, name)


def inputs_of(observer: Any, node: str) -> list[Interface]:
    """
    List what a node subscribes to and serves.

    Parameters
    ----------
    observer : rclpy.node.Node
        Who looks at the graph; the other node must have been discovered.
    node : str
        Name of the other node, in the root namespace.

    Returns
    -------
    list of Interface
        Its subscribed topics and its services, those of its parameters and actions included.

    Raises
    ------
    rclpy.node.NodeNameNonExistentError
        If there is no such node yet.
    """
    topics = observer.get_subscriber_names_and_types_by_node(node, '/')
    services = observer.get_service_names_and_types_by_node(node, '/')
    return [
        *(Interface(name, types[0]) for name, types in sorted(topics) if name not in UNHEARD),
        *(
            Interface(name, types[0], True)
            for name, types in sorted(services)
            if not name.endswith(_ANSWERED_LATER)
        ),
    ]


def outputs_of(observer: Any, node: str) -> list[Interface]:
    """List the topics that a node publishes; arguments as for :func:`inputs_of`."""
    topics = observer.get_publisher_names_and_types_by_node(node, '/')
    return [Interface(name, types[0]) for name, types in sorted(topics)]
