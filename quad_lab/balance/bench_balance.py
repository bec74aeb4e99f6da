"""
``quadwalk bench balance``: pushes that trotting robots survive, and how they trot without.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from dataclasses import asdict
from typing import Any

from rich.console import Console

from quad_lab.balance.balance_case import BalanceCase
from quad_lab.balance.left_alone import (
    silences_at_random,
    stops_along_a_plan,
    turns_on_the_spot,
    unpushed_trots,
    unpushed_walks,
)
from quad_lab.balance.push_levels import own_push_level
from quad_lab.balance.pushed_trots import (
    disturbed_pushes,
    hardest_pushes,
    pushes_of_level,
    survival_curves,
    thrown_balls,
)
from quad_lab.balance.rough_ground import BUMPS, RAMPS, SLOPES, trot_over
from quad_lab.balance.trials import Bars, in_workers
from quad_lab.tools.criterion import Criterion, at_least, figure
from quad_sim.engines.registry import AUTO, resolved

_WALKERS = ('a1', 'genibo', 'cuhk')
"""Robots that trot over slopes and bumps."""

_ON_GROUND, _ON_GROUND_QUICK = 0.6, ('cuhk',)
"""Fraction of the most speed at which they do, and which of them in a hurry."""

_WALKS = 20
"""Walks of each over each ground."""


_LONG = ('levels', 'curves', 'balls')
"""Parts that a quick sample leaves out."""

_OVER_TOPICS = 'goals'
"""Part that needs ROS."""

_WHO_WALKS, _GOALS, _HALF = ('cuhk', 'a1'), 30, 0.5
"""Robots that walk over topics to so many goals each, pushed by this fraction of a level."""


def measure(
    console: Console, quick: bool, seed: int, only: tuple[str, ...] = ()
) -> tuple[list[Criterion], dict[str, Any]]:
    """
    Push robots, disturb them, and let them trot.

    Parameters
    ----------
    console : Console
        Where progress and tables are shown.
    quick : bool
        A few pushes of one robot.
    seed : int
        Seed of the sensors' errors, and of instants.
    only : tuple of str
        Parts to run; all if empty.

    Returns
    -------
    bars : list of Criterion
        What was measured.
    details : dict
        Every case.
    """
    bars: list[Criterion] = []
    details: dict[str, Any] = {'quick': quick, 'seed': seed, 'backend': resolved(AUTO)}
    for name, part in PARTS.items():
        if (only and name not in only) or (quick and not only and name in _LONG):
            continue
        console.rule(name)
        if name == _OVER_TOPICS and name not in only and importlib.util.find_spec('rclpy') is None:
            console.print('left out: it walks over topics, and rclpy is not installed')
            continue
        part_bars, details[name] = part(console, quick, seed)
        bars += part_bars
    return bars, details


def _slopes(console: Console, quick: bool, seed: int) -> Bars:
    """Trot up, down and across slopes, and over their edges, blind and with a height map."""
    grounds = {**dict.fromkeys(SLOPES, 20), **dict.fromkeys(RAMPS, 18)}
    return _over_ground(grounds, quick, seed, known_only=tuple(RAMPS))


def _bumps(console: Console, quick: bool, seed: int) -> Bars:
    """Trot over bumps, blind and with a height map."""
    return _over_ground({BUMPS: 19}, quick, seed)


def _over_ground(
    grounds: dict[str, int], quick: bool, seed: int, known_only: tuple[str, ...] = ()
) -> Bars:
    """Trot over each ground, as often as is wanted of it, with sensors that err; planned too."""
    count = 2 if quick else _WALKS
    cases = [
        BalanceCase(robot, None, _ON_GROUND, is_noisy=True, keeps_balance=keeps, knows_ground=knows)
        for keeps, knows in ((True, False), (True, True), (False, False))
        for robot in (_ON_GROUND_QUICK if quick else _WALKERS)
    ]
    whats = [(case, ground) for case in cases for ground in grounds]
    seeds = range(seed, seed + count)
    trots = iter(in_workers(trot_over, [(*what, number) for what in whats for number in seeds]))
    bars: list[Criterion] = []
    details: dict[str, object] = {}
    for case, ground in whats:
        found = [next(trots) for _ in seeds]
        number = sum(trot.succeeds for trot in found)
        name = f'{case}: walks {ground}, of {count}'
        if case.keeps_balance and (case.knows_ground or ground not in known_only):
            bars.append(at_least(name, number, '', math.floor(grounds[ground] * count / _WALKS)))
        else:
            bars.append(figure(name, number, ''))
        details[name] = [asdict(trot) for trot in found]
    return bars, details


def _goals(console: Console, quick: bool, seed: int) -> Bars:
    """Walk to goals over topics, pushed half as hard as nine of ten pushes are survived."""
    # Only here: the other parts need no ROS.
    from quad_lab.balance.pushed_walks import pushed_walks

    robots = _WHO_WALKS[:1] if quick else _WHO_WALKS
    levels = {robot: _HALF * own_push_level(robot) for robot in robots}
    return pushed_walks(console, levels, 1 if quick else _GOALS, seed)


PARTS: dict[str, Callable[[Console, bool, int], Bars]] = {
    'levels': pushes_of_level,
    'pushes': hardest_pushes,
    'curves': survival_curves,
    'balls': thrown_balls,
    'disturbed': disturbed_pushes,
    'unpushed': unpushed_trots,
    'turns': turns_on_the_spot,
    'walks': unpushed_walks,
    'stops': stops_along_a_plan,
    'silence': silences_at_random,
    'slopes': _slopes,
    'bumps': _bumps,
    _OVER_TOPICS: _goals,
}
"""What is measured, by the name for ``--only``."""
