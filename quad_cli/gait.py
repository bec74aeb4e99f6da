"""
``quadwalk gait``: lists the gaits, or checks one on a robot.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import asdict

from rich.console import Console
from rich.table import Table

from quad_cli.arguments import finite_argument
from quad_common.robot import load_robot
from quad_gait.gait import available_gaits, load_gait
from quad_gait.gait_check import check_gait

EXAMPLES = """examples:
  quadwalk gait list
  quadwalk gait check wave --robot genibo
  quadwalk gait check my_gait.yaml --robot my_robot.yaml --json
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    actions = parser.add_subparsers(dest='action', metavar='action', required=True)
    listing = actions.add_parser('list', help='list the gaits that ship')
    listing.add_argument('--json', action='store_true', help='print one JSON object only')
    checking = actions.add_parser('check', help='say what a gait can do, and what is wrong with it')
    checking.add_argument('gait', help='name of a gait, or path of a gait file')
    checking.add_argument('--robot', default='titan_viii', help='name, or path of a data file')
    checking.add_argument(
        '--least-margin',
        type=finite_argument,
        default=0.0,
        help='of static gaits, 0 if left out [m]',
    )
    checking.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if nothing is wrong."""
    if arguments.action == 'list':
        return _list(arguments.json)
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
    for problem in report.problems:
        console.print(f'wrong: {problem}', soft_wrap=True)
    return 1 if report.problems else 0


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
