"""
``quadwalk bench fleet``: several robots in one world, plans that change, Nav2's actions, a network.
"""

from __future__ import annotations

import importlib.util
import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from action_msgs.msg import GoalStatus
from rich.console import Console

from quad_common.errors import MissingOptionalDependency
from quad_common.planar_pose import Pose2D, wrap_angle
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_gait.parameters import GaitParameters
from quad_lab.benchmarks.changed_plans import replans
from quad_lab.benchmarks.many_robots import speeds, walks
from quad_lab.benchmarks.network_walks import network_bars
from quad_lab.benchmarks.recordings.recorded_demo import recording_bars
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure

ACTIONS = ('goals', 'cancels', 'preemptions')
"""Parts that need nav2_msgs."""

_OTHERS: dict[str, Callable[..., tuple[list[Criterion], dict[str, Any]]]] = {
    'warehouse': partial(walks, 'warehouse'),
    'corridor': partial(walks, 'corridor'),
    'replans': replans,
    'speed': speeds,
    'network': network_bars,
    'recording': recording_bars,
}
"""Functions that measure parts of their own."""

PARTS = (*_OTHERS, *ACTIONS)
"""What can be measured alone."""

GOALS, QUICK_GOALS = 30, 2
CANCELS, QUICK_CANCELS = 20, 2
PREEMPTIONS, QUICK_PREEMPTIONS = 20, 1

QUICK_BUDGET = 12.0
"""A part of the quick sample begins no further goal after so long [s]."""

NEAR, ANGLE = 0.05, math.radians(5.0)
"""A robot that has arrived is this near to its goal [m, rad]."""

LATENCY = 0.5
"""Simulated time that a plan may be on its way, at the pace of the cancellations [s]."""

_ROBOT = 'titan_viii'

_STARTS = {'room': Pose2D(1.2, 1.2, 0.0), 'office': Pose2D(2.0, 2.0, 0.0)}

_PACE, _QUICK_PACE = 2.0, 8.0
"""Times real time, where requests are on their way while the robot walks."""

_PATIENCE = 300.0
"""Time on the wall clock in which a robot has to reach a goal [s]."""

_LATEST, _QUICK_LATEST = 20.0, 6.0
"""A goal is canceled or preempted within so much simulated time [s]."""


