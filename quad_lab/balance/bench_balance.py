"""
``quadwalk bench balance``: pushes that trotting robots survive, and how they trot without.
"""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import asdict, replace
from typing import Any, TypeVar

from rich.console import Console
from rich.table import Table

from quad_lab.balance.balance_case import BalanceCase
from quad_lab.balance.push_levels import HARDEST, LEVELS, own_push_level, push_level
from quad_lab.balance.pushes import Survival, survival, survivors
from quad_lab.balance.rough_ground import BUMPS, RAMPS, SLOPES, trot_over
from quad_lab.balance.steady import SteadyTrot, silences, steady_trot
from quad_lab.balance.stops import stopped_walk
from quad_lab.balance.turns import SteadyTurn, steady_turn
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import AUTO, preferred, resolved

Result = TypeVar('Result')

Bars = tuple[list[Criterion], dict[str, object]]

_SURVIVE = 0.9

_SPEEDS = (0.0, 0.5, 1.0)

_DIRECTIONS, _PHASES = 8, 8

_SILENCES = 200

_WITH_OWN_PERIOD = (('a1', None),)
"""What else follows a plan with a corner."""

_BEYOND, _ODOMETRY = 0.1, 3.0
"""Distance beyond corner and goal [m], and error of leg odometry meanwhile [%], at most."""

_STEADY = 20.0
"""Time of a trot that nothing disturbs [s]."""

_WHO_WALK = ('a1', 'mini_cheetah', 'genibo', 'cuhk', 'titan_viii')
"""Robots that walk in place of trotting."""

_TURNING = 10.0
"""Time of a turn on the spot [s]."""

_QUICK = ('a1', 0.3)

_WALKERS = ('a1', 'genibo', 'cuhk')
"""Robots that trot over slopes and bumps."""

_ON_GROUND, _ON_GROUND_QUICK = 0.6, ('cuhk',)
"""Fraction of the most speed at which they do, and which of them in a hurry."""

_WALKS = 20
"""Walks of each over each ground."""


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
        if (only and name not in only) or (quick and not only and name == 'levels'):
            continue
        console.rule(name)
        if name == _OVER_TOPICS and name not in only and importlib.util.find_spec('rclpy') is None:
            console.print('left out: it walks over topics, and rclpy is not installed')
            continue
        part_bars, details[name] = part(console, quick, seed)
        bars += part_bars
    return bars, details


def _in_workers(work: Callable[..., Result], jobs: Sequence[tuple[Any, ...]]) -> list[Result]:
    """Do all jobs in worker processes, in the engine that runs here."""
    with worker_pool() as pool:
        return _mapped(pool, work, jobs)


def _mapped(
    pool: Executor, work: Callable[..., Result], jobs: Sequence[tuple[Any, ...]]
) -> list[Result]:
    backend = resolved(AUTO)
    return [f.result() for f in [pool.submit(_in_engine, backend, work, *job) for job in jobs]]


def _in_engine(backend: str, work: Callable[..., Result], *given: Any) -> Result:
    with preferred(backend):
        return work(*given)


def _pushes(console: Console, quick: bool, seed: int) -> Bars:
    """Push from all directions at all phases, in place, at half and at full speed."""
    if quick:
        case = BalanceCase(*_QUICK)
        level = push_level(*_QUICK)
        (fraction,) = _in_workers(survivors, [(case, level, 4, 2)])
        name = f'{case}: pushes of {level:.3g} m sqrt(g h) survived, of 8'
        return [at_least(name, 8.0 * fraction, '', 7.0)], {str(case): fraction}
    cases = [BalanceCase(*who, speed=speed) for who in LEVELS for speed in _SPEEDS]
    planned = [replace(case, keeps_balance=False) for case in cases]
    found = _in_workers(survival, [(c, _DIRECTIONS, _PHASES, seed) for c in (*cases, *planned)])
    console.print(_push_table(found))
    bars = []
    for one, other in zip(found, found[len(cases) :]):
        level = push_level(one.case.robot, one.case.period)
        value = one.survived_by(_SURVIVE)
        bars += [
            at_least(f'{one.case}: impulse that 90 % survive', value, 'm sqrt(g h)', level),
            figure(f'{one.case}: the same, planned', other.survived_by(_SURVIVE), 'm sqrt(g h)'),
        ]
    return bars, {str(one.case): asdict(one) for one in found}


