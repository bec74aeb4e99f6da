"""
Buttons and slider for the time of a recording.
"""

from __future__ import annotations

import math
from typing import Any

import viser

from quad_view.scene.timeline import SPEEDS, Timeline

_STEP = 0.05
"""Between two places of the slider [s]."""

_MOVED = 0.2
"""The slider follows the time in such steps: each is sent to every browser [s]."""


class ReplayPanel:
    """
    What stands in the place of :class:`~quad_view.page.controls.Controls` for a recording.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    timeline : Timeline
        What is set.
    """

    def __init__(self, server: viser.ViserServer, timeline: Timeline) -> None:
        self._gui = server.gui
        self._timeline = timeline
        self._robot = ''

    @property
    def robot(self) -> str:
        """Namespace of the robot that is looked at."""
        return self._robot

    def show_robots(self, names: list[str]) -> None:
        """Look at the robot that was recorded."""
        self._robot = names[0]

    def add_first(self) -> None:
        """Add what is always in sight: the time."""
        gui, timeline = self._gui, self._timeline
        longest = max(math.ceil(timeline.duration / _STEP), 1) * _STEP
        self._slider: Any = gui.add_slider('Time [s]', 0.0, longest, _STEP, 0.0)
        self._slider.on_update(self._set_time)
        self._button = gui.add_button('Pause', hint='Key P')
        self._button.on_click(self._toggle)
        gui.add_command('Play or pause', hotkey='P').on_trigger(self._toggle)
        names = tuple(f'{speed:g}x' for speed in SPEEDS)
        self._speed = gui.add_dropdown('Speed', names, initial_value='1x')
        self._speed.on_update(self._choose_speed)

    def add_choice_of_robot(self) -> None:
        """Add nothing: there is one."""

    def add_tabs(self, tabs: Any) -> None:
        """Add nothing: what is over cannot be steered."""

    def follow(self) -> None:
        """Show where the time is."""
        elapsed = self._timeline.elapsed
        has_stopped = not self._timeline.is_playing
        if abs(self._slider.value - elapsed) >= _MOVED or has_stopped:
            place = min(round(elapsed / _STEP) * _STEP, self._slider.max)
            if self._slider.value != place:
                self._slider.value = place
        label = 'Play' if has_stopped else 'Pause'
        if self._button.label != label:
            self._button.label = label

    def _set_time(self, event: Any) -> None:
        # What this program sets comes by here too; nobody's hand is in it then.
        if event.client is not None:
            self._timeline.seek(float(self._slider.value))

    def _toggle(self, _: Any) -> None:
        self._timeline.toggle()

    def _choose_speed(self, _: Any) -> None:
        self._timeline.speed = float(self._speed.value[:-1])
