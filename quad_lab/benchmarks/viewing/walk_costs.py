"""
What looking at a walk, and recording it, costs: walks with it and without, in turns.
"""

from __future__ import annotations

import contextlib
import math
import statistics
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

from nav_msgs.msg import Odometry
from rich.console import Console
from sensor_msgs.msg import Imu, JointState

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_lab.recordings.recording_reader import open_recording
from quad_lab.recordings.subscription import message_of
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_lab.tools.page_reader import PageReader
from quad_lab.topic_walk.recorded_walk import read_walks
from quad_lab.topic_walk.viewer_process import PagePlace
from quad_lab.topic_walk.walk import WalkOptions, walk
from quad_lab.topic_walk.walk_record import WalkRecord

_REGULAR = {'odom': Odometry, 'joint_states': JointState, 'imu': Imu}
"""Topics that come at a fixed rate, so that a recording shows what it lacks."""


@dataclass(frozen=True)
class Course:
    """What is walked again and again."""

    start: Pose2D
    """Pose at the beginning."""
    goal: Pose2D
    """Pose at the end."""
    seed: int
    """Seed of the sensors' noise."""
    page: PagePlace
    """Place of the viewer's page."""

    def options(self, page: PagePlace | None = None, recording: Path | None = None) -> WalkOptions:
        """Return how it is walked, as fast as possible."""
        return WalkOptions(
            map_file=sample_map(), start=self.start, goal=self.goal, seed=self.seed,
            page=page, recording=recording,
        )  # fmt: skip


def viewer_cost(
    console: Console, course: Course, pairs: int, details: dict[str, object]
) -> list[Criterion]:
    """Walk with the viewer and a page that is open, and without."""

    def with_viewer() -> float:
        with contextlib.ExitStack() as readers:

            def read(address: str) -> None:
                readers.enter_context(PageReader(address))

            record = walk(
                course.options(course.page),
                on_page=read,
                on_end=lambda record, go_on: readers.close(),
            )
        return speed_of(record)

    speeds = _in_turns(console, 'the viewer', course, with_viewer, pairs)
    details['cost'] = speeds
    return [
        at_most('speed that the viewer costs, median', _cost(speeds), '', 0.1),
        figure('speed without it, median', statistics.median(speeds['without']), 'x real time'),
    ]


def recording_cost(
    console: Console, course: Course, pairs: int, details: dict[str, object]
) -> list[Criterion]:
    """Walk with a recording and without; look for what a recording lacks, or tells otherwise."""
    lost: list[int] = []
    other: list[int] = []

    def with_recording() -> float:
        with tempfile.TemporaryDirectory(prefix='quadwalk_') as folder:
            recording = Path(folder) / 'recording'
            record = walk(course.options(recording=recording))
            lost.append(messages_lost(recording))
            other.append(other_figures(record, recording))
        return speed_of(record)

    speeds = _in_turns(console, 'a recording', course, with_recording, pairs)
    details['recording'] = {**speeds, 'lost': lost, 'other_figures': other}
    return [
        at_most('speed that a recording costs, median', _cost(speeds), '', 0.05),
        at_most('messages that recordings lack', sum(lost), '', 0),
        at_most('figures of recordings that differ from the walk', sum(other), '', 0),
    ]


def speed_of(record: WalkRecord) -> float:
    """Return simulated over real time; NaN of a robot that did not arrive."""
    result = record.result()
    speed = result.as_dict()['real_time_factor']
    return float(speed) if result.arrived and isinstance(speed, float) else math.nan


def messages_lost(folder: Path) -> int:
    """Count what is missing, by their stamps, between messages that come at a fixed rate."""
    stamps: dict[str, list[int]] = {name: [] for name in _REGULAR}
    with open_recording(folder) as messages:
        for name, _, data in messages:
            if name in stamps:
                stamp = message_of(data, _REGULAR[name]).header.stamp
                stamps[name].append(stamp.sec * 10**9 + stamp.nanosec)
    return sum(missing(times) for times in stamps.values())


def missing(stamps: Sequence[int]) -> int:
    """
    Count the gaps in a series that was regular.

    Parameters
    ----------
    stamps : sequence of int
        Times in any order [ns].

    Returns
    -------
    int
        Number of times that are not there between the first and the last one; the period is the
        median step. 1 if there are fewer than two: nothing was recorded.
    """
    times = sorted(set(stamps))
    if len(times) < 2:
        return 1
    steps = [after - before for before, after in pairwise(times)]
    period = statistics.median(steps)
    return round((times[-1] - times[0]) / period) + 1 - len(times)


def other_figures(record: WalkRecord, folder: Path) -> int:
    """Count the figures of a walk that are others in its recording."""
    live = record.result().as_dict()
    recorded: dict[str, Any] = read_walks(folder).walks[-1].result().as_dict()
    return sum(recorded.get(name) != figure for name, figure in live.items())


def _in_turns(
    console: Console, what: str, course: Course, walk_with: Callable[[], float], pairs: int
) -> dict[str, list[float]]:
    """Walk with something and without it; return simulated over real time of both."""
    speeds: dict[str, list[float]] = {'with': [], 'without': []}
    for number in range(pairs):
        # The second of two walks finds the machine warmer: each kind comes first as often.
        for kind in ('without', 'with') if number % 2 == 0 else ('with', 'without'):
            speed = walk_with() if kind == 'with' else speed_of(walk(course.options()))
            speeds[kind].append(speed)
            console.print(f'{kind} {what}: {speed:.2f} times real time', highlight=False)
    return speeds


def _cost(speeds: dict[str, list[float]]) -> float:
    """Return the fraction of speed that is lost, the median over pairs."""
    pairs = zip(speeds['with'], speeds['without'], strict=True)
    return 1.0 - statistics.median(slow / fast for slow, fast in pairs)
