"""
Shows a recording on the viewer's page.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from quad_common.errors import QuadError
from quad_lab.recordings.recorded_messages import RecordedMessages
from quad_view.page.viewer_page import ViewerPage
from quad_view.parameters import ViewerParameters
from quad_view.robot_topics import RobotTopics
from quad_view.scene.page_options import PageOptions
from quad_view.scene.robot_view import RobotView
from quad_view.scene.timeline import Timeline

_PERIOD = 1.0 / 30.0
"""Time between two pictures [s]."""


class Replay:
    """
    A page with a recording in the place of a robot.

    Parameters
    ----------
    folder : Path
        The recording.
    options : PageOptions
        How the page is opened.
    namespace : str
        Namespace of the robot; empty for none.

    Raises
    ------
    RecordingUnusable
        If it cannot be read.
    """

    def __init__(self, folder: Path, options: PageOptions, namespace: str = '') -> None:
        self._messages = messages = RecordedMessages(folder, namespace)
        self.timeline = Timeline(messages.start, messages.end)
        """Time that is shown."""
        self.view = RobotView(namespace)
        """What is shown of the robot."""
        RobotTopics(
            _Inputs(messages.all_of), _Inputs(messages.newest_of), self.view, ViewerParameters(),
            clock=lambda: messages.time,
        )  # fmt: skip
        self.page = ViewerPage(options, timeline=self.timeline)
        """The page."""
        self.page.add_robot(self.view)

    def show(self, passed: float) -> list[QuadError]:
        """Show what follows after some real time [s]; return why messages could not be used."""
        self.timeline.advance(passed)
        shown = self.timeline.time
        if shown < self._messages.time:
            self.view.rewind()
            self._messages.rewind()
        problems = self._messages.go_on_to(shown)
        self.page.draw(time.monotonic(), shown)
        return problems

    def run(self, report: Callable[[QuadError], None]) -> None:
        """Go on until a signal ends it."""
        before = time.monotonic()
        try:
            while True:
                time.sleep(_PERIOD)
                now = time.monotonic()
                for problem in self.show(now - before):
                    report(problem)
                before = now
        finally:
            self.page.close()


class _Inputs:
    """Makes a robot's subscriptions to a recording."""

    def __init__(self, subscribe: Callable[[str, Callable[[Any], None], Any], None]) -> None:
        self._subscribe = subscribe

    def create_subscription(
        self, kind: Any, topic: str, callback: Callable[[Any], None], qos: Any, **options: Any
    ) -> None:
        """Have messages of a topic handed on; the recording decides when."""
        self._subscribe(topic, callback, kind)

    def get_logger(self) -> Any:
        """Return what remarks go to."""
        return self

    def info(self, text: str) -> None:
        """Leave it out: what was remarked when it happened says nothing now."""
