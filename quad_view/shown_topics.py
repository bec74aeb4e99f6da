"""
The robots on the page: each comes with its joint states, and goes some time after them.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator
from typing import Any, NamedTuple

from quad_common.ros.ros_node import QuadNode
from quad_view.command_topics import CommandTopics
from quad_view.option_topics import OptionTopics
from quad_view.page.viewer_page import ViewerPage
from quad_view.parameters import ViewerParameters
from quad_view.robot_topics import NamedTopics, RobotTopics, SampledTopics
from quad_view.scene.robot_view import RobotView
from quad_view.scene.robots import MOST_ROBOTS

_GONE = 60.0
"""A robot whose joint states nobody has published for so long is shown no more [s]."""


class ShownRobot(NamedTuple):
    """What belongs to one robot."""

    view: RobotView
    named: NamedTopics
    sampled: SampledTopics
    topics: RobotTopics
    commands: CommandTopics
    options: OptionTopics

    def end(self) -> None:
        """Receive and send nothing more."""
        for part in (self.named, self.sampled, self.commands, self.options):
            part.end()


class ShownRobots:
    """
    Robots that are shown, by their namespaces.

    Parameters
    ----------
    node : QuadNode
        The node.
    inputs : Node
        A node that no executor has, for what is looked at and not waited for.
    page : ViewerPage
        Where they are shown.
    """

    def __init__(self, node: QuadNode[ViewerParameters], inputs: Any, page: ViewerPage) -> None:
        self._node = node
        self._inputs = inputs
        self._page = page
        self._robots: dict[str, ShownRobot] = {}
        self._seen: dict[str, float] = {}

    def __iter__(self) -> Iterator[ShownRobot]:
        return iter(self._robots.values())

    def __len__(self) -> int:
        return len(self._robots)

    def get(self, name: str) -> ShownRobot | None:
        """Return the robot of a namespace, if it is shown."""
        return self._robots.get(name)

    def match(self, names: Collection[str], now: float) -> None:
        """
        Show those that are there, and no longer those that have gone.

        Parameters
        ----------
        names : collection of str
            Namespaces of the robots that are there.
        now : float
            Time of the wall clock [s].
        """
        self._seen.update(dict.fromkeys(names, now))
        gone = sorted(self._robots.keys() - set(names), key=self._seen.__getitem__)
        new = [name for name in names if name not in self._robots]
        too_many = len(self._robots) + len(new) - MOST_ROBOTS
        for number, name in enumerate(gone):
            if number < too_many or now - self._seen[name] > _GONE:
                self._page.remove_robot(name)
                self._robots.pop(name).end()
        for name in new:
            self._robots[name] = self._made(name)
        self._seen = {name: self._seen[name] for name in self._robots}
        for robot in self:
            robot.options.ask()

    def _made(self, name: str) -> ShownRobot:
        node, view, prefix = self._node, RobotView(name), f'/{name}/' if name else '/'
        named, sampled = NamedTopics(node, prefix), SampledTopics(self._inputs, prefix)
        topics = RobotTopics(named, sampled, view, node.parameters)
        commands = CommandTopics(node, view, node.parameters)
        self._page.add_robot(view)
        return ShownRobot(view, named, sampled, topics, commands, OptionTopics(node, view))