def _levels(console: Console, quick: bool, seed: int) -> Bars:
    """Push as hard as nine of ten pushes are to be survived; less where all makes it harder."""
    whos = [_QUICK] if quick else list(LEVELS)
    cases = [BalanceCase(*who) for who in whos]
    cases += [case.hardest() for case in cases] + [
        replace(case, keeps_balance=False) for case in cases
    ]
    phases = 1 if quick else _PHASES
    jobs = []
    for case in cases:
        part = HARDEST if case == case.hardest() else 1.0
        jobs.append((case, part * push_level(case.robot, case.period), _DIRECTIONS, phases))
    fractions = _in_workers(survivors, jobs)
    bars = []
    for (case, level, _, _), fraction in zip(jobs, fractions):
        name = f'{case}: pushes of {level:.3g} m sqrt(g h) survived'
        keeps = case.keeps_balance
        value = 100.0 * fraction
        bars.append(at_least(name, value, '%', 90.0) if keeps else figure(name, value, '%'))
    return bars, {str(job[0]): fraction for job, fraction in zip(jobs, fractions)}


def _disturbed(console: Console, quick: bool, seed: int) -> Bars:
    """Push on slippery ground, with a payload, late, with noise; each alone and all together."""
    if quick:
        case = BalanceCase(*_QUICK).hardest()
        level = HARDEST * push_level(*_QUICK)
        (fraction,) = _in_workers(survivors, [(case, level, 4, 2)])
        name = f'{case}: pushes of {level:.3g} m sqrt(g h) survived, of 8'
        return [at_least(name, 8.0 * fraction, '', 7.0)], {str(case): fraction}
    cases = []
    for who in LEVELS:
        case = BalanceCase(*who)
        cases += [
            replace(case, is_slippery=True),
            replace(case, has_payload=True),
            replace(case, is_late=True),
            replace(case, is_noisy=True),
            case.hardest(),
        ]
    found = _in_workers(survival, [(case, _DIRECTIONS, _PHASES, seed) for case in cases])
    console.print(_push_table(found))
    bars = []
    for one in found:
        value, name = one.survived_by(_SURVIVE), f'{one.case}: impulse that 90 % survive'
        level = HARDEST * push_level(one.case.robot, one.case.period)
        is_all = one.case == one.case.hardest()
        bars.append(
            at_least(name, value, 'm sqrt(g h)', level)
            if is_all
            else figure(name, value, 'm sqrt(g h)')
        )
    return bars, {str(one.case): asdict(one) for one in found}


