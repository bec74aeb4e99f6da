"""
Attack by kills: nodes are killed, or stopped for five seconds, at random moments of walks.
"""

from __future__ import annotations

import os
import signal
from dataclasses import asdict, dataclass, field, replace

import numpy as np
from rich.console import Console

from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.attacks.stage.findings import Findings
from quad_lab.attacks.stage.reasons import reason_for_standing
from quad_lab.attacks.stage.scenes import MAP, NODES, ROBOT, START, AttackScene
from quad_lab.attacks.stage.stage import NotSeen, Stage
from quad_lab.attacks.stage.violations import (
    NOT_FINITE,
    OUTSIDE_LIMITS,
    UNREADABLE,
    violation_bars,
)
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most
from quad_lab.topic_walk.node_processes import NodeDied
from quad_sim.engines.registry import AUTO

WAYS = ('SIGKILL', 'SIGSTOP')

_STOPPED_FOR = 5.0
"""A node that is stopped [s], on the wall clock."""

_RESPAWN = 1.0
"""After which a node that was killed is started again, as ``respawn_delay`` does [s]."""

_PATIENCE = 20.0
"""Time for the robot to go on by itself, or to say why it does not [s], simulated."""

_BEGINNING = 60.0
"""For a robot that was given a goal to begin [s], simulated."""

_ATTEMPTS = 3
"""Times that the goal is given until it does."""

_SCENE = AttackScene(AUTO, ('walking',), NODES, has_nonsense=False, rate=3.0)

# A trot is soon at its goal.
_QUICK_SCENE = replace(_SCENE, setup='kinematic', gait='trot', rate=2.0)


@dataclass(frozen=True)
class KillPlan:
    """Which nodes are killed or stopped, and when."""

    walks: int
    """Number of walks."""
    lengths: tuple[float, float]
    """Shortest and longest path to a goal [m]."""
    latest: float
    """Latest moment of a kill after a walk's beginning [s], simulated."""

    def drawn_ways(self, rng: np.random.Generator) -> list[tuple[str, str]]:
        """Draw node and signal of each walk: every pair as often, both signals by turns."""
        orders = [rng.permutation(NODES) for _ in WAYS]
        pairs = [(str(node), way) for nodes in zip(*orders) for node, way in zip(nodes, WAYS)]
        return [pairs[number % len(pairs)] for number in range(self.walks)]


FULL = KillPlan(walks=40, lengths=(0.4, 1.2), latest=12.0)

# Of a robot that trots.
QUICK = KillPlan(walks=2, lengths=(1.0, 2.0), latest=2.0)


@dataclass
class KilledWalk:
    """What became of one walk."""

    number: int
    node: str
    way: str
    """SIGKILL, or SIGSTOP and SIGCONT after five seconds."""
    moment: float = 0.0
    """Of the kill, after the goal was given [s], simulated."""
    goals: int = 1
    """How often the goal had to be given."""
    has_arrived: bool = False
    has_fallen: bool = False
    contacts: str = ''
    has_stood: bool = False
    """Whether the robot did not go on by itself."""
    reason: str = ''
    """Reason that the gait node gave for it; empty if it gave none."""
    said: str = ''
    """All that the nodes said then."""
    without_effect: list[str] = field(default_factory=list)
    """Goals at the beginning that had no effect: what the nodes said then."""
    problem: str = ''
    """Why it did not arrive."""

    @property
    def is_good(self) -> bool:
        """Whether all that is promised came true."""
        is_safe = not self.has_fallen and not self.contacts
        is_received = self.goals <= 2 and not self.without_effect
        return is_safe and self.has_arrived and is_received and self.says_why

    @property
    def says_why(self) -> bool:
        """Whether the robot went on, or said why it did not."""
        return not self.has_stood or bool(self.reason)


