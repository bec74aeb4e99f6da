"""
``quadwalk bench matrix``: every robot, gait, turning and planning method together, over topics.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Iterable
from dataclasses import asdict, dataclass, field

import numpy as np
from rich.console import Console

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.attacks.stage.stage import NotSeen, Stage
from quad_lab.attacks.stage.violations import JOINTS_OUTSIDE, NOT_FINITE, OUTSIDE_LIMITS, UNREADABLE
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.node_processes import NodeDied, isolated_domain
from quad_planner.parameters import PLANNING_METHODS

ROBOTS = ('titan_viii', 'pukyong', 'cuhk', 'genibo')
GAITS = ('crawl', 'wave', 'trot', 'walk')
TURNINGS = ('in_place', 'crab', 'arc')
METHODS = PLANNING_METHODS

PARTS = (*ROBOTS, *GAITS, *TURNINGS, *METHODS)
"""Values that ``--only`` takes; a quantity of which none is named has all of its values."""

GOALS = 2
"""In each combination."""

QUICK_BUDGET = 25.0
"""The quick sample begins no further combination after so long [s]."""

_SHORTEST, _LONGEST = 0.4, 1.2
"""Plans [m]."""

_QUICK_LONGEST = 0.6

_RATE = 5.0
"""Simulated over real time, at most.

