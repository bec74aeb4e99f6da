"""
``quadwalk bench robots``: robots imported from other people's descriptions, measured.
"""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import Any

from rich.console import Console
from rich.table import Table

from quad_common.errors import NotAQuadruped
from quad_common.importing.robot_import import import_robot
from quad_common.named_robots.known_robots import KNOWN_ROBOTS, known_names
from quad_common.robot_files.robot_file import load_robot
from quad_lab.robots.broken_descriptions import BROKEN_DESCRIPTIONS, import_broken
from quad_lab.robots.import_check import (
    REFUSED,
    UPRIGHT_Y,
    ImportCheck,
    check_import,
    other_description,
)
from quad_lab.robots.imported_walks import CURVES, DIRECTIONS, ImportedWalk, walk_imported
from quad_lab.robots.numeric_kinematics import compare_kinematics
from quad_lab.robots.reversals import reversal_bars
from quad_lab.robots.serial_bars import serial_bars
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import ENGINES

PARTS = ('imports', 'broken', 'kinematics', 'serial', 'walks', 'fast', 'reversals', 'topics')
"""Parts for ``--only``."""

_GAITS = ('crawl', 'wave', 'trot', 'walk')

_DYNAMIC = ('trot', 'walk')

_FRACTIONS = {'walks': 0.6, 'fast': 0.95}
"""Parts of the most that are walked."""

_QUICK = ('a1',)


def measure(
    console: Console,
    quick: bool,
    seed: int,
    only: tuple[str, ...] = (),
    robots: tuple[str, ...] = (),
) -> tuple[list[Criterion], dict[str, Any]]:
    """
    Import robots, break descriptions, and walk.

    Parameters
    ----------
    console : Console
        Where progress and tables are shown.
    quick : bool
        One robot, a few walks.
    seed : int
        Of postures and goals.
    only : tuple of str
        Parts to run; all if empty, or both of walks if robots are given.
    robots : tuple of str
        Robots that walk; those whose descriptions are installed if empty.

    Returns
    -------
    bars : list of Criterion
        What was measured.
    details : dict
        Every import and walk.
    """
    names = known_names()
    chosen = _chosen(console, names, quick, robots)
    parts = only or _parts(quick, bool(robots))
    bars: list[Criterion] = []
    details: dict[str, Any] = {}
    if 'imports' in parts:
        found, details['imports'] = _imports(console, names, seed)
        bars += found
    if 'broken' in parts:
        bars += _broken_bars(console)
    if 'kinematics' in parts and chosen:
        bars += _kinematics_bars(chosen[0], seed)
    if 'serial' in parts:
        found, details['serial'] = serial_bars(console, quick, seed)
        bars += found
    for part, fraction in _FRACTIONS.items():
        if part in parts:
            walks = _walks(console, chosen, fraction, quick)
            bars += _walk_bars(walks) if part == 'walks' else _fast_bars(walks)
            details[part] = [asdict(found) for found in walks]
    if 'reversals' in parts:
        found, details['reversals'] = reversal_bars(console, chosen, quick)
        bars += found
    if 'topics' in parts:
        # Whatever is not over topics needs no ROS.
        from quad_lab.robots.topic_walks import topic_bars

        bars += topic_bars(console, names, seed)
    return bars, details


def _chosen(
    console: Console, names: tuple[str, ...], quick: bool, robots: tuple[str, ...]
) -> tuple[str, ...]:
    """Return the robots that walk; one that cannot be read is said before anything walks."""
    if not names:
        console.print('no description of a robot is installed: pip install pybullet')
    for name in robots:
        load_robot(name)
    return robots or (tuple(name for name in _QUICK if name in names) if quick else names)


def _parts(quick: bool, has_robots: bool) -> tuple[str, ...]:
    if has_robots:
        return ('walks',) if quick else tuple(_FRACTIONS)
    return ('imports', 'broken', 'kinematics', 'walks') if quick else PARTS


def _imports(
    console: Console, names: tuple[str, ...], seed: int
) -> tuple[list[Criterion], list[dict[str, Any]]]:
    """Import every description, and see that one that must be refused is."""
    described = {name: KNOWN_ROBOTS[name] for name in names}
    if 'laikago' in described:
        described['laikago, y up'] = other_description(UPRIGHT_Y, 'laikago')
    checks = [c for name, known in described.items() for c in check_import(name, known, seed)]
    console.print(_import_table(checks))
    bars = _import_bars(checks, len(described))
    if 'laikago' in described:
        bars += _refusal_bars()
    return bars, [asdict(check) for check in checks]


def _import_table(checks: list[ImportCheck]) -> Table:
    table = Table('robot', 'engine', 'import', 'feet', 'mass', 'center of mass', title='imports')
    for check in checks:
        table.add_row(
            check.robot,
            check.engine,
            f'{check.seconds:.2f} s',
            f'{check.foot:.1e} m',
            f'{check.mass:.1e}',
            f'{check.center:.1e} m',
        )
    return table