def _push_table(found: Sequence[Survival]) -> Table:
    table = Table(
        'case', '90 % survive', '50 %', 'the least', 'gained by the body, median',
        title='impulse over m sqrt(g h), of 0.1 s',
    )  # fmt: skip
    for one in found:
        if one.has_fallen:
            table.add_row(str(one.case), 'fell before', '', '', '')
            continue
        gained = sorted(one.gained)[len(one.gained) // 2]
        figures = (one.survived_by(_SURVIVE), one.survived_by(0.5), min(one.impulses), gained)
        table.add_row(str(one.case), *(f'{value:.2f}' for value in figures))
    return table


def _unpushed(console: Console, quick: bool, seed: int) -> Bars:
    """Trot straight on, and compare with the trot that is planned as a whole."""
    whos = [_QUICK] if quick else list(LEVELS)
    speeds = (0.5,) if quick else _SPEEDS
    cases = [BalanceCase(*who, speed=speed) for who in whos for speed in speeds]
    planned = [replace(case, keeps_balance=False) for case in cases]
    duration = 4.0 if quick else _STEADY
    trots = _in_workers(steady_trot, [(case, duration, seed) for case in (*cases, *planned)])
    columns = ('asked', 'walked', 'drift', 'odometry', 'tilt rms', 'decision')
    table = Table('case', *columns, title='steady trots')
    for trot in trots:
        table.add_row(
            str(trot.case), f'{trot.asked:.3f} m/s', f'{trot.speed:.3f} m/s',
            f'{1e2 * trot.drift:.2f} %', f'{1e2 * trot.odometry_error:.2f} %',
            f'{math.degrees(trot.tilt_rms):.2f} deg', f'{1e3 * trot.update_time:.2f} ms',
        )  # fmt: skip
    console.print(table)
    bars = [at_most('falls of steady trots', sum(t.has_fallen for t in trots[: len(cases)]), '', 0)]
    for trot, other in zip(trots, trots[len(cases) :]):
        bars += _trot_bars(trot, other)
    slowest = max(trot.update_time for trot in trots[: len(cases)])
    bars.append(at_most('time of a decision, median of the slowest', 1e3 * slowest, 'ms', 2.0))
    return bars, {str(trot.case): asdict(trot) for trot in trots}


def _trot_bars(trot: SteadyTrot, planned: SteadyTrot) -> list[Criterion]:
    name = str(trot.case)
    tilt, before = math.degrees(trot.tilt_rms), math.degrees(planned.tilt_rms)
    bars = [at_most(f'{name}: tilt rms (planned: {before:.2f})', tilt, 'deg', max(before, 0.1))]
    return bars + _course_bars(trot)


def _course_bars(trot: SteadyTrot) -> list[Criterion]:
    if not trot.asked:
        return []
    name = str(trot.case)
    return [
        at_most(f'{name}: error of the speed', 1e2 * abs(trot.error), '%', 2.0),
        at_most(f'{name}: drift', 1e2 * trot.drift, '%', 1.0),
        at_most(f'{name}: error of leg odometry', 1e2 * trot.odometry_error, '%', 1.0),
    ]


def _stops(console: Console, quick: bool, seed: int) -> Bars:
    """Follow a plan with a corner to its end, and compare the way with what the legs tell."""
    whos = [_QUICK] if quick else [*LEVELS, *_WITH_OWN_PERIOD]
    walks = _in_workers(stopped_walk, [(*who, seed) for who in whos])
    bars = []
    for (robot, period), walk in zip(whos, walks):
        name = str(BalanceCase(robot, period)).removesuffix(' at half speed')
        odometry = 1e2 * walk.odometry_error
        bars += [
            at_least(f'{name}: arrives at a goal behind a corner', walk.has_arrived, '', 1),
            at_most(f'{name}: distance beyond corner and goal', walk.beyond, 'm', _BEYOND),
            at_most(f'{name}: most that leg odometry is off on the way', odometry, '%', _ODOMETRY),
            figure(f'{name}: time', walk.duration, 's'),
        ]
    return bars, {str(who): asdict(walk) for who, walk in zip(whos, walks)}


def _walks(console: Console, quick: bool, seed: int) -> Bars:
    """Walk in place of trotting: on the way, and pushed."""
    whos = _WHO_WALK[:1] if quick else _WHO_WALK
    speeds = (0.5,) if quick else _SPEEDS
    cases = [BalanceCase(robot, speed=speed, gait='walk') for robot in whos for speed in speeds]
    trots = _in_workers(steady_trot, [(case, 4.0 if quick else _STEADY, seed) for case in cases])
    bars = [at_most('falls of steady walks', sum(trot.has_fallen for trot in trots), '', 0)]
    for trot in trots:
        bars += _course_bars(trot)
        bars.append(figure(f'{trot.case}: tilt rms', math.degrees(trot.tilt_rms), 'deg'))
    pushed = [BalanceCase(robot, gait='walk') for robot in whos]
    phases = 1 if quick else _PHASES
    jobs = [(case, HARDEST * own_push_level(case.robot), _DIRECTIONS, phases) for case in pushed]
    fractions = _in_workers(survivors, jobs)
    for (case, level, _, _), fraction in zip(jobs, fractions):
        name = f'{case}: pushes of {level:.3g} m sqrt(g h) survived'
        bars.append(at_least(name, 100.0 * fraction, '%', 100.0 * _SURVIVE))
    details: dict[str, object] = {str(trot.case): asdict(trot) for trot in trots}
    return bars, details | {f'{job[0]}, pushed': part for job, part in zip(jobs, fractions)}


def _turns(console: Console, quick: bool, seed: int) -> Bars:
    """Turn on the spot as fast as limits allow."""
    whos = [_QUICK] if quick else list(LEVELS)
    cases = [BalanceCase(*who, speed=0.0) for who in whos]
    if not quick:
        cases += [BalanceCase(robot, speed=0.0, gait='walk') for robot in _WHO_WALK]
    jobs = [(case, side, 4.0 if quick else _TURNING, seed) for case in cases for side in (1, -1)]
    turns: list[SteadyTurn] = _in_workers(steady_turn, jobs)
    bars = [at_most('falls of steady turns', sum(turn.has_fallen for turn in turns), '', 0)]
    for turn in turns:
        name = f'{turn.case}, turning at {turn.asked:.2f} rad/s'
        bars += [
            figure(f'{name}: error of the rate', 1e2 * turn.error, '%'),
            figure(f'{name}: tilt rms', math.degrees(turn.tilt_rms), 'deg'),
        ]
    return bars, {f'{turn.case} at {turn.asked:.2f}': asdict(turn) for turn in turns}


def _silence(console: Console, quick: bool, seed: int) -> Bars:
    """Let robots receive nothing more at random instants."""
    whos = [_QUICK] if quick else list(LEVELS)
    count = 6 if quick else _SILENCES
    cases = [BalanceCase(*who, speed=1.0) for who in whos]
    stood = _in_workers(silences, [(case, count, seed) for case in cases])
    return [
        at_least(f'{case}: silences that end on four feet, of {count}', number, '', count)
        for case, number in zip(cases, stood)
    ], {str(case): number for case, number in zip(cases, stood)}


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
    trots = iter(_in_workers(trot_over, [(*what, number) for what in whats for number in seeds]))
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
    'levels': _levels,
    'pushes': _pushes,
    'disturbed': _disturbed,
    'unpushed': _unpushed,
    'turns': _turns,
    'walks': _walks,
    'stops': _stops,
    'silence': _silence,
    'slopes': _slopes,
    'bumps': _bumps,
    _OVER_TOPICS: _goals,
}
"""What is measured, by the name for ``--only``."""