@dataclass(frozen=True)
class Trial:
    """One goal, and what became of it."""

    part: str
    """Which part it belongs to."""
    map: str
    """Name of the map."""
    is_right: bool
    """Whether all was as it has to be."""
    what: str
    """What happened, as a sentence."""
    seconds: float
    """From the request until the robot rested, in simulated time [s]."""
    feedbacks: int
    """Number of feedback messages."""


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = PARTS
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk several robots in one world, or over a network; give goals by actions.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        Only a few.
    seed : int
        Of goals and moments.
    only : tuple of str
        Names among :data:`PARTS`.

    Returns
    -------
    tuple
        The bars, and details for JSON: every trial.

    Raises
    ------
    MissingOptionalDependency
        If nav2_msgs is not installed, and a part needs it.
    """
    if set(only) & set(ACTIONS) and importlib.util.find_spec('nav2_msgs') is None:
        raise MissingOptionalDependency('nav2_msgs', 'make nav2')
    counts = {
        'goals': QUICK_GOALS if quick else GOALS,
        'cancels': QUICK_CANCELS if quick else CANCELS,
        'preemptions': QUICK_PREEMPTIONS if quick else PREEMPTIONS,
    }
    run = {'goals': _goals, 'cancels': _cancels, 'preemptions': _preemptions}
    trials: list[Trial] = []
    bars: list[Criterion] = []
    details: dict[str, object] = {'quick': quick, 'seed': seed}
    for part in only:
        if part in _OTHERS:
            held, measured = _OTHERS[part](console, quick, seed)
            bars += held
            details |= measured
            continue
        done: list[Trial] = []
        names = ('room',) if quick else ('office', 'room')
        for index, name in enumerate(names):
            count = (counts[part] + index) // len(names)
            done += run[part](_Stage(console, name, seed + index, quick), count)
        trials += done
        bars += _bars(part, done)
    details['trials'] = [asdict(trial) for trial in trials]
    return bars, details


def _bars(part: str, trials: list[Trial]) -> list[Criterion]:
    names = {
        'goals': 'goals reached by navigate_to_pose',
        'cancels': 'goals canceled, the robot at rest within a cycle',
        'preemptions': 'goals preempted by a newer one, which is reached',
    }
    right = sum(trial.is_right for trial in trials)
    bars = [at_least(names[part], right, f'of {len(trials)}', len(trials))]
    if part == 'goals':
        silent = sum(trial.feedbacks == 0 for trial in trials)
        bars.append(at_most('goals without feedback', silent, '', 0))
    else:
        what = 'a cancellation to rest' if part == 'cancels' else 'a newer goal to its end'
        bars.append(figure(f'longest time from {what}', max(t.seconds for t in trials), 's'))
    return bars


class _Stage:
    """Where trials take place: a map, its goals, and what is drawn at random."""

    def __init__(self, console: Console, name: str, seed: int, quick: bool) -> None:
        self.console = console
        self.name = name
        self.map_file: Path = sample_map(name)
        self.start = _STARTS[name]
        self.rng = np.random.default_rng(seed)
        self.goals = GoalDrawer(load_robot(_ROBOT), self.map_file, seed)
        self.pace = _QUICK_PACE if quick else _PACE
        self.latest = _QUICK_LATEST if quick else _LATEST
        self._deadline = time.monotonic() + (QUICK_BUDGET if quick else math.inf)
        self._count = 0

    def goes_on(self) -> bool:
        """Return whether there is time for one more trial; there is for the first."""
        self._count += 1
        return self._count == 1 or time.monotonic() < self._deadline

    def note(self, trial: Trial) -> Trial:
        """Say what happened."""
        verdict = 'right' if trial.is_right else 'WRONG'
        self.console.print(f'{trial.part} {trial.map}: {verdict}: {trial.what}', highlight=False)
        return trial


def _goals(stage: _Stage, count: int) -> list[Trial]:
    """Go from goal to goal, as fast as the simulator does."""
    # Its modules need nav2_msgs.
    from quad_lab.topic_walk.navigated_robot import navigated_robot

    trials: list[Trial] = []
    with navigated_robot(_ROBOT, stage.map_file, stage.start) as robot:
        while len(trials) < count and stage.goes_on():
            goal = stage.goals.draw(robot.pose, 0.5, 4.0)
            began = robot.time
            robot.client.go_to_pose(goal)
            robot.client.wait_until(robot.client.is_complete, _PATIENCE)
            robot.listen(0.5)
            status, error = robot.client.status, robot.client.result.error_msg
            off, turned = robot.pose.distance_to(goal), abs(wrap_angle(robot.pose.yaw - goal.yaw))
            is_there = off <= NEAR and turned <= ANGLE and not robot.has_fallen
            is_right = status == GoalStatus.STATUS_SUCCEEDED and is_there
            what = error or f'{1e3 * off:.0f} mm and {math.degrees(turned):.1f} degrees off'
            feedbacks = len(robot.client.feedback)
            taken = robot.time - began
            trials.append(stage.note(Trial('goals', stage.name, is_right, what, taken, feedbacks)))
    return trials


def _cancels(stage: _Stage, count: int) -> list[Trial]:
    """Cancel goals at random moments of the walk."""
    from quad_lab.topic_walk.navigated_robot import navigated_robot

    gait, turning = GaitParameters(robot=_ROBOT).gaits(load_robot(_ROBOT))
    limit = max(gait.cycle_period, turning.cycle_period) + LATENCY
    trials: list[Trial] = []
    with navigated_robot(_ROBOT, stage.map_file, stage.start, stage.pace) as robot:
        while len(trials) < count and stage.goes_on():
            robot.client.go_to_pose(stage.goals.draw(robot.pose, 1.5, 5.0))
            robot.listen(float(stage.rng.uniform(0.0, stage.latest)))
            asked_at = robot.time
            is_taken = robot.client.cancel()
            robot.client.wait_until(robot.client.is_complete, _PATIENCE)
            said_after = robot.time - asked_at
            robot.listen(3.0)
            # A request is on its way for longer, the busier the machine is.
            canceled_at = max(asked_at, robot.taken_back_at)
            rested_after = robot.rested_at(canceled_at) - canceled_at
            is_right = (
                is_taken
                and robot.client.status == GoalStatus.STATUS_CANCELED
                and rested_after <= limit
                and not robot.has_fallen
            )
            what = (
                f'at rest {rested_after:.2f} s after the plan was taken back, which took '
                f'{canceled_at - asked_at:.2f} s; said after {said_after:.2f} s'
            )
            feedbacks = len(robot.client.feedback)
            trials.append(
                stage.note(Trial('cancels', stage.name, is_right, what, rested_after, feedbacks))
            )
    return trials


def _preemptions(stage: _Stage, count: int) -> list[Trial]:
    """Give a newer goal at random moments of the walk to an older one."""
    from quad_lab.topic_walk.navigated_robot import navigated_robot

    trials: list[Trial] = []
    with navigated_robot(_ROBOT, stage.map_file, stage.start, stage.pace) as robot:
        client = robot.client
        while len(trials) < count and stage.goes_on():
            client.go_to_pose(stage.goals.draw(robot.pose, 1.5, 5.0))
            older = client.result_future()
            robot.listen(float(stage.rng.uniform(0.0, stage.latest)))
            goal = stage.goals.draw(robot.pose, 0.3, 1.2)
            began = robot.time
            client.go_to_pose(goal)
            client.wait_until(older.done)
            client.wait_until(client.is_complete, _PATIENCE)
            robot.listen(0.5)
            off = robot.pose.distance_to(goal)
            is_right = (
                older.result().status == GoalStatus.STATUS_ABORTED
                and 'preempted' in older.result().result.error_msg
                and client.status == GoalStatus.STATUS_SUCCEEDED
                and off <= NEAR
                and not robot.has_fallen
            )
            what = client.result.error_msg or f'{1e3 * off:.0f} mm off the newer goal'
            taken = robot.time - began
            trials.append(
                stage.note(
                    Trial('preemptions', stage.name, is_right, what, taken, len(client.feedback))
                )
            )
    return trials