def _import_bars(checks: list[ImportCheck], robots: int) -> list[Criterion]:
    read = [check for check in checks if math.isfinite(check.foot)]
    return [
        at_least('robots imported without an edit', robots, '', 8),
        at_most('feet beside the engines', max((c.foot for c in read), default=None), 'm', 1e-5),
        at_most('masses beside the engines', max((c.mass for c in read), default=None), '', 1e-6),
        at_most(
            'centers of mass beside the engines',
            max((c.center for c in read), default=None),
            'm',
            1e-3,
        ),
        figure('longest import', max((c.seconds for c in checks), default=None), 's'),
    ]


def _refusal_bars() -> list[Criterion]:
    known = other_description(REFUSED, 'laikago')
    assert known.path is not None
    try:
        import_robot(known.path, known.options)
    except NotAQuadruped:
        return [at_least('robot with closed loops refused', 1, '', 1)]
    return [at_least('robot with closed loops refused', 0, '', 1)]


def _broken_bars(console: Console) -> list[Criterion]:
    faults = BROKEN_DESCRIPTIONS
    results = [import_broken(fault, change) for fault, change in faults.items()]
    for result in results:
        if not result.is_named:
            console.print(f'not named: {result.fault}: {result.said or "accepted"}')
    named = sum(result.is_named for result in results)
    return [
        at_least(
            f'broken descriptions whose fault is named, of {len(results)}', named, '', len(results)
        )
    ]


def _kinematics_bars(robot: str, seed: int) -> list[Criterion]:
    found = compare_kinematics(load_robot(robot), seed)
    return [
        at_most('closed form beside numeric inverse kinematics', found.difference, 'rad', 1e-6),
        figure('inverse kinematics of four legs, closed form', 1e6 * found.closed, 'us'),
        figure('inverse kinematics of four legs, numeric', 1e6 * found.numeric, 'us'),
    ]


def _walks(
    console: Console, robots: tuple[str, ...], fraction: float, quick: bool
) -> list[ImportedWalk]:
    engines = [name for name, e in ENGINES.items() if e.has_world and e.is_installed]
    directions = ('forward',) if quick else tuple(DIRECTIONS)
    jobs = [
        (robot, gait, direction, engine, fraction)
        for robot in robots
        for gait in _GAITS
        for direction in directions
        for engine in engines
    ]
    walks: list[ImportedWalk] = []
    with worker_pool() as pool:
        for found in pool.map(walk_imported, *zip(*jobs)):
            walks.append(found)
            console.print(
                f'walk {len(walks)} of {len(jobs)}: {found.robot} {found.gait} {found.direction} '
                f'({found.backend}): {_outcome(found)}'
            )
    return walks


def _outcome(found: ImportedWalk) -> str:
    if found.problem:
        return found.problem
    return (
        f'{found.fraction * found.most:.3f} per s, off by {100.0 * found.error:.2f} %, drift '
        f'{100.0 * found.drift:.2f} %, tilt {math.degrees(found.tilt_rms):.2f} deg'
        + (', FELL' if found.has_fallen else '')
    )


def _walk_bars(walks: list[ImportedWalk]) -> list[Criterion]:
    walked = [found for found in walks if not found.problem]
    bars = [
        at_least(f'walks that were walked, of {len(walks)}', len(walked), '', len(walks)),
        at_most('falls', sum(found.has_fallen for found in walks), '', 0),
    ]
    for gait in _GAITS:
        own = [found for found in walked if found.gait == gait]
        drift = 0.02 if gait in _DYNAMIC else 0.01
        off = max((abs(found.error) for found in own), default=None)
        aside = max((found.drift for found in own if found.direction not in CURVES), default=None)
        beside = max((found.drift for found in own if found.direction in CURVES), default=None)
        bars += [
            at_most(f'{gait}: distance off', off, '', 0.02),
            at_most(f'{gait}: drift', aside, 'm/m', drift),
            figure(f'{gait}: drift on curves', beside, 'm/m'),
        ]
        if gait in _DYNAMIC:
            tilt = max((math.degrees(found.tilt_rms) for found in own), default=None)
            bars.append(at_most(f'{gait}: tilt, rms', tilt, 'deg', 1.5))
    return bars


def _fast_bars(walks: list[ImportedWalk]) -> list[Criterion]:
    bars = [at_most('falls at 95 % of the most', sum(f.has_fallen for f in walks), '', 0)]
    trots = [f for f in walks if (f.robot, f.gait, f.direction) == ('a1', 'trot', 'forward')]
    if trots:
        speed = min(f.fraction * f.most * (1.0 + f.error) for f in trots)
        bars.append(at_least('a1: trot, walked', speed, 'm/s', 1.0))
    return bars
