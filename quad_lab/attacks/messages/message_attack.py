"""
Attack by messages: every topic and service of every node, the robot standing and walking.
"""

from __future__ import annotations

import contextlib
import itertools
import math
from dataclasses import asdict, dataclass, field

import numpy as np
from nav_msgs.msg import OccupancyGrid
from rclpy.qos import DurabilityPolicy, QoSProfile
from rich.console import Console
from std_srvs.srv import SetBool, Trigger
from visualization_msgs.msg import Marker, MarkerArray

from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.attacks.messages.attacker import Attacker
from quad_lab.attacks.messages.nonsense import accepted_nonsense
from quad_lab.attacks.stage.findings import Findings
from quad_lab.attacks.stage.report import Report, bars_of
from quad_lab.attacks.stage.scenes import (
    MAP,
    QUICK_SCENES,
    ROBOT,
    SCENES,
    START,
    AttackScene,
)
from quad_lab.attacks.stage.stage import NotSeen, Stage
from quad_lab.attacks.stage.state import growth
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion
from quad_lab.topic_walk.node_processes import NodeDied

_BATCH = 20
"""Messages between two looks whether all is well."""

_WARM_UP = 0.5
"""Fraction of the messages after which memory is measured again: the first giant messages enlarge
heaps once, and what goes on growing does so afterwards as well."""

_GAP = 0.004
"""Between two messages [s]."""

_BETWEEN = 0.1
"""Time between two moments at which memory is measured [s]."""

_SET_OUT = 2.0
"""Time in which a robot that was given a goal is to set out [s]."""

_LONGEST_LINE = 1000
"""Number of letters of a finding that are printed."""

_LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)


@dataclass(frozen=True)
class Effort:
    """Size of an attack."""

    messages: int
    """Number of messages to each node, with the robot standing, and as many with it walking."""
    nonsense: int | None
    """Number of messages that must be refused, to each node; None for all."""
    longest: float
    """Longest path to the good goal after an attack [m]."""
    largest_turn: float
    """Largest turn to that goal, and on it [rad]."""
    moments: int
    """Number of moments at which memory is measured."""
    giants: int
    """Number of times that every message is far too long, in every field, before memory counts."""
    calming: float
    """Time in which a node gets back to its usual work before it is measured [s]."""


FULL = Effort(2000, None, longest=1.0, largest_turn=math.pi, moments=10, giants=2, calming=2.0)
QUICK = Effort(20, 5, longest=0.2, largest_turn=0.1, moments=2, giants=0, calming=0.4)


@dataclass
class MessageOutcome:
    """What came of attacks by messages."""

    reports: list[Report] = field(default_factory=list)
    findings: Findings = field(default_factory=Findings)

    def add(self, others: MessageOutcome) -> None:
        """Take in what came of other attacks."""
        self.reports += others.reports
        self.findings.add(others.findings)

    def result(self, quick: bool) -> tuple[list[Criterion], dict[str, object]]:
        """Work out the bars, and details for JSON."""
        seen = self.findings
        return bars_of(self.reports, seen.counts, seen.tracebacks, quick), {
            'attacks': [asdict(report) for report in self.reports],
            'violations': seen.examples,
            'tracebacks': seen.tracebacks,
        }


