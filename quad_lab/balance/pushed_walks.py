"""
Whole walks over topics in a trot that keeps its balance, with pushes on the way.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from itertools import cycle, product
from typing import Any

import numpy as np
from geometry_msgs.msg import WrenchStamped
from rich.console import Console

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.behaviours.activity import Activity
from quad_lab.balance.balance_case import push_unit
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.walk import WalkOptions, walk
from quad_lab.topic_walk.walk_observer import WalkObserver
from quad_lab.topic_walk.walk_record import WalkRecord, WalkResult
from quad_sim.engines.registry import AUTO, resolved
from quad_sim.ros_conversions import push_message

_STARTS = {'room': Pose2D(1.2, 1.2, 0.0), 'office': Pose2D(11.62, 6.70, 0.0)}
"""Maps, and where the first walk on each begins."""

_TURNINGS = ('crab', 'in_place', 'arc')
"""Ways of following a plan, by turns."""

_SHORTEST, _LONGEST = 2.5, 6.0
"""Lengths of plans [m]: three pushes are to come on the way."""

_PUSHES, _DURATION = 3, 0.1
"""Pushes on each way, and how long each lasts, as sim_node has it if it is not told [s]."""

_FIRST, _LAST = 0.1, 0.85
"""Parts of the way between which the pushes are, one in each third of that."""

_APART = 1.5
"""Time from one push to the next, at least [s], simulated."""

_COUNTING = 3.0
"""Time in which the simulator tells how often it pushed, once a walk has ended, at most [s]."""

_NEAR, _HEADED = 0.05, 5.0
"""Distance from the goal [m] and error of the heading [deg] at the end, at most."""


@dataclass(frozen=True)
class PushedWalk:
    """A walk with pushes, and what became of it."""

    robot: str
    map_name: str
    turning: str
    start: Pose2D
    goal: Pose2D
    pushes: int
    """Number of pushes that the simulator counted while the robot walked."""
    push_times: tuple[float, ...]
    """Simulated times at which they were published, after the goal was [s]."""
    result: WalkResult

    @property
    def has_fallen(self) -> bool:
        """Whether it fell, as the simulator sees it, or as the gait does, which lowers it then."""
        return self.result.fallen or self.result.problem.startswith(Activity.FALLEN.value)

    @property
    def is_good(self) -> bool:
        """Whether it was pushed, and is where it was to be, all the same."""
        result, off, turned = self.result, self.result.position_error, self.result.heading_error
        is_there = off is not None and off <= _NEAR and turned is not None and turned <= _HEADED
        return result.arrived and is_there and self.pushes == _PUSHES


class Pushes:
    """
    Pushes a robot on its way, from directions and at places that are drawn.

    Parameters
    ----------
    robot : Robot
        Robot that walks.
    level : float
        Impulse of each push, over m sqrt(g h).
    rng : numpy.random.Generator
        Draws directions and places.
    """

    def __init__(self, robot: Robot, level: float, rng: np.random.Generator) -> None:
        size = level * robot.mass * push_unit(robot) / _DURATION
        angles = rng.uniform(-math.pi, math.pi, _PUSHES)
        self._forces = [
            size * np.array([math.cos(angle), math.sin(angle), 0.0]) for angle in angles
        ]
        parts = (np.arange(_PUSHES) + rng.uniform(0.0, 1.0, _PUSHES)) / _PUSHES
        self._parts = _FIRST + (_LAST - _FIRST) * parts
        self._publisher: Any = None
        self._observer: WalkObserver | None = None
        self._last: Pose2D | None = None
        self._walked = 0.0
        self.times: list[float] = []
        """Simulated times at which it was pushed [s]."""

    def __call__(self, observer: WalkObserver) -> None:
        """Push if the robot is where it is to be pushed next."""
        self._observer = observer
        if self._publisher is None:
            self._publisher = observer.publisher(WrenchStamped, 'push')
        pose, plan, given = observer.pose, observer.plan, len(self.times)
        if pose is None or plan is None or given == _PUSHES:
            return
        self._walked += pose.distance_to(self._last or pose)
        self._last = pose
        is_time = not self.times or observer.time >= self.times[-1] + _APART
        # A simulator that goes many times as fast as real time is far by when it has been found.
        is_heard = self._publisher.get_subscription_count() > 0
        if is_heard and is_time and self._walked >= self._parts[given] * plan.length:
            self._publisher.publish(push_message(self._forces[given], 'base_link'))
            self.times.append(observer.time)

    @property
    def counted(self) -> int:
        """Number of pushes that the simulator has counted, as last received."""
        if self._observer is None:
            return 0
        return int(self._observer.statuses.get('sim_node', (b'', '', {}))[2].get('pushes', 0))

    def await_count(self, _: WalkRecord, listen: Callable[[], None]) -> None:
        """Let the simulator tell of all of them, once a walk has ended, with what goes on."""
        deadline = time.monotonic() + _COUNTING
        while self.counted < len(self.times) and time.monotonic() < deadline:
            listen()


def pushed_walks(
    console: Console, levels: dict[str, float], count: int, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk to goals with pushes, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    levels : dict of str to float
        Impulse of each push over m sqrt(g h), by robot.
    count : int
        Number of walks of each robot, by turns on each map.
    seed : int
        Of goals and pushes.

    Returns
    -------
    tuple
        The bars, and every walk.
    """
    walks: list[PushedWalk] = []
    bars: list[Criterion] = []
    for robot, level in levels.items():
        made = _walks_of(console, robot, level, count, seed)
        off = [walk.result.position_error or 0.0 for walk in made if walk.result.arrived]
        turned = [walk.result.heading_error or 0.0 for walk in made if walk.result.arrived]
        name = f'{robot}: walks over topics with {_PUSHES} pushes of {level:.3g} m sqrt(g h)'
        bars += [
            at_least(f'{name} that end well, of {count}', sum(w.is_good for w in made), '', count),
            at_most(f'{robot}: falls', sum(w.has_fallen for w in made), '', 0),
            figure(f'{robot}: largest distance from a goal', max(off, default=math.nan), 'm'),
            figure(f'{robot}: largest error of a heading', max(turned, default=math.nan), 'deg'),
        ]
        walks += made
    return bars, {'walks': [asdict(one) for one in walks]}


