"""
``quadwalk gait``: lists the gaits, checks one on a robot, or derives a robot's paces.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

from quad_cli.arguments import output_argument, quantity_argument
from quad_common.files.bounded_file import check_target
from quad_common.quantity import Quantity
from quad_common.robot_files.robot_file import load_robot
from quad_common.robot_files.walking_time import (
    WalkingTimeModel,
    load_paces,
    paces_file,
    save_paces,
)
from quad_gait.cycle.gait import available_gaits, load_gait, turning_gait_for
from quad_gait.cycle.gait_check import check_gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.follower_pace import pace_of
from quad_gait.following.swept_radius import sweep_of_turns

EXAMPLES = """examples:
  quadwalk gait list
  quadwalk gait check wave --robot genibo
  quadwalk gait check my_gait.yaml --robot my_robot.yaml --json
  quadwalk gait pace --robot my_robot.yaml
"""


PACED = ('crawl', 'wave', 'trot', 'walk')
"""The gaits that follow a plan by straight stretches and turns on the spot."""

_HEADING = (
    'How far one cycle of each gait goes, for the planner: stride [m], turn on the spot [rad],',
    'cycle_period [s]. Derived from reach, joints and stability margin.',
    'Written by: quadwalk gait pace',
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    actions = parser.add_subparsers(dest='action', metavar='action', required=True)
    listing = actions.add_parser('list', help='list the gaits that ship')
    listing.add_argument('--json', action='store_true', help='print one JSON object only')
    checking = actions.add_parser('check', help='say what a gait can do, and what is wrong with it')
    checking.add_argument('gait', help='name of a gait, or path of a gait file')
    checking.add_argument(
        '--robot', default='titan_viii', help='name of a robot, or path of a data file'
    )
    checking.add_argument(
        '--least-margin',
        type=quantity_argument('least margin', Quantity(-10.0, 10.0, 'm')),
        default=0.0,
        help='least stability margin of static gaits, 0 if left out [m]',
    )
    checking.add_argument('--json', action='store_true', help='print one JSON object only')
    pacing = actions.add_parser(
        'pace', help="derive how far each gait's cycles go, and write it for the planner"
    )
    pacing.add_argument(
        'gaits', nargs='*', default=list(PACED), help='names of gaits, or paths of gait files'
    )
    pacing.add_argument(
        '--robot', default='titan_viii', help='name of a robot, or path of a data file'
    )
    pacing.add_argument(
        '--output',
        type=output_argument,
        default=None,
        help='file to write; beside the robot if left out',
    )
    pacing.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if nothing is wrong."""
    if arguments.action == 'list':
        return _list(arguments.json)
    if arguments.action == 'pace':
        return _pace(arguments)
    robot = load_robot(arguments.robot)
    gait = load_gait(arguments.gait, robot)
    report = check_gait(robot, gait, arguments.least_margin)
    if arguments.json:
        print(json.dumps({'robot': robot.name, 'gait': gait.name, **asdict(report)}))
        return 1 if report.problems else 0
    table = Table('direction', 'largest', 'speed', 'margin [mm]', 'order')
    for motion in report.motions:
        stride = math.hypot(motion.largest.forward, motion.largest.left)
        turn = math.degrees(abs(motion.largest.turn))
        rate = 1.0 / gait.cycle_period
        table.add_row(
            motion.direction,
            f'{turn:.1f} deg' if turn else f'{1e3 * stride:.0f} mm',
            f'{turn * rate:.1f} deg/s' if turn else f'{stride * rate:.3f} m/s',
            f'{1e3 * motion.least_margin:.1f}',
            ' '.join(motion.order),
        )
    console = Console()
    console.print(f'{gait.name} on {robot.name}, a cycle of {gait.cycle_period:g} s:')
    console.print(table)
    for motion in report.motions:
        console.print(f'{motion.direction}, what forbids more: {motion.limit}', soft_wrap=True)
        console.print(
            f'{motion.direction}, own parts: {" and ".join(motion.nearest_parts)} come within '
            f'{1e3 * motion.clearance:.1f} mm at {100.0 * motion.nearest_at:.0f} % of the cycle',
            soft_wrap=True,
        )
    for problem in report.problems:
        console.print(f'wrong: {problem}', soft_wrap=True)
    return 1 if report.problems else 0


def _pace(arguments: argparse.Namespace) -> int:
    path = arguments.output or paces_file(arguments.robot)
    # Before the work, which takes its time.
    check_target(path, 'file of paces')
    known = load_paces(path)
    paces = derive_paces(arguments.robot, arguments.gaits)
    save_paces(known | paces, path, _HEADING)
    if arguments.json:
        print(json.dumps({name: asdict(pace) for name, pace in paces.items()}))
        return 0
    table = Table('gait', 'cycle', 'stride', 'turn', 'added to each', 'sweep')
    for name, pace in paces.items():
        table.add_row(
            name,
            f'{pace.cycle_period:g} s',
            f'{1e3 * pace.stride:.0f} mm',
            f'{math.degrees(pace.turn):.1f} deg',
            f'{pace.stopping:g} cycles',
            f'{1e3 * pace.sweep:.0f} mm',
        )
    console = Console()
    console.print(table)
    console.print(f'written to {path}', soft_wrap=True)
    return 0


def derive_paces(robot_name: str, gaits: Sequence[str]) -> dict[str, WalkingTimeModel]:
    """
    Derive the paces of gaits on a robot from their limits.

    Parameters
    ----------
    robot_name : str
        Name, or path of a robot data file.
    gaits : sequence of str
        Names, or paths of gait files.

    Returns
    -------
    dict of str to WalkingTimeModel
        By the gaits' names.
    """
    robot = load_robot(robot_name)
    paces = {}
    for name in gaits:
        gait = load_gait(name, robot)
        turning = turning_gait_for(gait, robot)
        walking = MotionLimits(robot, gait)
        gear = walking if turning == gait else MotionLimits(robot, turning)
        paces[Path(name).stem] = pace_of(walking, gear, sweep=sweep_of_turns(robot, gear))
    return paces


def _list(as_json: bool) -> int:
    gaits = [load_gait(name) for name in available_gaits()]
    if as_json:
        print(json.dumps({'gaits': [gait.name for gait in gaits]}))
        return 0
    table = Table('gait', 'kind', 'cycle', 'duty factor', 'order of liftoff')
    for gait in gaits:
        kind = ('static' if gait.is_static else 'dynamic') + (
            ', keeps its speed' if gait.is_steady else ', rests between cycles'
        )
        table.add_row(
            gait.name,
            kind,
            f'{gait.cycle_period:g} s',
            f'{gait.duty_factor("lf"):.2f}',
            ' '.join(swing.leg for swing in gait.swings),
        )
    Console().print(table)
    return 0
