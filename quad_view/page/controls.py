"""
Buttons, keys, choices and the speed pad.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import viser

from quad_common.planar_pose import Pose2D, Twist2D
from quad_view.scene.commands import (
    ClearObstacles,
    Command,
    EmergencyStop,
    Request,
    SetOption,
    Steer,
)
from quad_view.scene.pad import HELD, KEY_HELD
from quad_view.scene.page_options import PageOptions

METHODS = ('mesh', 'shortest', 'quickest', 'potential')
"""Planning methods of planner_node."""

TURNINGS = ('in_place', 'crab', 'arc')
"""Turning styles of gait_node."""

GOAL, OBSTACLE = 'gives a goal', 'puts an obstacle'
"""What a click on the floor may do."""

_HOLD_RATE = 10.0
"""Rate at which a page repeats a button that is held [Hz]."""

_OBSTACLE_SIZE = (0.4, 0.4, 0.3)

_STEERING: tuple[tuple[str, Any, tuple[int, int, int]], ...] = (
    ('Forward', 'I', (1, 0, 0)),
    ('Back', 'K', (-1, 0, 0)),
    ('Left', 'J', (0, 1, 0)),
    ('Right', 'L', (0, -1, 0)),
    ('Turn left', 'U', (0, 0, 1)),
    ('Turn right', 'O', (0, 0, -1)),
)
"""Label, key and direction of each button of the pad."""

_UNKNOWN = 'not known yet'
"""Choice before a node has said what it has."""

_SERVICES = {'Stop': 'stop', 'Stand': 'stand', 'Sit': 'sit', 'Reset': 'reset'}
"""Service of each button."""


class Controls:
    """
    Everything to press and to choose.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    options : PageOptions
        What can be chosen.
    send : callable
        Takes a command; from any thread.
    """

    def __init__(
        self,
        server: viser.ViserServer,
        options: PageOptions,
        send: Callable[[Command], None],
    ) -> None:
        self._gui = server.gui
        self._options = options
        self._send = send
        self._robot = ''
        self._choices: dict[str, Any] = {}

    @property
    def robot(self) -> str:
        """Namespace of the robot that commands are for."""
        return self._robot

    def add_first(self) -> None:
        """Add what is always in sight: the emergency stop."""
        stop = self._gui.add_button(
            'EMERGENCY STOP',
            color='red',
            icon=viser.Icon.HAND_STOP,
            hint='Key X: freeze all joints',
        )
        stop.on_click(lambda _: self._send(EmergencyStop(self._robot, True)))
        key = self._gui.add_command('Emergency stop', hotkey='X', icon=viser.Icon.HAND_STOP)
        key.on_trigger(lambda _: self._send(EmergencyStop(self._robot, True)))
        release = self._gui.add_button('Release the emergency stop', color='gray')
        release.on_click(lambda _: self._send(EmergencyStop(self._robot, False)))

    def add_choice_of_robot(self) -> None:
        """Add the choice between robots; it is seen when there are several."""
        self._robots: Any = self._gui.add_dropdown('Robot', ('',), visible=False)
        self._robots.on_update(self._choose_robot)

    def show_robots(self, names: list[str]) -> None:
        """Let the user choose between robots."""
        if self._robot not in names:
            self._robot = names[0] if names else ''
        self._robots.options = tuple(names) or ('',)
        self._robots.value = self._robot
        self._robots.visible = len(names) > 1

    def add_tabs(self, tabs: Any) -> None:
        """Add what walks the robot."""
        with tabs.add_tab('Walk'):
            self._add_walking()
            self._add_options()
        with tabs.add_tab('Steer'):
            self._add_pad()

    def _add_walking(self) -> None:
        """Add what a click does, and the services."""
        gui = self._gui
        self._click = gui.add_dropdown('A click on the floor', (GOAL, OBSTACLE))
        self._has_heading = gui.add_checkbox(
            'with this heading', False, hint='Else the heading in which the robot comes'
        )
        self._heading = gui.add_slider('Heading [deg]', -180, 180, 5, 0)
        gui.add_markdown('*Shift and drag on the floor: a goal with the heading of the drag.*')
        services: Any = gui.add_button_group(
            'The robot', tuple(_SERVICES), hint='Reset puts the simulated robot back to its start'
        )
        services.on_click(self._request)
        clear = gui.add_button('Take all obstacles away', color='gray')
        clear.on_click(lambda _: self._send(ClearObstacles(self._robot)))

    def _add_pad(self) -> None:
        """Add the speed pad."""
        self._gui.add_markdown(
            '*Hold a button or its key to steer: the robot stops when you let go, or when the '
            'connection to this page is lost.*'
        )
        self._speed = self._gui.add_slider('Speed [%]', 5, 100, 5, 50)
        for label, key, direction in _STEERING:
            self._add_steering(label, key, direction)

    def _add_options(self) -> None:
        """Add gait, turning style and planning method."""
        for label, choices, node, name in (
            ('Gait', self._options.gaits, 'gait_node', 'gait'),
            ('Turning', TURNINGS, 'gait_node', 'turning'),
            ('Planning method', METHODS, 'planner_node', 'method'),
        ):
            # Nothing is chosen until the node has said what it has.
            choice: Any = self._gui.add_dropdown(label, (_UNKNOWN, *choices))
            choice.on_update(partial(self._choose, node, name))
            self._choices[name] = choice

    def show_options(self, options: Mapping[str, str]) -> None:
        """Show what the nodes have, by names of parameters; a file of one's own by its path."""
        for name, choice in self._choices.items():
            value = options.get(name, _UNKNOWN)
            if value not in choice.options:
                choice.options = (*choice.options, value)
            if choice.value != value:
                choice.value = value

    @property
    def puts_obstacles(self) -> bool:
        """Whether a click on the floor puts an obstacle."""
        return bool(self._click.value == OBSTACLE)

    @property
    def obstacle_size(self) -> tuple[float, float, float]:
        """Size of an obstacle: length, width and height [m]."""
        return _OBSTACLE_SIZE

    def with_heading(self, goal: Pose2D) -> Pose2D:
        """Give a goal of a click the heading that was set, if one is."""
        if not self._has_heading.value:
            return goal
        return Pose2D(goal.x, goal.y, math.radians(self._heading.value))

    def _choose_robot(self, _: Any) -> None:
        self._robot = self._robots.value

    def _request(self, event: Any) -> None:
        self._send(Request(self._robot, _SERVICES[event.target.value]))

    def _choose(self, node: str, name: str, event: Any) -> None:
        # What the nodes have is shown here too; nobody's hand is in it then.
        if event.client is not None and event.target.value != _UNKNOWN:
            self._send(SetOption(self._robot, node, name, event.target.value))

    def _add_steering(self, label: str, key: Any, direction: tuple[int, int, int]) -> None:
        button = self._gui.add_button(f'{label} ({key})', hint=f'Hold it, or the key {key}')
        button.on_hold(lambda _: self._steer(direction, HELD), callback_hz=_HOLD_RATE)
        command = self._gui.add_command(f'Steer: {label.lower()}', hotkey=key)
        command.on_trigger(lambda _: self._steer(direction, KEY_HELD))

    def _steer(self, direction: tuple[int, int, int], duration: float) -> None:
        part = self._speed.value / 100.0
        speed = part * self._options.largest_speed
        turn = part * self._options.largest_turn
        forward, left, turning = direction
        twist = Twist2D(forward * speed, left * speed, turning * turn)
        self._send(Steer(self._robot, twist, duration))
