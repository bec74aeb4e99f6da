"""
Parts of ``quadwalk bench balance`` in which robots are pushed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path

from rich.console import Console
from rich.table import Table

from quad_common.files.bounded_file import make_folder
from quad_lab.balance.balance_case import BalanceCase
from quad_lab.balance.push_levels import HARDEST, LEVELS, push_level
from quad_lab.balance.pushes import Survival, survival, survivors
from quad_lab.balance.survival_picture import draw_survival
from quad_lab.balance.thrown_ball import hit
from quad_lab.balance.trials import DIRECTIONS, NEEDED, PHASES, QUICK, SPEEDS, Bars, in_workers
from quad_lab.tools.criterion import at_least, at_most, figure
from quad_sim.engines.registry import AUTO, resolved

_PICTURES = 'balance'
"""Folder for the survival curves."""


def hardest_pushes(console: Console, quick: bool, seed: int) -> Bars:
    """Push from all directions at all phases, in place, at half and at full speed."""
    if quick:
        case = BalanceCase(*QUICK)
        level = push_level(*QUICK)
        (fraction,) = in_workers(survivors, [(case, level, 4, 2)])
        name = f'{case}: pushes of {level:.3g} m sqrt(g h) survived, of 8'
        return [at_least(name, 8.0 * fraction, '', 7.0)], {str(case): fraction}
    cases = [BalanceCase(*who, speed=speed) for who in LEVELS for speed in SPEEDS]
    planned = [replace(case, keeps_balance=False) for case in cases]
    found = in_workers(survival, [(c, DIRECTIONS, PHASES, seed) for c in (*cases, *planned)])
    console.print(_push_table(found))
    bars = []
    for one, other in zip(found, found[len(cases) :]):
        level = push_level(one.case.robot, one.case.period)
        value = one.survived_by(NEEDED)
        bars += [
            at_least(f'{one.case}: impulse that 90 % survive', value, 'm sqrt(g h)', level),
            figure(f'{one.case}: the same, planned', other.survived_by(NEEDED), 'm sqrt(g h)'),
        ]
    return bars, {str(one.case): asdict(one) for one in found}


def pushes_of_level(console: Console, quick: bool, seed: int) -> Bars:
    """Push as hard as nine of ten pushes are to be survived; less where all makes it harder."""
    whos = [QUICK] if quick else list(LEVELS)
    cases = [BalanceCase(*who) for who in whos]
    cases += [case.hardest() for case in cases] + [
        replace(case, keeps_balance=False) for case in cases
    ]
    phases = 1 if quick else PHASES
    jobs = []
    for case in cases:
        part = HARDEST if case == case.hardest() else 1.0
        jobs.append((case, part * push_level(case.robot, case.period), DIRECTIONS, phases))
    return _survival_bars('pushes', cases, [job[1] for job in jobs], in_workers(survivors, jobs))


def survival_curves(console: Console, quick: bool, seed: int) -> Bars:
    """Draw which part of the pushes is survived, over how hard they are, at half speed."""
    whos = [QUICK] if quick else list(LEVELS)
    directions, phases = (4, 1) if quick else (DIRECTIONS, PHASES)
    cases = [BalanceCase(*who) for who in whos]
    kinds = {
        'keeps its balance': cases,
        'keeps its balance: slippery, loaded, late, noisy': [case.hardest() for case in cases],
        'planned a cycle ahead': [replace(case, keeps_balance=False) for case in cases],
    }
    jobs = [(case, directions, phases, seed) for kind in kinds.values() for case in kind]
    found = in_workers(survival, jobs)
    console.print(_push_table(found))
    columns = {name: found[k * len(cases) :][: len(cases)] for k, name in enumerate(kinds)}
    path = Path(_PICTURES) / f'survival_{resolved(AUTO)}.png'
    make_folder(path.parent)
    draw_survival(path, columns)
    console.print(f'picture: {path}')
    fallen = sum(one.has_fallen for one in found[: 2 * len(cases)])
    bars = [at_most('robots that fell before they were pushed', fallen, '', 0)]
    return bars, {str(one.case): asdict(one) for one in found}


def thrown_balls(console: Console, quick: bool, seed: int) -> Bars:
    """Throw a ball of a quarter of the robot's mass, with the impulse of a push."""
    whos = [QUICK] if quick else list(LEVELS)
    directions, phases = (4, 1) if quick else (DIRECTIONS, PHASES)
    cases = [BalanceCase(*who) for who in whos]
    cases += [replace(case, keeps_balance=False) for case in cases]
    jobs = [(case, push_level(case.robot, case.period), directions, phases, hit) for case in cases]
    return _survival_bars('balls', cases, [job[1] for job in jobs], in_workers(survivors, jobs))


def disturbed_pushes(console: Console, quick: bool, seed: int) -> Bars:
    """Push on slippery ground, with a payload, late, with noise; each alone and all together."""
    if quick:
        case = BalanceCase(*QUICK).hardest()
        level = HARDEST * push_level(*QUICK)
        (fraction,) = in_workers(survivors, [(case, level, 4, 2)])
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
    found = in_workers(survival, [(case, DIRECTIONS, PHASES, seed) for case in cases])
    console.print(_push_table(found))
    bars = []
    for one in found:
        value, name = one.survived_by(NEEDED), f'{one.case}: impulse that 90 % survive'
        level = HARDEST * push_level(one.case.robot, one.case.period)
        is_all = one.case == one.case.hardest()
        bars.append(
            at_least(name, value, 'm sqrt(g h)', level)
            if is_all
            else figure(name, value, 'm sqrt(g h)')
        )
    return bars, {str(one.case): asdict(one) for one in found}


def _survival_bars(
    what: str, cases: Sequence[BalanceCase], levels: Sequence[float], fractions: Sequence[float]
) -> Bars:
    """Hold robots that keep their balance to nine of ten, and tell of the others."""
    bars = []
    for case, level, fraction in zip(cases, levels, fractions):
        name, value = f'{case}: {what} of {level:.3g} m sqrt(g h) survived', 100.0 * fraction
        bars.append(
            at_least(name, value, '%', 100.0 * NEEDED)
            if case.keeps_balance
            else figure(name, value, '%')
        )
    return bars, {str(case): fraction for case, fraction in zip(cases, fractions)}


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
        figures = (one.survived_by(NEEDED), one.survived_by(0.5), min(one.impulses), gained)
        table.add_row(str(one.case), *(f'{value:.2f}' for value in figures))
    return table