As fast as possible, a second in which the machine does something else is ten of the robot's, in
which no node receives anything: the nodes rightly say so.
"""

_TIMEOUT = 600.0
"""For a goal to be reached [s], simulated."""

_KINDS = (NOT_FINITE, OUTSIDE_LIMITS, JOINTS_OUTSIDE, UNREADABLE)

_SHOWN = 3
"""Violations of a combination that are told of while the others walk."""

_MAP = 'room'
_START = Pose2D(1.2, 1.2, 0.0)


@dataclass(frozen=True)
class Combination:
    """What walks, and how."""

    robot: str
    gait: str
    turning: str
    method: str

    def __str__(self) -> str:
        return f'{self.robot} {self.gait} {self.turning} {self.method}'


@dataclass
class Outcome:
    """What became of a combination's walks."""

    combination: Combination
    reached: int = 0
    """Goals."""
    contacts: str = ''
    has_fallen: bool = False
    alarms: list[str] = field(default_factory=list)
    """What the nodes said to be wrong, though nothing was."""
    violations: dict[str, int] = field(default_factory=dict)
    """Number of each kind: see :mod:`quad_lab.attacks.stage.violations`."""
    examples: list[str] = field(default_factory=list)
    """Violations of these kinds in words, the first ones."""
    late_trajectories: int = 0
    problem: str = ''
    """Why a goal was not reached."""
    simulated: float = 0.0
    """[s]"""
    wall_time: float = 0.0
    """[s]"""

    @property
    def is_good(self) -> bool:
        """Whether all went as it should."""
        is_sound = not self.contacts and not self.has_fallen and not self.alarms
        return is_sound and self.reached == GOALS and not self.violations


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = ()
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk every combination, and work out the bars.

    Parameters
    ----------
    console : Console
        Where a line for each combination goes.
    quick : bool
        A few combinations, drawn at random, over short distances.
    seed : int
        Of goals and of the sample.
    only : tuple of str
        Robots, gaits, turnings and methods to which it is limited.

    Returns
    -------
    tuple
        The bars, and details for JSON: every combination.
    """
    chosen = combinations(only)
    if quick:
        chosen = [chosen[i] for i in np.random.default_rng(seed).permutation(len(chosen))]
    began = time.monotonic()
    outcomes: list[Outcome] = []
    for number, combination in enumerate(chosen, 1):
        outcome = walk_combination(combination, seed, _QUICK_LONGEST if quick else _LONGEST)
        outcomes.append(outcome)
        _say(console, number, len(chosen), outcome)
        if quick and time.monotonic() - began > QUICK_BUDGET:
            break
    details: dict[str, object] = {
        'quick': quick,
        'seed': seed,
        'combinations': [asdict(outcome) for outcome in outcomes],
    }
    return bars_of(outcomes), details


def combinations(only: Iterable[str] = ()) -> list[Combination]:
    """List the combinations whose values are wanted; all if none are named."""
    wanted = set(only)
    axes = [
        [value for value in axis if value in wanted] or list(axis)
        for axis in (ROBOTS, GAITS, TURNINGS, METHODS)
    ]
    return [Combination(*values) for values in itertools.product(*axes)]


def walk_combination(combination: Combination, seed: int, longest: float = _LONGEST) -> Outcome:
    """Start the nodes once, and walk to the goals."""
    outcome = Outcome(combination)
    robot = load_robot(combination.robot)
    goals = GoalDrawer(robot, sample_map(_MAP), seed)
    began = time.monotonic()
    with isolated_domain(), Stage(robot) as stage:
        try:
            _start(stage, combination, seed)
            stage.listener.alarms.clear()
            for _ in range(GOALS):
                stage.walk_to(goals.draw(stage.pose or _START, _SHORTEST, longest), _TIMEOUT)
                outcome.reached += 1
        except (NotSeen, NodeDied) as error:
            outcome.problem = str(error)
        listener = stage.listener
        outcome.contacts, outcome.has_fallen = stage.contacts, stage.has_fallen
        outcome.alarms = sorted(set(itertools.chain.from_iterable(listener.alarms.values())))
        outcome.violations = {k: n for k, n in listener.counts.items() if k in _KINDS}
        outcome.examples = [text for kind in _KINDS for text in listener.examples.get(kind, [])]
        late = listener.statuses.get('sim_node', (b'', '', {}))[2].get('late_trajectories', '0')
        outcome.late_trajectories = int(late)
        outcome.simulated = listener.time
    outcome.wall_time = time.monotonic() - began
    return outcome


def _start(stage: Stage, combination: Combination, seed: int) -> None:
    robot = combination.robot
    start = [_START.x, _START.y, _START.yaw]
    stage.start('sim_node', robot=robot, start_pose=start, real_time_factor=_RATE, seed=seed)
    stage.start(
        'planner_node',
        robot=robot,
        method=combination.method,
        gait=combination.gait,
        any_angle=True,
    )
    stage.start('gait_node', robot=robot, gait=combination.gait, turning=combination.turning)
    stage.wait_until_ready()


def bars_of(outcomes: list[Outcome]) -> list[Criterion]:
    """Work out the bars of some combinations."""
    total = len(outcomes)
    simulated = sum(outcome.simulated for outcome in outcomes)
    wall = sum(outcome.wall_time for outcome in outcomes)
    reached = sum(outcome.reached for outcome in outcomes)
    return [
        at_least('goals reached', reached if total else None, f'of {GOALS * total}', GOALS * total),
        at_most('combinations with contacts', sum(bool(o.contacts) for o in outcomes), '', 0),
        at_most('falls', sum(o.has_fallen for o in outcomes), '', 0),
        at_most('combinations with false alarms', sum(bool(o.alarms) for o in outcomes), '', 0),
        *(
            at_most(kind, sum(o.violations.get(kind, 0) for o in outcomes), '', 0)
            for kind in _KINDS
        ),
        figure('trajectories that came late', sum(o.late_trajectories for o in outcomes), ''),
        figure('combinations', total, f'of {len(combinations())}'),
        figure('speed', simulated / wall if wall > 0.0 else None, 'x real time, starts included'),
    ]


def _say(console: Console, number: int, count: int, outcome: Outcome) -> None:
    trouble = [
        f'NOT reached: {outcome.problem}' if outcome.problem else '',
        f'CONTACTS: {outcome.contacts}' if outcome.contacts else '',
        'FELL' if outcome.has_fallen else '',
        f'ALARMS: {" | ".join(outcome.alarms)}' if outcome.alarms else '',
        str(outcome.violations) if outcome.violations else '',
        ' | '.join(outcome.examples[:_SHOWN]),
    ]
    console.print(
        f'{number}/{count} {outcome.combination}: {outcome.reached} of {GOALS} goals, '
        f'{outcome.simulated:.0f} s simulated, {outcome.wall_time:.0f} s, '
        f'{outcome.late_trajectories} late. {"; ".join(t for t in trouble if t)}',
        highlight=False,
    )