def attack_by_kills(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Kill nodes in walks, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A few walks only.
    seed : int
        Of goals and moments.

    Returns
    -------
    tuple
        The bars, and details for JSON: every walk.
    """
    scene, plan = (_QUICK_SCENE, QUICK) if quick else (_SCENE, FULL)
    with scene.running() as stage:
        return kill_in_walks(console, stage, plan, seed)


def kill_in_walks(
    console: Console, stage: Stage, plan: KillPlan, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Kill nodes that run on a stage; otherwise as `attack_by_kills`."""
    rng = np.random.default_rng(seed)
    before = Findings.of(stage)
    goals = GoalDrawer(load_robot(ROBOT), sample_map(MAP), seed)
    walks = []
    for number, (node, way) in enumerate(plan.drawn_ways(rng)):
        walk = KilledWalk(number, node, way, float(rng.uniform(0.0, plan.latest)))
        _killed_walk(stage, walk, plan, goals)
        walks.append(walk)
        _say(console, walk)
        if not walk.is_good:
            _begin_again(stage)
    seen = Findings.of(stage).since(before)
    return bars_of(walks, seen.counts, len(seen.tracebacks)), {
        'walks': [asdict(walk) for walk in walks],
        'tracebacks': seen.tracebacks,
        'violations': seen.examples,
    }


def _killed_walk(stage: Stage, walk: KilledWalk, plan: KillPlan, goals: GoalDrawer) -> None:
    """Walk to a goal; kill a node on the way."""
    goal = goals.draw(stage.pose or START, *plan.lengths)
    try:
        _begin(stage, walk, goal)
        begun = stage.listener.time
        stage.wait_until(
            'the moment of the kill',
            lambda: stage.listener.time >= begun + walk.moment or stage.is_at(goal),
        )
        _kill(stage, walk)
        if not _goes_on(stage, goal):
            # It has to say why; a new goal has to be enough.
            walk.has_stood, walk.said = True, stage.all_said()
            status = stage.listener.statuses.get('gait_node', (b'', '', {}))
            walk.reason = reason_for_standing(*status)
            walk.goals += 1
            stage.give_goal(goal)
        stage.wait_until(f'arrival at {goal}', lambda: stage.is_at(goal), 300.0)
        walk.has_arrived = True
    except (NotSeen, NodeDied) as error:
        walk.problem = str(error)
    walk.has_fallen, walk.contacts = stage.has_fallen, stage.contacts


def _begin(stage: Stage, walk: KilledWalk, goal: Pose2D) -> None:
    """Give a goal until the robot walks; note every one that has no effect."""
    for attempt in range(1, _ATTEMPTS + 1):
        stage.give_goal(goal)
        try:
            stage.wait_until('the robot walks', stage.is_moving, _BEGINNING)
        except NotSeen:
            # An answer, and no effect: the topic is lost, and the node is not.
            ping = stage.ping('planner_node')
            walk.without_effect.append(f'{stage.all_said()}; asked, planner_node: {ping}')
            if attempt == _ATTEMPTS:
                raise
        else:
            return


def _kill(stage: Stage, walk: KilledWalk) -> None:
    process = stage.nodes[walk.node]
    if walk.way == 'SIGKILL':
        process.kill()
        stage.spin(_RESPAWN)
        stage.start_again(walk.node)
        stage.wait_until_found()
    else:
        os.kill(process.pid, signal.SIGSTOP)
        try:
            stage.spin(_STOPPED_FOR)
        finally:
            os.kill(process.pid, signal.SIGCONT)


def _goes_on(stage: Stage, goal: Pose2D) -> bool:
    """Return whether the robot reaches the goal by itself; if not, it has stood for a while."""
    moved_at = seen = stage.listener.time

    def is_over() -> bool:
        nonlocal moved_at, seen
        now = stage.listener.time
        # A simulator that is started again begins at zero.
        if now < seen or stage.is_moving() or stage.activity == 'standing up':
            moved_at = now
        seen = now
        return stage.is_at(goal) or now - moved_at > _PATIENCE

    stage.wait_until(f'arrival at {goal}, or a robot that stands', is_over, 300.0)
    return stage.is_at(goal)


def _begin_again(stage: Stage) -> None:
    """Start all nodes again: a walk that went wrong must not spoil the next one."""
    for name in NODES:
        stage.nodes[name].kill()
    for name in NODES:
        stage.start_again(name)
    stage.wait_until_ready()


def bars_of(walks: list[KilledWalk], counts: dict[str, int], tracebacks: int) -> list[Criterion]:
    """
    Work out the bars of some walks.

    Parameters
    ----------
    walks : list of KilledWalk
        What became of each.
    counts : dict of str to int
        How often each kind of violation was seen; see :mod:`quad_lab.attacks.stage.violations`.
    tracebacks : int
        How many are in the nodes' logs.

    Returns
    -------
    list of Criterion
        What must hold.
    """
    total = len(walks)
    good = sum(walk.is_good for walk in walks)
    without_effect = sum(len(walk.without_effect) for walk in walks)
    return [
        at_least('walks that end well', good if total else None, f'of {total}', total),
        at_most('falls', sum(walk.has_fallen for walk in walks), '', 0),
        at_most('walks with contacts', sum(bool(walk.contacts) for walk in walks), '', 0),
        at_most('goals given, at most', max((walk.goals for walk in walks), default=None), '', 2),
        at_most('goals at the beginning without effect', without_effect, '', 0),
        at_most(
            'robots that stand and do not say why',
            sum(not walk.says_why for walk in walks),
            '',
            0,
        ),
        *violation_bars(counts, (NOT_FINITE, OUTSIDE_LIMITS, UNREADABLE)),
        at_most('tracebacks', tracebacks, '', 0),
    ]


def _say(console: Console, walk: KilledWalk) -> None:
    outcome = 'arrived' if walk.has_arrived else f'did NOT arrive: {walk.problem}'
    extra = f', {walk.goals} goals' if walk.goals > 1 else ''
    extra += f', stood: {walk.reason or "did NOT say why"}' if walk.has_stood else ''
    extra += f', {len(walk.without_effect)} goals WITHOUT EFFECT' if walk.without_effect else ''
    extra += ', FELL' if walk.has_fallen else ''
    extra += f', CONTACTS {walk.contacts}' if walk.contacts else ''
    console.print(
        f'{walk.number + 1} {walk.way} of {walk.node} after {walk.moment:.1f} s: {outcome}{extra}',
        highlight=False,
    )
    for said in walk.without_effect:
        console.print(f'   without effect: {said}', highlight=False)
