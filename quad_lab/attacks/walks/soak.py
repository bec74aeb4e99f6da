"""
A soak: hours of simulated time, one random goal after the other, over topics.
"""

from __future__ import annotations

import time

from rich.console import Console

from quad_common.resources import sample_map
from quad_common.robot.robot_file import load_robot
from quad_lab.attacks.stage.scenes import MAP, ROBOT, START, start_nodes
from quad_lab.attacks.stage.stage import NotSeen, Stage
from quad_lab.attacks.stage.state import growth
from quad_lab.attacks.stage.violations import violation_bars
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.node_processes import NodeDied, isolated_domain

DURATION = 6.0 * 3600.0
"""[s], simulated."""

QUICK_DURATION = 8.0
"""Likewise."""

_WARM_UP = 600.0
"""Memory is compared with what it was then [s], simulated."""

_LINE_EVERY = 30.0
"""A line of progress [s], on the wall clock."""

LARGEST_GROWTH = 0.02
"""Memory that a node may gain after the warm-up, as a fraction."""

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
    duration = QUICK_DURATION if quick else DURATION
    goals = GoalDrawer(load_robot(ROBOT), sample_map(MAP), seed)
    reached, missed = 0, list[str]()
    memory: list[tuple[float, dict[str, float]]] = []
    said_at = time.monotonic()
    with isolated_domain(), Stage(load_robot(ROBOT)) as stage:
        # As fast as possible, a message is on its way for a good part of a simulated second.
        start_nodes(stage, 'kinematic', rate=0.0, lead_time=2.0)
        while (stage.listener.time < duration or reached < _FEWEST) and len(missed) < _MOST_MISSED:
            goal = goals.draw(stage.pose or START, 0.3, 0.6 if quick else 5.0)
            try:
                stage.walk_to(goal, 900.0)
                reached += 1
            except (NotSeen, NodeDied) as error:
                missed.append(str(error))
                if isinstance(error, NodeDied):
                    break
            memory.append((stage.listener.time, stage.memory()))
            if time.monotonic() - said_at > _LINE_EVERY:
                said_at = time.monotonic()
                hours = stage.listener.time / 3600.0
                line = f'{hours:.2f} h simulated, {reached} goals, {memory[-1][1]}'
                console.print(line, highlight=False)
        simulated = stage.listener.time
        counts, examples = dict(stage.listener.counts), dict(stage.listener.examples)
        tracebacks = stage.tracebacks()
    # Nodes that have just begun still load what they need.
    grown = growth_since(memory, 0.0 if quick else _WARM_UP)
    what, largest = 'largest growth of memory', max(grown.values(), default=None)
    bars = [
        figure('simulated', simulated / 3600.0, 'h'),
        *bars_of(reached, len(missed), counts, len(tracebacks)),
        figure(what, largest, 'fraction') if quick
        else at_most(what, largest, 'fraction', LARGEST_GROWTH),
    ]  # fmt: skip
    return bars, {
        'growth': grown,
        'memory': memory,
        'missed': missed,
        'violations': examples,
        'tracebacks': tracebacks,
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
