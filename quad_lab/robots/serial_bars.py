"""
Robots with legs of any axes: imported, compared with engines, and walked.
"""

from __future__ import annotations

import math
import tempfile
from dataclasses import asdict
from pathlib import Path
from typing import Any

from rich.console import Console

from quad_common.importing.options import ImportOptions
from quad_common.importing.robot_document import write_robot
from quad_common.importing.robot_import import import_robot
from quad_common.robot_files.robot_file import load_robot
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.motion_limits import MotionLimits
from quad_lab.closed_loop.gait_measures import steady_walk
from quad_lab.robots.import_check import check_description
from quad_lab.robots.imported_walks import DIRECTIONS, ImportedWalk, walk_imported
from quad_lab.robots.serial_robots import BUILDS, serial_urdf
from quad_lab.tools.criterion import Criterion, at_least, at_most
from quad_lab.tools.workers import worker_pool
from quad_sim.engines.registry import ENGINES

_FRACTION = 0.6
"""Part of the most that is walked."""

_GAITS = ('crawl', 'trot')


def write_serial_robot(build: str, folder: Path) -> Path:
    """Write a robot's description, import it, and return its data file."""
    description = folder / f'{build}.urdf'
    description.write_text(serial_urdf(build), encoding='utf-8')
    return write_robot(import_robot(description), folder / f'{build}.yaml')[0]


def serial_bars(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], list[dict[str, Any]]]:
    """
    Import robots whose legs have no closed formulas, and let them walk.

    Parameters
    ----------
    console : Console
        Where walks are shown.
    quick : bool
        One robot forward.
    seed : int
        Of the postures that are compared.
    """
    builds = tuple(BUILDS)[:1] if quick else tuple(BUILDS)
    engines = [name for name, e in ENGINES.items() if e.has_world and e.is_installed]
    directions = ('forward',) if quick else tuple(DIRECTIONS)
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        files = [str(write_serial_robot(build, folder)) for build in builds]
        checks = [
            check
            for k, build in enumerate(builds)
            for check in check_description(
                build, folder / f'{build}.urdf', ImportOptions(), seed + k
            )
        ]
        jobs = [
            (file, gait, direction, engine, _FRACTION)
            for file in files
            for gait in _GAITS
            for direction in directions
            for engine in engines
        ]
        with worker_pool() as pool:
            walks = list(pool.map(walk_imported, *zip(*jobs)))
    for walk in walks:
        said = walk.problem or f'off by {100.0 * walk.error:.2f} %'
        said += ', FELL' if walk.has_fallen else ''
        console.print(
            f'{Path(walk.robot).stem} {walk.gait} {walk.direction} ({walk.backend}): {said}'
        )
    return _bars(checks, walks), [asdict(walk) for walk in walks]


def _bars(checks: list[Any], walks: list[ImportedWalk]) -> list[Criterion]:
    walked = [walk for walk in walks if not walk.problem]
    tilts = [math.degrees(walk.tilt_rms) for walk in walked]
    return [
        at_most('legs of any axes: feet off', max(c.foot for c in checks), 'm', 1e-5),
        at_most(
            'legs of any axes: centers of mass off',
            max(c.center for c in checks),
            'm',
            1e-3,
        ),
        at_least(f'legs of any axes: walks, of {len(walks)}', len(walked), '', len(walks)),
        at_most('legs of any axes: falls', sum(walk.has_fallen for walk in walks), '', 0),
        at_most(
            'legs of any axes: distance off',
            max((abs(walk.error) for walk in walked), default=None),
            '',
            0.02,
        ),
        at_most('legs of any axes: tilt, rms', max(tilts, default=None), 'deg', 1.5),
    ]


def crawl_forward(file: Path, duration: float) -> float:
    """
    Let a robot crawl, and return what it walked beside what was asked for, as a fraction less 1.

    Parameters
    ----------
    file : Path
        Data file of the robot.
    duration : float
        [s]
    """
    robot = load_robot(file)
    gait = load_gait('crawl', robot)
    motion = DIRECTIONS['forward']
    asked = motion.scaled(_FRACTION * MotionLimits(robot, gait, 0.005).largest_scale(motion))
    walk = steady_walk(robot, gait, motion, duration, asked)
    assert not walk.has_fallen
    return walk.done.forward / walk.asked.forward - 1.0
