"""
``quadwalk calibrate``: measures in simulation how far a gait goes, and what to ask it for.
"""

from __future__ import annotations

import argparse
import json
import math

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from quad_cli.arguments import output_argument
from quad_common.errors import ParameterError
from quad_common.files.bounded_file import check_target, make_folder
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import Gait, load_gait, turning_gait_for
from quad_gait.cycle.motion_limits import MotionLimits
from quad_gait.following.slip_compensation import (
    QUANTITIES,
    calibration_file,
    load_compensation,
    save_compensation,
    with_calibrations,
)
from quad_lab.closed_loop.calibration import (
    calibrate_motion,
    default_motions,
    motion_error,
    motion_size,
    vector,
)
from quad_sim.engines.registry import AUTO, engines_with, preferred, resolved

Array = NDArray[np.float64]

_LEAST_STEP, _LEAST_TURN = 1e-3, math.radians(0.1)
"""What a motion has at least, one or the other [m, rad]: in a file it is rounded to 1e-6."""

EXAMPLES = """examples:
  quadwalk calibrate --robot cuhk --gait trot
  quadwalk calibrate --robot cuhk --gait trot --backend mujoco --output cuhk_mujoco.yaml
  quadwalk calibrate --robot cuhk --gait trot --motion 0.126,0,18deg --output my.yaml
"""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument(
        '--robot', default='titan_viii', help='name of a robot, or path of a data file'
    )
    parser.add_argument('--gait', default='trot', help='name of a gait, or path of a gait file')
    parser.add_argument(
        '--motion',
        action='append',
        metavar='F,L,T',
        help='forward and left [m] and turn [rad, or deg] of one cycle; may be repeated; '
        'left out: six directions at two speeds',
    )
    parser.add_argument(
        '--backend', choices=engines_with('has_world'), help='physics, in place of the usual ones'
    )
    parser.add_argument(
        '--output', type=output_argument, help='file to write; beside the robot if left out'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if every motion came out within 2 %."""
    with preferred(arguments.backend or resolved(AUTO)):
        return _calibrate(arguments)


def _calibrate(arguments: argparse.Namespace) -> int:
    console = Console(stderr=arguments.json)
    robot = load_robot(arguments.robot)
    gait = load_gait(arguments.gait, robot)
    path = arguments.output or calibration_file(arguments.robot)
    # Before the walks, which take minutes.
    check_target(path, 'calibration file')
    known = load_compensation(path)
    motions = [_motion(text) for text in arguments.motion or ()] or default_motions(robot, gait)
    _check_reach(robot, gait, motions)
    table = Table('wanted [mm, mm, deg]', 'without', 'with', 'asked')
    found = []
    rows = []
    for wanted in motions:
        calibration, before, after = calibrate_motion(robot, gait, wanted)
        found.append(calibration)
        texts = [_text(m) for m in (wanted, before.mean, after.mean, calibration.asked)]
        table.add_row(*texts)
        rows.append(
            {
                'wanted': vector(wanted).tolist(),
                'without': vector(before.mean).tolist(),
                'with': vector(after.mean).tolist(),
                'asked': vector(calibration.asked).tolist(),
                'fraction_off': motion_error(after, wanted) / motion_size(wanted),
            }
        )
        console.print(f'{texts[0]}: {texts[1]} without, {texts[2]} with compensation')
    make_folder(path.parent)
    heading = (
        f'Slip compensation of {robot.name}: forward and left [m], turn [rad] of one cycle.\n'
        f'Written by: quadwalk calibrate --backend {resolved(AUTO)}'
    )
    save_compensation(with_calibrations(known, found), path, heading)
    if arguments.json:
        print(json.dumps({'file': str(path), 'motions': rows}))
    else:
        console.print(table)
        console.print(f'written to {path}')
    return 0 if all(row['fraction_off'] < 0.02 for row in rows) else 1


def _check_reach(robot: Robot, gait: Gait, motions: list[BodyMotion]) -> None:
    """Refuse what the gait cannot do anyway, before anything is walked."""
    turning_gait = turning_gait_for(gait, robot)
    for motion in motions:
        is_turn = not (motion.forward or motion.left)
        limits = MotionLimits(robot, turning_gait if is_turn else gait)
        scale = limits.largest_scale(motion)
        if scale < 1.0:
            raise ParameterError(
                'motion',
                _text(motion),
                f'no more than {_text(motion.scaled(scale))} (mm, mm, degrees) a cycle for the '
                f'{gait.name} gait: {limits.reason(motion)}',
            )


def _motion(text: str) -> BodyMotion:
    parts = text.split(',')
    try:
        forward, left = (float(part) for part in parts[:2])
        (turn,) = parts[2:]
        degrees = turn.endswith('deg')
        angle = float(turn[:-3] if degrees else turn)
    except ValueError:
        raise ParameterError('motion', text, 'three numbers: forward, left, turn') from None
    motion = BodyMotion(forward, left, math.radians(angle) if degrees else angle)
    if not all(math.isfinite(part) for part in vector(motion)) or not np.any(vector(motion)):
        raise ParameterError('motion', text, 'finite, and not zero')
    if math.hypot(motion.forward, motion.left) < _LEAST_STEP and abs(motion.turn) < _LEAST_TURN:
        raise ParameterError('motion', text, 'at least 1 mm far, or a turn of at least 0.1 deg')
    for name, quantity in QUANTITIES.items():
        quantity.check(f'motion.{name}', getattr(motion, name))
    return motion


def _text(motion: BodyMotion) -> str:
    return f'{1e3 * motion.forward:.1f}, {1e3 * motion.left:.1f}, {math.degrees(motion.turn):.2f}'
