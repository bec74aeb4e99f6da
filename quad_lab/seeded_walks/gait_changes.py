"""
A gait with some of its numbers changed, and the file that says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from quad_common.robot.robot import Robot
from quad_gait.cycle.gait import Gait, Swing


def changed_gait(gait: Gait, numbers: Mapping[str, float]) -> Gait:
    """
    Change numbers of a gait.

    Parameters
    ----------
    gait : Gait
        The gait, fitted to its robot.
    numbers : mapping of str to float
        New values by their names, in the units of a gait file. A ``cycle_period`` [s] takes all
        times with it; a ``duty_factor`` makes every swing longer or shorter about its middle.

    Returns
    -------
    Gait
        The same gait, with its name.
    """
    changed = gait
    if 'cycle_period' in numbers:
        changed = changed.with_period(numbers['cycle_period'])
    if 'duty_factor' in numbers:
        changed = _with_duty_factor(changed, numbers['duty_factor'])
    if 'sway_weight' in numbers:
        weight = numbers['sway_weight']
        changed = replace(changed, sway_weight=(weight, weight))
    return replace(
        changed,
        swing_height=numbers.get('swing_height', changed.swing_height),
        support_depth=numbers.get('support_depth', changed.support_depth),
    )


def numbers_of(gait: Gait) -> dict[str, float]:
    """Return the numbers of a gait that can change, by their names."""
    return {
        'cycle_period': gait.cycle_period,
        'duty_factor': gait.duty_factor(gait.swings[0].leg),
        'swing_height': gait.swing_height,
        'support_depth': gait.support_depth,
        'sway_weight': gait.sway_weight[0],
    }


def gait_text(gait: Gait, robot: Robot, name: str, comment: str) -> str:
    """
    Write a gait of one robot as a gait file.

    Parameters
    ----------
    gait : Gait
        The gait, fitted to the robot.
    robot : Robot
        The robot: a file's swing height is that of TITAN-VIII, in proportion to the hips' height.
    name : str
        New name of the gait: under its old one the robot's own numbers would count.
    comment : str
        One line for the head of the file.

    Returns
    -------
    str
        YAML; fitted to the robot, it is this gait.
    """
    lines = [f'# {comment}', f'name: {name}', f'cycle_period: {gait.cycle_period!r}', 'swings:']
    lines += [f'  {s.leg}: [{s.liftoff!r}, {s.touchdown!r}]' for s in gait.swings]
    lines += [
        f'is_static: {str(gait.is_static).lower()}',
        f'footholds: {gait.footholds}',
        f'swing_path: {gait.swing_path}',
        f'swing_height: {gait.swing_height / robot.relative_size!r}',
        f'support_depth: {gait.support_depth!r}',
        f'sway_start: {gait.sway_start!r}',
        f'sway_weight: [{gait.sway_weight[0]!r}, {gait.sway_weight[1]!r}]',
    ]
    if gait.body_progress is not None:
        knots = ', '.join(f'[{t!r}, {fraction!r}]' for t, fraction in gait.body_progress)
        lines.append(f'body_progress: [{knots}]')
    return '\n'.join(lines) + '\n'


def _with_duty_factor(gait: Gait, duty_factor: float) -> Gait:
    half = (1.0 - duty_factor) * gait.cycle_period / 2.0
    swings = []
    for swing in gait.swings:
        middle = (swing.liftoff + swing.touchdown) / 2.0
        swings.append(Swing(swing.leg, middle - half, middle + half))
    return replace(gait, swings=tuple(swings))