def attack_messages(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Attack, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A small part of the messages.
    seed : int
        Of what is sent.

    Returns
    -------
    tuple
        The bars, and details for JSON.
    """
    outcome = MessageOutcome()
    for scene in QUICK_SCENES if quick else SCENES:
        with scene.running() as stage:
            effort = QUICK if quick else FULL
            outcome.add(attack_scene(console, stage, scene, effort, seed))
    return outcome.result(quick)


def attack_scene(
    console: Console, stage: Stage, scene: AttackScene, effort: Effort, seed: int
) -> MessageOutcome:
    """
    Attack the nodes of a scene, one after the other.

    Parameters
    ----------
    console : Console
        Where progress goes.
    stage : Stage
        Where the scene's nodes run.
    scene : AttackScene
        Which nodes are attacked, and in which states of the robot.
    effort : Effort
        Size of each attack.
    seed : int
        Of what is sent.

    Returns
    -------
    MessageOutcome
        What came of it.
    """
    before = said = Findings.of(stage)
    reports = []
    for state, node in itertools.product(scene.states, scene.targets):
        attack = MessageAttack(stage, Report(node, state), seed, scene.clearance, effort)
        if scene.has_nonsense and state == scene.states[0]:
            attack.try_nonsense(effort.nonsense)
        attack.run(effort.messages)
        attack.walk_on()
        reports.append(attack.report)
        now = Findings.of(stage)
        _say(console, attack.report, stage, now.since(said).examples)
        said = now
    return MessageOutcome(reports, Findings.of(stage).since(before))


class MessageAttack:
    """
    The attack on one node: sends, looks after the robot, measures.

    Parameters
    ----------
    stage : Stage
        Where it runs.
    report : Report
        Report that is filled in.
    seed : int
        Of goals and messages.
    clearance : float
        Distance that goals keep beyond the planner's own [m].
    effort : Effort
        Size of the attack.
    """

    def __init__(
        self,
        stage: Stage,
        report: Report,
        seed: int,
        clearance: float = 0.0,
        effort: Effort = FULL,
    ) -> None:
        self.report = report
        self._effort = effort
        self._stage = stage
        self._goals = GoalDrawer(load_robot(ROBOT), sample_map(MAP), seed, clearance=clearance)
        self._rng = np.random.default_rng(seed)
        self._attacker = Attacker(stage, report.node, self._rng)
        self._maps = stage.node.create_publisher(OccupancyGrid, 'map', _LATCHED)
        self._obstacles = stage.node.create_publisher(MarkerArray, 'obstacles', 10)
        self._robots = stage.node.create_publisher(MarkerArray, '/fleet/robots', 10)
        # It is latched, but may come after all that says that the nodes are ready.
        stage.wait_until('a map', lambda: '/map' in stage.listener.last)
        self._good_map = stage.listener.last['/map']
        self._memory: list[dict[str, float]] = []
        """Of each node after the warm-up, at one look after the other [MB]."""

    def try_nonsense(self, count: int | None) -> None:
        """Send what must be refused."""
        report = self.report
        report.nonsense, report.accepted = accepted_nonsense(
            self._stage, self._attacker, self._rng, count
        )
        self._look()

    def run(self, count: int) -> None:
        """Send so many messages; then take back what is latched, and what was changed."""
        before = self._held()
        while self.report.messages < count:
            self._keep_going()
            for _ in range(_BATCH):
                self._attacker.shoot()
                self.report.messages += 1
                self._stage.spin(_GAP)
            self._look()
            if not self._memory and self.report.messages >= _WARM_UP * count:
                self._send_giants()
                self._memory = [self._held_in_calm()]
                self.report.first_growth = growth(before, self._memory[0])
            elif self._memory:
                self._memory.append(self._stage.memory())
        self.report.slow += self._attacker.slow
        self._attacker.restore_parameters()
        self._attacker.close()
        self._release()

    def _send_giants(self) -> None:
        """Let every buffer grow to the largest message that it will hold; load what is needed."""
        for _ in range(self._effort.giants):
            for number, _ in enumerate(self._attacker.send_giants(), 1):
                self._stage.spin(_GAP)
                self.report.giants += 1
                if not number % _BATCH:
                    self._look()
                    self._release()
            self._look()
        if self._effort.giants:
            self._attacker.load_all()

    def walk_on(self) -> None:
        """Give a good goal, see whether it is reached, and compare the memory with before."""
        self._walk_to_goal()
        self._memory.append(self._held())
        middle = len(self._memory) // 2
        self.report.memory_growth = growth(
            _least(self._memory[:middle]), _least(self._memory[middle:])
        )
        self._stage.listener.context = ''
        for publisher in (self._maps, self._obstacles, self._robots):
            self._stage.node.destroy_publisher(publisher)

    def _held_in_calm(self) -> dict[str, float]:
        """Return the same as `_held`, of nodes that do their usual work again."""
        self._attacker.restore_parameters()
        self._release()
        self._stage.spin(self._effort.calming)
        return self._held()

    def _held(self) -> dict[str, float]:
        """
        Return how much memory each node holds for good [MB].

        It is the least of some moments: what works on a picture has it several times over.
        """
        held = self._stage.memory()
        for _ in range(self._effort.moments):
            self._stage.spin(_BETWEEN)
            now = self._stage.memory()
            held = {name: min(held[name], now[name]) for name in held if name in now}
        return held

    def _look(self) -> None:
        """See whether all nodes live, and answer soon."""
        stage, report = self._stage, self.report
        self._revive()
        for name in stage.nodes:
            reaction = stage.ping(name)
            if reaction.is_hang and name not in stage.dead_nodes():
                sent = ' | '.join(self._attacker.recent)
                report.slow.append(f'{name}: {reaction}; sent last: {sent}')

    def _revive(self) -> None:
        """Start nodes again that have ended: the attack goes on, and their deaths count."""
        stage = self._stage
        while dead := stage.dead_nodes():
            # What is latched would end them again.
            self._attacker.renew_latched()
            for name, death in dead.items():
                sent = ' | '.join(self._attacker.recent)
                self.report.deaths.append(f'{death}\nsent last: {sent}')
                self._memory = [{n: held[n] for n in held if n != name} for held in self._memory]
                stage.start_again(name)
            stage.listener.forget_robot()
            # Another one may end meanwhile, of what was sent before.
            with contextlib.suppress(NodeDied):
                stage.wait_until_found()

    def _keep_going(self) -> None:
        """Take back what a stranger may rightly ask for: a pause, a seat, a wall, a robot."""
        stage = self._stage
        self._release()
        if self.report.state == 'walking' and not stage.is_moving():
            stage.give_goal(self._goals.draw(START, 0.3, 1.5))
            # Under attack it may not.
            stage.spin_until(stage.is_moving, _SET_OUT)

    def _release(self) -> None:
        stage = self._stage
        if stage.has_fallen:
            if self.report.node != 'sim_node':
                self.report.falls += 1
            stage.listener.forget_robot()
            stage.call('reset', Trigger)
        stage.call('unpause', Trigger)
        if '/emergency_stop' in dict(stage.node.get_service_names_and_types()):
            stage.call('emergency_stop', SetBool, SetBool.Request(data=False))
        if stage.activity in ('sitting', 'sitting down', 'stopped'):
            stage.call('stand', Trigger)
        self._maps.publish(self._good_map)
        self._obstacles.publish(MarkerArray(markers=[Marker(action=Marker.DELETEALL)]))
        for name in sorted(self._attacker.robots):
            gone = Marker(ns=name, id=0, action=Marker.DELETE)
            self._robots.publish(MarkerArray(markers=[gone]))
            # No faster than its queue is read.
            stage.spin(_GAP)
        self._attacker.robots.clear()

    def _walk_to_goal(self) -> None:
        stage, report = self._stage, self.report
        try:
            self._release()
            if report.node == 'sim_node':
                stage.listener.forget_robot()
                stage.call('reset', Trigger)
            stage.spin(1.0)
            # What was released may only now be said.
            self._release()
            pose = stage.pose
            assert pose is not None
            longest, turn = self._effort.longest, self._effort.largest_turn
            stage.walk_to(self._goals.draw(pose, 0.2 * longest, longest, turn))
            report.has_reached_goal = True
        except (NotSeen, NodeDied) as error:
            report.problem = str(error)
            if isinstance(error, NodeDied):
                report.deaths.append(f'{error}\nafter the attack, on the way to a good goal')


def _least(memory: list[dict[str, float]]) -> dict[str, float]:
    """
    Return the least that each node held at some looks [MB].

    What a giant message was made of leaves gaps in the heap: they fill and empty for a while
    after it, and only what is held at every look is held for good.
    """
    names = set[str]().union(*memory)
    return {name: min(held[name] for held in memory if name in held) for name in names}


def _say(console: Console, report: Report, stage: Stage, seen: dict[str, list[str]]) -> None:
    """Print what came of an attack, and each violation that was seen in it."""
    console.print(
        f'{report.node}, {report.state}: {report.messages} messages, {len(report.deaths)} deaths, '
        f'{len(report.slow)} slow, {len(report.accepted)} of {report.nonsense} accepted, '
        f'{dict(stage.listener.counts)}, '
        f'goal {"reached" if report.has_reached_goal else "NOT reached: " + report.problem}',
        highlight=False,
    )
    grown = ', '.join(f'{name} {g:+.1%}' for name, g in report.memory_growth.items())
    console.print(f'  memory in the second half: {grown}', highlight=False)
    for text in (*report.accepted, *report.deaths, *report.slow, *itertools.chain(*seen.values())):
        console.print(f'  {text[:_LONGEST_LINE]}', highlight=False, markup=False)
