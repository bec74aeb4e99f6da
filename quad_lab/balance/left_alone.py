"""
Parts of ``quadwalk bench balance`` in which nobody pushes: steady gaits, stops and silence.
"""

from __future__ import annotations

import math
from dataclasses import asdict, replace

from rich.console import Console
from rich.table import Table

from quad_lab.balance.balance_case import BalanceCase
from quad_lab.balance.push_levels import HARDEST, LEVELS, own_push_level
from quad_lab.balance.pushes import survivors
from quad_lab.balance.steady import SteadyTrot, silences, steady_trot
from quad_lab.balance.stops import stopped_walk
from quad_lab.balance.trials import DIRECTIONS, NEEDED, PHASES, QUICK, SPEEDS, Bars, in_workers
from quad_lab.balance.turns import SteadyTurn, steady_turn
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure

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


def unpushed_trots(console: Console, quick: bool, seed: int) -> Bars:
    """Trot straight on, and compare with the trot that is planned as a whole."""
    whos = [QUICK] if quick else list(LEVELS)
    speeds = (0.5,) if quick else SPEEDS
    cases = [BalanceCase(*who, speed=speed) for who in whos for speed in speeds]
    planned = [replace(case, keeps_balance=False) for case in cases]
    duration = 4.0 if quick else _STEADY
    trots = in_workers(steady_trot, [(case, duration, seed) for case in (*cases, *planned)])
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


def unpushed_walks(console: Console, quick: bool, seed: int) -> Bars:
    """Walk in place of trotting: on the way, and pushed."""
    whos = _WHO_WALK[:1] if quick else _WHO_WALK
    speeds = (0.5,) if quick else SPEEDS
    cases = [BalanceCase(robot, speed=speed, gait='walk') for robot in whos for speed in speeds]
    trots = in_workers(steady_trot, [(case, 4.0 if quick else _STEADY, seed) for case in cases])
    bars = [at_most('falls of steady walks', sum(trot.has_fallen for trot in trots), '', 0)]
    for trot in trots:
        bars += _course_bars(trot)
        bars.append(figure(f'{trot.case}: tilt rms', math.degrees(trot.tilt_rms), 'deg'))
    pushed = [BalanceCase(robot, gait='walk') for robot in whos]
    phases = 1 if quick else PHASES
    jobs = [(case, HARDEST * own_push_level(case.robot), DIRECTIONS, phases) for case in pushed]
    fractions = in_workers(survivors, jobs)
    for (case, level, _, _), fraction in zip(jobs, fractions):
        name = f'{case}: pushes of {level:.3g} m sqrt(g h) survived'
        bars.append(at_least(name, 100.0 * fraction, '%', 100.0 * NEEDED))
    details: dict[str, object] = {str(trot.case): asdict(trot) for trot in trots}
    return bars, details | {f'{job[0]}, pushed': part for job, part in zip(jobs, fractions)}


def turns_on_the_spot(console: Console, quick: bool, seed: int) -> Bars:
    """Turn on the spot as fast as limits allow."""
    whos = [QUICK] if quick else list(LEVELS)
    cases = [BalanceCase(*who, speed=0.0) for who in whos]
    if not quick:
        cases += [BalanceCase(robot, speed=0.0, gait='walk') for robot in _WHO_WALK]
    jobs = [(case, side, 4.0 if quick else _TURNING, seed) for case in cases for side in (1, -1)]
    turns: list[SteadyTurn] = in_workers(steady_turn, jobs)
    bars = [at_most('falls of steady turns', sum(turn.has_fallen for turn in turns), '', 0)]
    for turn in turns:
        name = f'{turn.case}, turning at {turn.asked:.2f} rad/s'
        bars += [
            figure(f'{name}: error of the rate', 1e2 * turn.error, '%'),
            figure(f'{name}: tilt rms', math.degrees(turn.tilt_rms), 'deg'),
        ]
    return bars, {f'{turn.case} at {turn.asked:.2f}': asdict(turn) for turn in turns}


def stops_along_a_plan(console: Console, quick: bool, seed: int) -> Bars:
    """Follow a plan with a corner to its end, and compare the way with what the legs tell."""
    whos = [QUICK] if quick else [*LEVELS, *_WITH_OWN_PERIOD]
    walks = in_workers(stopped_walk, [(*who, seed) for who in whos])
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


def silences_at_random(console: Console, quick: bool, seed: int) -> Bars:
    """Let robots receive nothing more at random instants."""
    whos = [QUICK] if quick else list(LEVELS)
    count = 6 if quick else _SILENCES
    cases = [BalanceCase(*who, speed=1.0) for who in whos]
    stood = in_workers(silences, [(case, count, seed) for case in cases])
    return [
        at_least(f'{case}: silences that end on four feet, of {count}', number, '', count)
        for case, number in zip(cases, stood)
    ], {str(case): number for case, number in zip(cases, stood)}


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
