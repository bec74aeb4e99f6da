"""
Walks of imported robots over topics, from a map to goals.
"""

from __future__ import annotations

import math
import time

from rich.console import Console

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.walk import WalkOptions, walk

_ON_TOPICS = ('a1', 'mini_cheetah')

_GOALS = 10

_START = Pose2D(1.2, 1.2, 0.0)
"""Where the first walk over topics begins, in the room."""

_SHORTEST, _LONGEST = 0.5, 4.0
"""Lengths of the plans of these walks [m]."""


def topic_bars(console: Console, names: tuple[str, ...], seed: int) -> list[Criterion]:
    """
    Walk to goals in the sample room over topics.

    Parameters
    ----------
    console : Console
        Where progress is shown.
    names : tuple of str
        Robots that are installed.
    seed : int
        Of the goals.
    """
    robots = [name for name in _ON_TOPICS if name in names]
    bars: list[Criterion] = []
    room = sample_map('room')
    for name in robots:
        drawer = GoalDrawer(load_robot(name), room, seed)
        arrived, off, turned, began = 0, 0.0, 0.0, time.monotonic()
        start = _START
        for number in range(_GOALS):
            goal = drawer.draw(start, _SHORTEST, _LONGEST)
            record = walk(WalkOptions(map_file=room, start=start, goal=goal, robot=name, seed=seed))
            result = record.result()
            arrived += result.arrived
            off = max(off, _or_nan(result.position_error))
            turned = max(turned, abs(_or_nan(result.heading_error)))
            console.print(f'{name}, goal {number + 1} of {_GOALS}: arrived: {result.arrived}')
            start = goal
        bars += [
            at_least(f'{name}: goals reached over topics, of {_GOALS}', arrived, '', _GOALS),
            at_most(f'{name}: final position error', off, 'm', 0.05),
            at_most(f'{name}: final heading error', turned, 'deg', 5.0),
            figure(f'{name}: time of these walks', time.monotonic() - began, 's'),
        ]
    return bars


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value
