"""
``quadwalk calibrate``: measures in simulation how far a gait goes, and what to ask it for.
"""

from __future__ import annotations

import argparse
import json
import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from rich.console import Console
from rich.table import Table

from quad_cli.arguments import output_argument
from quad_cli.direct_walk import DirectWalk, DoesNotWalk
from quad_common.bounded_file import check_target, make_folder
from quad_common.errors import ParameterError
from quad_common.planar_pose import Pose2D
from quad_common.robot import Robot, load_robot
from quad_gait.body_motion import BodyMotion
from quad_gait.gait import Gait, load_gait, turning_gait_for
from quad_gait.motion_limits import MotionLimits
from quad_gait.slip_compensation import (
    QUANTITIES,
    Calibration,
    calibration_file,
    load_compensation,
    save_compensation,
    with_calibrations,
)
from quad_gait.walk_controller import ControllerOptions, WalkController

Array = NDArray[np.float64]

EXAMPLES = """examples:
  quadwalk calibrate --robot cuhk --gait trot
  quadwalk calibrate --robot cuhk --gait trot --motion 0.126,0,18deg --output my.yaml
"""

DIRECTIONS = (
    BodyMotion(forward=1.0),
    BodyMotion(forward=-1.0),
    BodyMotion(left=1.0),
    BodyMotion(left=-1.0),
    BodyMotion(turn=1.0),
    BodyMotion(turn=-1.0),
)
"""Calibrated if nothing else is asked for, each at two speeds."""

SHARES = (0.35, 0.7)
"""Of the largest motion in each direction."""

_SKIPPED = 4
"""First cycles that are not measured, until the robot has gathered speed."""


@dataclass(frozen=True)
class MeasuredMotion:
    """What a gait does, cycle by cycle, when left alone."""

    mean: BodyMotion
    """Of one cycle."""
    spread: float
    """Standard deviation of a cycle's end, about the mean [m]; 1 rad counts as 0.2 m."""
    has_fallen: bool
    """Mean and spread are then of the cycles before, or nan."""


def measure_motion(
    robot: Robot,
    gait: Gait,
    motion: BodyMotion,
    cycles: int = 16,
    backend: str = 'bullet',
) -> MeasuredMotion:
    """
    Walk open loop, and see how far a cycle goes.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    motion : BodyMotion
        What is asked of each cycle.
    cycles : int
        How many are measured, after the first few.
    backend : str
        The simulator.

    Returns
    -------
    MeasuredMotion
        Mean and spread.
    """
    options = ControllerOptions(
        least_margin=0.0, settle_time=0.1, hold_course=False, twist_timeout=math.inf
    )
    controller = WalkController(robot, gait, turning_gait_for(gait, robot), options)
    walk = DirectWalk(robot, controller, backend)
    try:
        walk.run(0.1)
        controller.set_twist(motion.rate(gait.cycle_period))
        walk.run(30.0 + gait.cycle_period, until=lambda: controller.cycle is not None)
        ends: list[Pose2D] = []
        while len(ends) < _SKIPPED + cycles + 1 and not walk.record.has_fallen:
            try:
                ends.append(walk.next_cycle_end())
            except DoesNotWalk:
                if not walk.record.has_fallen:
                    raise
    finally:
        walk.close()
    ends = ends[_SKIPPED:]
    if len(ends) < 2:
        lost = BodyMotion(math.nan, math.nan, math.nan)
        return MeasuredMotion(lost, math.nan, walk.record.has_fallen)
    parts = np.array([_parts(BodyMotion.reaching(a.inverse() @ b)) for a, b in pairwise(ends)])
    mean = BodyMotion(*parts.mean(axis=0).tolist())
    spread = parts.std(axis=0) * (1.0, 1.0, 0.2)
    return MeasuredMotion(mean, float(np.linalg.norm(spread)), walk.record.has_fallen)


