"""
The node that shows robots on a page in the browser, and lets people walk them from there.
"""

from __future__ import annotations

if __name__ == '__main__':
    # What follows takes seconds to import; signals count before.
    from quad_view.__main__ import main as start

    raise SystemExit(start())

import time
from functools import partial
from typing import Any

import rclpy
from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from quad_common.ros.ros_node import OK, WARN, QuadNode
from quad_common.ros.run_node import run_node
from quad_view.page.viewer_page import ViewerPage
from quad_view.parameters import ViewerParameters
from quad_view.scene.commands import Command, ShowPicture
from quad_view.scene.robots import namespaces_of
from quad_view.shown_topics import ShownRobots

_SEARCH_PERIOD = 0.5
"""Time between two searches for robots [s]."""

_JOINT_STATES = 'sensor_msgs/msg/JointState'


class ViewerNode(QuadNode[ViewerParameters]):
    """Shows what is received of each robot, and sends what is asked for on the page."""

    def __init__(self, **kwargs: Any) -> None:
        # It has no use for a clock: it shows what comes when it comes.
        super().__init__('viewer_node', ViewerParameters, **kwargs)
        p = self.parameters
        self._inputs = rclpy.create_node(
            'viewer_inputs',
            context=self.context,
            use_global_arguments=False,
            enable_rosout=False,
            start_parameter_services=False,
        )
        self._page = ViewerPage(p.page_options, self._take_command)
        self._robots = ShownRobots(self, self._inputs, self._page)
        clock = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / p.rate, self._on_frame, clock=clock)
        self.create_timer(_SEARCH_PERIOD, self._find_robots, clock=clock)
        self._find_robots()
        self.get_logger().info(self._page.invitation())
        self.update_status()

    def update_status(self) -> None:
        """Report where the page is, and what it shows."""
        shown = [robot.view for robot in self._robots]
        now = time.monotonic()
        silent = [robot.name or 'the robot' for robot in shown if not robot.has_robot(now)]
        values = {'pages': self._page.readers, 'robots': len(shown), 'address': self._page.address}
        if not shown:
            self.report(WARN, 'no robot: waiting for joint_states of one', True, **values)
        elif silent:
            self.report(WARN, f'no odometry of {", ".join(silent)}: waiting for it', True, **values)
        else:
            self.report(OK, f'showing the robot at {self._page.address}', False, **values)

    def destroy_node(self) -> None:
        """Close the page."""
        self._page.close()
        self._inputs.destroy_node()
        super().destroy_node()

    def _take_command(self, command: Command) -> None:
        """Have a command carried out by the executor; called by threads of the page."""
        self.call_soon(partial(self._carry_out, command))

    def _carry_out(self, command: Command) -> None:
        robot = self._robots.get(command.robot)
        if robot is None:
            # The page says that there is none.
            return
        if not isinstance(command, ShowPicture):
            robot.commands.carry_out(command)
        elif command.is_shown:
            robot.topics.receive_pictures(robot.sampled)
        else:
            # None is taken that nobody looks at.
            robot.sampled.end(self.parameters.picture_topic)
            robot.view.note(picture=None)

    def _on_frame(self) -> None:
        """Show what has come since the last frame, or seldom while nobody looks."""
        now = time.monotonic()
        for robot in self._robots:
            robot.commands.steer()
        if self._page.is_due(now):
            for robot in self._robots:
                # What one robot's messages lead to keeps none of the others from the page.
                for problem in self.guarded(robot.sampled.look, 'a message')() or ():
                    self.report_error(problem)
            self._page.draw(now)

    def _find_robots(self) -> None:
        """Show the robots whose joint states are published, or that were asked for."""
        published = [
            name
            for name, kinds in self.get_topic_names_and_types()
            if _JOINT_STATES in kinds and self.count_publishers(name)
        ]
        names = namespaces_of(self.parameters.robots, published)
        self._robots.match(names, time.monotonic())


def main(args: list[str] | None = None) -> int:
    """Run the viewer node."""
    return run_node(ViewerNode, args)
