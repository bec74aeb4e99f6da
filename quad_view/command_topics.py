"""
What ``viewer_node`` publishes and requests of one robot, as anybody could.
"""

from __future__ import annotations

import time
from typing import Any

from geometry_msgs.msg import PoseStamped, Twist, TwistStamped
from rcl_interfaces.srv import SetParameters
from rclpy.task import Future
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import MarkerArray

from quad_common.ros.ros_node import QuadNode
from quad_view.parameters import ViewerParameters
from quad_view.robot_topics import NamedTopics
from quad_view.ros_conversions import (
    OWN,
    goal_message,
    no_obstacles_message,
    obstacle_message,
    option_request,
    twist_message,
)
from quad_view.scene.commands import (
    ClearObstacles,
    Command,
    EmergencyStop,
    GiveGoal,
    PutObstacle,
    Request,
    SetOption,
    Steer,
)
from quad_view.scene.pad import Pad
from quad_view.scene.robot_view import RobotView

SERVERS = {
    'stand': 'gait_node',
    'sit': 'gait_node',
    'stop': 'gait_node',
    'emergency_stop': 'gait_node',
    'reset': 'sim_node',
    'pause': 'sim_node',
    'unpause': 'sim_node',
}
"""The node that offers each service."""


class CommandTopics:
    """
    Sends what a person at the page asks for, and says what was answered.

    Parameters
    ----------
    node : QuadNode
        The node.
    view : RobotView
        The robot that is shown; it gets the answers.
    parameters : ViewerParameters
        Of the node.
    """

    def __init__(self, node: QuadNode[Any], view: RobotView, parameters: ViewerParameters) -> None:
        p = parameters
        self._node = node
        self._view = view
        self._frame = p.map_frame
        self._is_stamped = p.stamped_cmd_vel
        self._prefix = f'/{view.name}/' if view.name else '/'
        self._pad = Pad()
        self._last_number = 0
        self._clients: dict[str, Any] = {}
        named = self._named = NamedTopics(node, self._prefix)
        self._goals = named.create_publisher(PoseStamped, 'goal_pose', 10)
        twist = TwistStamped if p.stamped_cmd_vel else Twist
        self._twists = named.create_publisher(twist, 'cmd_vel', 10)
        self._obstacle_changes = named.create_publisher(MarkerArray, 'obstacles', 10)

    def carry_out(self, command: Command) -> None:
        """Do what is asked for."""
        if isinstance(command, GiveGoal):
            self._give_goal(command)
        elif isinstance(command, Steer):
            self._pad.hold(command.twist, time.monotonic(), command.duration)
            self.steer()
        elif isinstance(command, Request):
            self._pad.let_go()
            self._call(Trigger, command.service, Trigger.Request())
        elif isinstance(command, EmergencyStop):
            self._pad.let_go()
            self._call(SetBool, 'emergency_stop', SetBool.Request(data=command.is_on))
        elif isinstance(command, SetOption):
            service = f'{command.node}/set_parameters'
            self._call(SetParameters, service, option_request(command.name, command.value))
        elif isinstance(command, PutObstacle):
            self._change(obstacle_message(command, self._unused_number(), self._frame))
        elif isinstance(command, ClearObstacles):
            self._change(no_obstacles_message())

    def end(self) -> None:
        """Send nothing more."""
        self._named.end()
        for client in self._clients.values():
            self._node.destroy_client(client)
        self._clients = {}

    def steer(self) -> None:
        """Publish what the pad says, if it says anything; called several times a second."""
        twist = self._pad.command(time.monotonic())
        if twist is not None:
            self._twists.publish(twist_message(twist, self._is_stamped))
            if twist and self._twists.get_subscription_count() == 0:
                self._view.note(answer='nobody steers by cmd_vel: gait_node is missing')

    def _give_goal(self, command: GiveGoal) -> None:
        goal = command.goal
        self._pad.let_go()
        # Shown at once, not when it comes back over the topic.
        self._view.note(goal=goal)
        self._goals.publish(goal_message(goal, self._frame))
        answer = f'goal given: ({goal.x:.2f}, {goal.y:.2f}) m'
        if self._goals.get_subscription_count() == 0:
            answer = 'nobody takes goals: planner_node is missing; start it with: planner_node'
        self._view.note(answer=answer)

    def _unused_number(self) -> int:
        """Return the number of an obstacle that is not there yet, nor asked for."""
        numbers = (number for name, number in self._view.obstacles if name == OWN)
        self._last_number = max(self._last_number, *numbers, 0) + 1
        return self._last_number

    def _change(self, message: MarkerArray) -> None:
        self._obstacle_changes.publish(message)
        answer = 'the simulation is asked to; the map, and so the plan, stay as they are'
        if self._obstacle_changes.get_subscription_count() == 0:
            answer = 'nobody takes obstacles: sim_node is missing'
        self._view.note(answer=answer)

    def _call(self, kind: Any, service: str, request: Any) -> None:
        """Call a service if it is there, and show its answer when it comes."""
        if service not in self._clients:
            self._clients[service] = self._node.create_client(kind, f'{self._prefix}{service}')
        client = self._clients[service]
        server = SERVERS.get(service, service.partition('/')[0])
        if not client.service_is_ready():
            self._view.note(answer=f"nobody offers '{service}': {server} is missing")
            return

        def show(future: Future) -> None:
            answer = future.result()
            results = getattr(answer, 'results', None)
            if results is not None:
                is_refused = bool(results) and not results[0].successful
                text = results[0].reason if is_refused else 'changed'
                if is_refused:
                    # What was chosen is not what the node has.
                    self._view.note(options=self._view.options)
                self._view.note(answer=f'{server}: {text}')
            else:
                self._view.note(answer=f'{service}: {answer.message}')

        client.call_async(request).add_done_callback(self._node.guarded(show, 'an answer'))
