"""
What the panel shows: what the robot does, what each node says, plots, the camera's picture.
"""

from __future__ import annotations

import html
from collections.abc import Callable
from typing import Any

import numpy as np
import viser
from numpy.typing import NDArray

from quad_common.status import Level
from quad_view.scene.robot_view import RobotView
from quad_view.scene.words import NO_ROBOT

_LEVEL_COLORS = {
    Level.OK: '#2f9e44', Level.WARN: '#f08c00', Level.ERROR: '#e03131', Level.STALE: '#868e96',
}  # fmt: skip

_LINE_COLORS = (
    '#1971c2', '#e8590c', '#2f9e44', '#9c36b5', '#c92a2a', '#0c8599', '#f08c00', '#5f3dc4',
    '#66a80f', '#d6336c', '#495057', '#1098ad',
)  # fmt: skip

_WORD_PERIOD = 0.25
"""Time between two updates of sentences [s]."""

_PICTURE_PERIOD = 0.2
"""Time between two pictures of the camera [s]."""

_PICTURE_WIDTH = 480
"""Largest width of the camera's picture on the page [pixels]."""

_PLOT_HEIGHT = 150
"""Height of a plot [pixels]."""

_ANSWER = 'padding:0 1em .4em;opacity:.75;min-height:1.5em'
"""Style of the answer to the last wish."""


class WordPanel:
    """
    What the robot does, in a sentence, and what each node says.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._gui = server.gui
        self._due = 0.0
        self._shown: dict[str, str] = {}

    def add_headline(self) -> None:
        """Add the sentence, and the answer to the last wish."""
        self._headline = self._gui.add_html('')
        self._answer = self._gui.add_html('')

    def add_nodes(self) -> None:
        """Add what each node says."""
        self._nodes = self._gui.add_html('')

    def draw_none(self) -> None:
        """Say that there is no robot."""
        self._put('headline', self._headline, _paragraph(Level.WARN, NO_ROBOT, '1.0em'))
        self._put('nodes', self._nodes, '')

    def draw(self, view: RobotView, now: float, shown: float) -> None:
        """
        Show the words about a robot, if they are others.

        Parameters
        ----------
        view : RobotView
            The robot.
        now, shown : float
            Time of the wall clock, and time by which the robot's messages were received [s].
        """
        if now < self._due:
            return
        self._due = now + _WORD_PERIOD
        level, sentence = view.headline(shown)
        self._put('headline', self._headline, _paragraph(level, sentence, '1.0em'))
        # There even if it is empty: what is below must not move under somebody's hand.
        answer = html.escape(view.answer) or '&nbsp;'
        self._put('answer', self._answer, f'<div style="{_ANSWER}">{answer}</div>')
        rows = [
            _paragraph(line.level, f'{line.node}: {line.text}', '0.9em')
            for line in view.lines(shown)
        ]
        self._put('nodes', self._nodes, ''.join(rows))

    def _put(self, name: str, handle: Any, text: str) -> None:
        if self._shown.get(name) != text:
            self._shown[name] = text
            handle.content = text


class PlotPanel:
    """
    Plots of the robot that is looked at.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    period : float
        Time between two updates [s].
    """

    def __init__(self, server: viser.ViserServer, period: float) -> None:
        self._gui = server.gui
        self._period = period
        self._due = 0.0
        self._plots: dict[str, tuple[tuple[str, ...], Any]] = {}
        self._place: Any = None

    def add_plots(self) -> None:
        """Add the place where the plots come."""
        self._is_live = self._gui.add_checkbox('Live', True)
        self._place = self._gui.add_folder('Last 20 s')

    def draw(self, view: RobotView, now: float) -> None:
        """Bring the plots up to date, at a time of the wall clock [s]."""
        if now < self._due or not self._is_live.value:
            return
        self._due = now + self._period
        for title, series in view.plots.items():
            names, plot = self._plots.get(title, ((), None))
            data = series.arrays()
            if names == series.names:
                plot.data = data
                continue
            if plot is not None:
                plot.remove()
            with self._place:
                plot = self._gui.add_uplot(
                    data, _series_options(series.names), title=title, height=_PLOT_HEIGHT,
                    scales={'x': {'time': False}, 'y': {'auto': True}},
                    legend={'show': len(series.names) in (2, 3)},
                )  # fmt: skip
            self._plots[title] = series.names, plot


class PicturePanel:
    """
    The camera's picture.

    Parameters
    ----------
    server : viser.ViserServer
        The page.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self._gui = server.gui
        self._due = 0.0
        self._handle: Any = None
        self._drawn: NDArray[np.uint8] | None = None

    def add_picture(self, choose: Callable[[bool], None]) -> None:
        """Add it, and the choice to show it: that is told."""
        self._choice = self._gui.add_checkbox("The camera's picture", False)
        self._choice.on_update(lambda _: choose(bool(self._choice.value)))
        self._text = self._gui.add_markdown('*No picture yet: is there a camera?*', visible=False)
        blank = np.full((2, 4, 3), 200, dtype=np.uint8)
        self._handle = self._gui.add_image(blank, format='jpeg', visible=False)

    def draw(self, view: RobotView, now: float) -> None:
        """Show the picture if it is wanted and another one, at a time of the wall clock [s]."""
        if self._handle is None:
            return
        is_wanted = self._choice.value
        picture = view.picture if is_wanted else None
        self._text.visible = is_wanted and picture is None
        self._handle.visible = picture is not None
        if picture is None or picture is self._drawn or now < self._due:
            return
        self._due, self._drawn = now + _PICTURE_PERIOD, picture
        step = -(-picture.shape[1] // _PICTURE_WIDTH)
        self._handle.image = np.ascontiguousarray(picture[::step, ::step])


def _series_options(names: tuple[str, ...]) -> tuple[Any, ...]:
    lines = [
        {'label': name, 'stroke': _LINE_COLORS[index % len(_LINE_COLORS)], 'width': 1.5}
        for index, name in enumerate(names)
    ]
    return ({'label': 's'}, *lines)


def _paragraph(level: int, text: str, size: str) -> str:
    color = _LEVEL_COLORS[Level(level)]
    return (
        f'<div style="padding:.25em 1em;font-size:{size}">'
        f'<span style="color:{color}">&#9679;</span> {html.escape(text)}</div>'
    )
