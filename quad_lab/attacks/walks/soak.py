"""
A soak: hours of simulated time, one random goal after the other, over topics.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass

from rich.console import Console

from quad_common.resources import sample_map
from quad_common.robot_files.robot_file import load_robot
from quad_lab.attacks.stage.findings import Findings
from quad_lab.attacks.stage.scenes import MAP, QUICK_WALK, ROBOT, START, start_nodes
from quad_lab.attacks.stage.stage import NotSeen, Stage
from quad_lab.attacks.stage.state import growth
from quad_lab.attacks.stage.violations import violation_bars
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.node_processes import NodeDied, isolated_domain


@dataclass(frozen=True)
class SoakPlan:
    """How long a robot walks, and how far at a time."""

    duration: float
    """Simulated time [s]."""
    warm_up: float
    """Simulated time from which on memory is compared [s]."""
    lengths: tuple[float, float]
    """Shortest and longest path to a goal [m]."""
    largest_turn: float
    """Largest turn to a goal, and on it [rad]."""
    largest_growth: float | None
    """Memory that a node may gain after the warm-up, as a fraction; None if it is only measured."""


FULL = SoakPlan(
    6.0 * 3600.0, warm_up=600.0, lengths=(0.3, 5.0), largest_turn=math.pi, largest_growth=0.02
)

# Nodes that have just begun still load what they need.
QUICK = SoakPlan(8.0, warm_up=0.0, lengths=(0.2, 0.4), largest_turn=0.1, largest_growth=None)

_LINE_EVERY = 30.0
"""A line of progress [s], on the wall clock."""

_FEWEST = 2
"""Goals, or there would be nothing to compare."""

_MOST_MISSED = 10
"""After so many goals that were not reached the soak is given up."""


def soak(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk for hours, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        Seconds in place of hours.
    seed : int
        Of the goals.

    Returns
    -------
    tuple
        The bars, and details for JSON: memory over time, and goals that were not reached.
    """
    with isolated_domain(), Stage(load_robot(ROBOT)) as stage:
        if quick:
            QUICK_WALK.start(stage)
        else:
            # As fast as possible, a message is on its way for a good part of a simulated second.
            start_nodes(stage, 'kinematic', rate=0.0, lead_time=2.0)
        return walk_for_long(console, stage, QUICK if quick else FULL, seed)


def walk_for_long(
    console: Console, stage: Stage, plan: SoakPlan, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Walk with nodes that run on a stage; otherwise as `soak`."""
    goals = GoalDrawer(load_robot(ROBOT), sample_map(MAP), seed)
    reached, missed = 0, list[str]()
    memory: list[tuple[float, dict[str, float]]] = []
    said_at, before, began = time.monotonic(), Findings.of(stage), stage.listener.time
    simulated = 0.0
    while (simulated < plan.duration or reached < _FEWEST) and len(missed) < _MOST_MISSED:
        goal = goals.draw(stage.pose or START, *plan.lengths, plan.largest_turn)
        try:
            stage.walk_to(goal, 900.0)
            reached += 1
        except (NotSeen, NodeDied) as error:
            missed.append(str(error))
            if isinstance(error, NodeDied):
                break
        simulated = stage.listener.time - began
        memory.append((simulated, stage.memory()))
        if time.monotonic() - said_at > _LINE_EVERY:
            said_at = time.monotonic()
            line = f'{simulated / 3600.0:.2f} h simulated, {reached} goals, {memory[-1][1]}'
            console.print(line, highlight=False)
    seen = Findings.of(stage).since(before)
    grown = growth_since(memory, plan.warm_up)
    what, largest = 'largest growth of memory', max(grown.values(), default=None)
    bars = [
        figure('simulated', simulated / 3600.0, 'h'),
        *bars_of(reached, len(missed), seen.counts, len(seen.tracebacks)),
        figure(what, largest, 'fraction') if plan.largest_growth is None
        else at_most(what, largest, 'fraction', plan.largest_growth),
    ]  # fmt: skip
    return bars, {
        'growth': grown,
        'memory': memory,
        'missed': missed,
        'violations': seen.examples,
        'tracebacks': seen.tracebacks,
    }


def bars_of(reached: int, missed: int, counts: dict[str, int], tracebacks: int) -> list[Criterion]:
    """
    Work out the bars of a soak, but for its memory.

    Parameters
    ----------
    reached, missed : int
        Goals.
    counts : dict of str to int
        How often each kind of violation was seen; see :mod:`quad_lab.attacks.stage.violations`.
    tracebacks : int
        How many are in the nodes' logs.

    Returns
    -------
    list of Criterion
        What must hold.
    """
    total = reached + missed
    return [
        at_least('goals reached', reached if total else None, f'of {total}', total),
        *violation_bars(counts),
        at_most('tracebacks', tracebacks, '', 0),
    ]


def growth_since(memory: list[tuple[float, dict[str, float]]], since: float) -> dict[str, float]:
    """
    Work out by how much each node has grown.

    Parameters
    ----------
    memory : list of (float, dict)
        Simulated time [s] and what each node held then [MB], in the order of time.
    since : float
        What was held before that time is left out [s].

    Returns
    -------
    dict of str to float
        From the first to the last of the rest, as a fraction; empty if these are not two.
    """
    warm = [held for time, held in memory if time >= since]
    return growth(warm[0], warm[-1]) if len(warm) > 1 else {}
