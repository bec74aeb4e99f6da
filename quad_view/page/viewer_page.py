"""
The page: robots and their room in the scene, words, plots and buttons beside it.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable

from quad_view.page.controls import Controls
from quad_view.page.course_figure import CourseFigure
from quad_view.page.floor_figure import FloorFigure
from quad_view.page.panels import PicturePanel, PlotPanel, WordPanel
from quad_view.page.pointing import Pointing
from quad_view.page.replay_panel import ReplayPanel
from quad_view.page.robot_figure import RobotFigure
from quad_view.page.server import is_loopback, open_server
from quad_view.scene.commands import Command, ShowPicture
from quad_view.scene.page_options import PageOptions
from quad_view.scene.robot_view import RobotView
from quad_view.scene.timeline import Timeline

_UNSEEN_PERIOD = 0.5
"""Time between two updates while nobody looks [s]."""


class ViewerPage:
    """
    The page in the browser.

    Parameters
    ----------
    options : PageOptions
        How it is opened, and what can be chosen.
    send : callable, optional
        Takes a command of whoever looks at the page; called by threads of the page. Without it
        nothing can be commanded.
    timeline : Timeline, optional
        Time of the recording that is shown, for a page without commands.
    """

    def __init__(
        self,
        options: PageOptions,
        send: Callable[[Command], None] | None = None,
        timeline: Timeline | None = None,
    ) -> None:
        self._options = options
        self._server = server = open_server(options.host, options.port, 'quadwalk')
        self._robots: dict[str, RobotView] = {}
        self._figures: dict[str, tuple[RobotFigure, CourseFigure]] = {}
        self._numbers = itertools.count()
        self._due = 0.0
        self._chosen: RobotView | None = None
        self._floor = FloorFigure(server)
        self._controls: Controls | ReplayPanel
        self._pointing: Pointing | None = None
        if send is not None:
            controls = self._controls = Controls(server, options, send)
            self._pointing = Pointing(server, controls, self._robot_looked_at, send)
        else:
            self._controls = ReplayPanel(server, timeline or Timeline(0.0, 0.0))
        self._words = WordPanel(server)
        self._plots = PlotPanel(server, 1.0 / options.plot_rate)
        self._picture = PicturePanel(server)
        self._has_camera = False
        self._arrange(send)

    @property
    def address(self) -> str:
        """Where the page is."""
        host = self._options.host
        name = 'localhost' if host in ('0.0.0.0', '::') or is_loopback(host) else host
        return f'http://{name}:{self._server.get_port()}'

    @property
    def readers(self) -> int:
        """Number of browsers that show it."""
        return len(self._server.get_clients())

    def invitation(self) -> str:
        """Say how to open the page, from this machine and from others."""
        port = self._server.get_port()
        if not is_loopback(self._options.host):
            return f'open {self.address}; whoever reaches this address can steer the robot'
        return (
            f'open {self.address}; from another machine: ssh -L {port}:localhost:{port} <this '
            f'machine>, then the same address there'
        )

    def add_robot(self, view: RobotView) -> None:
        """Show another robot."""
        number = next(self._numbers)
        self._robots[view.name] = view
        self._figures[view.name] = (
            RobotFigure(self._server, view, number), CourseFigure(self._server, view, number)
        )  # fmt: skip
        self._controls.show_robots(list(self._robots))

    def remove_robot(self, name: str) -> None:
        """Show a robot no more."""
        del self._robots[name]
        for figure in self._figures.pop(name):
            figure.remove()
        self._controls.show_robots(list(self._robots))

    def is_due(self, now: float) -> bool:
        """Return whether to bring it up to date, at a time of the wall clock [s]."""
        return self.readers > 0 or now >= self._due

    def draw(self, now: float, shown: float | None = None) -> None:
        """
        Send what has changed.

        Parameters
        ----------
        now : float
            Time of the wall clock [s].
        shown : float, optional
            Time that is shown of a recording [s]; the wall clock's if not given.
        """
        self._due = now + _UNSEEN_PERIOD
        looked_at, has_options = self._robot_looked_at(), False
        with self._server.atomic():
            for name, view in self._robots.items():
                changed = view.take_changes()
                robot, course = self._figures[name]
                robot.draw(changed)
                course.draw(changed, now)
                has_options = has_options or (view is looked_at and 'options' in changed)
                if view is looked_at and self._floor.draw(view, changed):
                    if self._pointing is not None:
                        self._pointing.watch(self._floor.handle)
                    self._place_camera(view)
        if looked_at is None:
            self._words.draw_none()
        else:
            self._words.draw(looked_at, now, now if shown is None else shown)
            self._plots.draw(looked_at, now)
            self._picture.draw(looked_at, now)
        if isinstance(self._controls, ReplayPanel):
            self._controls.follow()
        elif looked_at is not None and (has_options or looked_at is not self._chosen):
            self._chosen = looked_at
            self._controls.show_options(looked_at.options)

    def close(self) -> None:
        """Close the page."""
        self._server.stop()

    def _robot_looked_at(self) -> RobotView | None:
        return self._robots.get(self._controls.robot)

    def _arrange(self, send: Callable[[Command], None] | None) -> None:
        """Put everything into its place."""
        server = self._server
        server.gui.main_panel.dock_right()
        server.scene.set_up_direction('+z')
        server.scene.configure_default_lights(enabled=True, cast_shadow=False)
        # A sky is costly to draw without a graphics card.
        server.scene.configure_environment_map(None)
        server.scene.add_light_ambient('/light', intensity=0.6)
        # First, so that it stays where it is whatever the sentences below take.
        self._controls.add_first()
        self._words.add_headline()
        self._controls.add_choice_of_robot()
        tabs = server.gui.add_tab_group()
        self._controls.add_tabs(tabs)
        with tabs.add_tab('Plots'):
            self._plots.add_plots()
        with tabs.add_tab('Nodes'):
            self._words.add_nodes()
        if send is not None:
            with tabs.add_tab('Camera'):
                self._picture.add_picture(
                    lambda is_shown: send(ShowPicture(self._controls.robot, is_shown))
                )

    def _place_camera(self, view: RobotView) -> None:
        """Look at the whole room, once."""
        if self._has_camera or view.floor is None:
            return
        self._has_camera = True
        center, (width, height) = view.floor.center, view.floor.size
        size = max(width, height)
        position = (center.x, center.y - 0.55 * size, 0.66 * size)
        camera = self._server.initial_camera
        camera.position, camera.look_at = position, (center.x, center.y, 0.0)
        for client in self._server.get_clients().values():
            with client.atomic():
                client.camera.up_direction = (0.0, 0.0, 1.0)
                client.camera.position = position
                client.camera.look_at = (center.x, center.y, 0.0)