def calibrate_motion(
    robot: Robot, gait: Gait, wanted: BodyMotion, rounds: int = 4, cycles: int = 16
) -> tuple[Calibration, MeasuredMotion, MeasuredMotion]:
    """
    Find what to ask a gait for so that it does what is wanted.

    Parameters
    ----------
    robot, gait
        The robot, and a gait fitted to it.
    wanted : BodyMotion
        What one cycle is to do.
    rounds : int
        How often the measured error is taken off what is asked.
    cycles : int
        Measured in each round.

    Returns
    -------
    tuple of Calibration and two MeasuredMotion
        The best that was found, and what the gait did without and with it.
    """
    asked = wanted
    first = best = measure_motion(robot, gait, asked, cycles)
    best_asked = asked
    result = first
    for _ in range(rounds):
        if result.has_fallen:
            break
        error = _parts(wanted) - _parts(result.mean)
        asked = BodyMotion(*(_parts(asked) + error).tolist())
        result = measure_motion(robot, gait, asked, cycles)
        if not result.has_fallen and _error(result, wanted) < _error(best, wanted):
            best, best_asked = result, asked
    return Calibration(gait.name, gait.cycle_period, wanted, best_asked), first, best


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the command's arguments."""
    parser.add_argument('--robot', default='titan_viii', help='name, or path of a robot data file')
    parser.add_argument('--gait', default='trot', help='name of a gait, or path of a gait file')
    parser.add_argument(
        '--motion',
        action='append',
        metavar='F,L,T',
        help='forward and left [m] and turn [rad, or deg] of one cycle; may be repeated; '
        'left out: six directions at two speeds',
    )
    parser.add_argument(
        '--output', type=output_argument, help='file to write; beside the robot if left out'
    )
    parser.add_argument('--json', action='store_true', help='print one JSON object only')


def run(arguments: argparse.Namespace) -> int:
    """Run the command; return 0 if every motion came out within 2 %."""
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
                'wanted': _parts(wanted).tolist(),
                'without': _parts(before.mean).tolist(),
                'with': _parts(after.mean).tolist(),
                'asked': _parts(calibration.asked).tolist(),
                'share_off': _error(after, wanted) / _size(wanted),
            }
        )
        console.print(f'{texts[0]}: {texts[1]} without, {texts[2]} with compensation')
    make_folder(path.parent)
    heading = (
        f'Slip compensation of {robot.name}: forward and left [m], turn [rad] of one cycle.\n'
        f'Written by: quadwalk calibrate (PyBullet)'
    )
    save_compensation(with_calibrations(known, found), path, heading)
    if arguments.json:
        print(json.dumps({'file': str(path), 'motions': rows}))
    else:
        console.print(table)
        console.print(f'written to {path}')
    return 0 if all(row['share_off'] < 0.02 for row in rows) else 1


def default_motions(robot: Robot, gait: Gait) -> list[BodyMotion]:
    """Return the six directions at two speeds that the gait is capable of."""
    limits = MotionLimits(robot, gait)
    return [
        _rounded(direction.scaled(share * limits.largest_share(direction)))
        for direction in DIRECTIONS
        for share in SHARES
    ]


def _check_reach(robot: Robot, gait: Gait, motions: list[BodyMotion]) -> None:
    """Refuse what the gait cannot do anyway, before anything is walked."""
    turning_gait = turning_gait_for(gait, robot)
    for motion in motions:
        is_turn = not (motion.forward or motion.left)
        limits = MotionLimits(robot, turning_gait if is_turn else gait)
        share = limits.largest_share(motion)
        if share < 1.0:
            raise ParameterError(
                'motion',
                _text(motion),
                f'no more than {_text(motion.scaled(share))} (mm, mm, degrees) a cycle for the '
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
    if not all(math.isfinite(part) for part in _parts(motion)) or not np.any(_parts(motion)):
        raise ParameterError('motion', text, 'finite, and not zero')
    for name, quantity in QUANTITIES.items():
        quantity.check(f'motion.{name}', getattr(motion, name))
    return motion


def _parts(motion: BodyMotion) -> Array:
    return np.array([motion.forward, motion.left, motion.turn])


def _rounded(motion: BodyMotion) -> BodyMotion:
    return BodyMotion(*(round(part, 4) for part in _parts(motion).tolist()))


def _size(motion: BodyMotion) -> float:
    return math.hypot(motion.forward, motion.left, 0.2 * motion.turn)


def _error(measured: MeasuredMotion, wanted: BodyMotion) -> float:
    mean = measured.mean
    return math.hypot(
        mean.forward - wanted.forward, mean.left - wanted.left, 0.2 * (mean.turn - wanted.turn)
    )


def _text(motion: BodyMotion) -> str:
    return f'{1e3 * motion.forward:.1f}, {1e3 * motion.left:.1f}, {math.degrees(motion.turn):.2f}'