def _walks_of(
    console: Console, robot: str, level: float, count: int, seed: int
) -> list[PushedWalk]:
    """Walk by turns on each map, each time from the last goal, with each way to turn."""
    rng = np.random.default_rng(seed)
    data = load_robot(robot)
    files = {name: sample_map(name) for name in _STARTS}
    drawers = {name: GoalDrawer(data, file, seed) for name, file in files.items()}
    places = dict(_STARTS)
    made: list[PushedWalk] = []
    for number, (turning, name) in zip(range(count), cycle(product(_TURNINGS, _STARTS))):
        goal = drawers[name].draw(places[name], _SHORTEST, _LONGEST)
        options = WalkOptions(
            map_file=files[name],
            start=places[name],
            goal=goal,
            robot=robot,
            gait='trot',
            turning=turning,
            balance=True,
            backend=resolved(AUTO),
            seed=seed + number,
        )
        pushes = Pushes(data, level, rng)
        record = walk(options, pushes, on_end=pushes.await_count)
        began = record.times[0] if record.times else 0.0
        one = PushedWalk(
            robot, name, turning, places[name], goal, pushes.counted,
            tuple(at - began for at in pushes.times), record.result(),
        )  # fmt: skip
        made.append(one)
        places[name] = goal
        _say(console, one)
    return made


def _say(console: Console, one: PushedWalk) -> None:
    result = one.result
    end = 'arrived' if result.arrived else f'did NOT arrive: {result.problem}'
    off = math.nan if result.position_error is None else 1e3 * result.position_error
    turned = math.nan if result.heading_error is None else result.heading_error
    console.print(
        f'{one.robot} {one.map_name} {one.turning}: {end}, {off:.0f} mm and {turned:.1f} deg off, '
        f'pushed after {", ".join(f"{at:.1f}" for at in one.push_times)} of '
        f'{result.walking_time or 0.0:.1f} s, {result.late_trajectories} late',
        highlight=False,
    )
