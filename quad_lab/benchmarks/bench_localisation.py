"""
``quadwalk bench localisation``: walks to goals on a map by odometry that drifts and a localiser.
"""

from __future__ import annotations

import math
import time
from pathlib import Path

from rich.console import Console

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_lab.benchmarks.bench_walk import draw_pairs
from quad_lab.closed_loop.localised_walk import LocalisedRecord, LocalisedWalk
from quad_lab.tools.benchmark_maps import benchmark_maps
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.topic_walk.walk import WalkOptions, walk
from quad_lab.topic_walk.walk_record import WalkResult
from quad_sim.simulated_localisation import LocalisationOptions

WALKS = 20
WALKS_OVER_TOPICS = 2
LONGEST = 5.0
"""Longest path of a walk [m]."""
QUICK_WALKS = 2
QUICK_LENGTH = 1.2
"""Longest path of the quick sample [m]."""
QUICK_BUDGET = 20.0
"""The quick sample begins no further walk after so long [s]."""

DRIFT = 0.03
"""Drift of odometry as a fraction of the distance."""
RATE = 1.0
"""Corrections in a second [Hz]."""
NOISE = 0.02
"""Standard deviation of each correction's position [m]."""
HEADING_NOISE = 0.01
"""Standard deviation of each correction's heading [rad]."""

_ROBOT = 'titan_viii'

_WORST_SPEED = 0.01
"""A robot slower than this over its whole path is given up [m/s]."""


def measure(console: Console, quick: bool, seed: int) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk without topics and over topics, and work out the bars.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        Only a few short walks.
    seed : int
        Of the poses, the drift and the noise.

    Returns
    -------
    tuple
        The bars, and details for JSON: every walk's figures.
    """
    count, longest = (QUICK_WALKS, QUICK_LENGTH) if quick else (WALKS, LONGEST)
    budget = QUICK_BUDGET if quick else math.inf
    pairs = draw_pairs(load_robot(_ROBOT), benchmark_maps(), count, longest, seed)
    records = measure_drift(console, pairs, seed, budget)
    over_topics = walk_over_topics(console, pairs[: 0 if quick else WALKS_OVER_TOPICS], seed)
    details: dict[str, object] = {
        'quick': quick,
        'seed': seed,
        'walks': [as_dict(record) for record in records],
        'walks_over_topics': [result.as_dict() for result in over_topics],
    }
    return bars_of(records, over_topics), details


def as_dict(record: LocalisedRecord) -> dict[str, object]:
    """Return a walk's figures as JSON has them."""
    return {**vars(record), 'contacts': sorted(record.contacts)}


def measure_drift(
    console: Console, pairs: list[tuple[Path, Pose2D, Pose2D]], seed: int, budget: float = math.inf
) -> list[LocalisedRecord]:
    """
    Walk without topics.

    Parameters
    ----------
    console : Console
        Where progress goes.
    pairs : list of (Path, Pose2D, Pose2D)
        Map, start and goal of each walk.
    seed : int
        Of the first walk's drift and noise; each walk has its own.
    budget : float
        No further walk is begun after so long on the wall clock [s].

    Returns
    -------
    list of LocalisedRecord
        One a walk.
    """
    robot = load_robot(_ROBOT)
    records: list[LocalisedRecord] = []
    began = time.monotonic()
    for number, (path, start, goal) in enumerate(pairs):
        if records and time.monotonic() - began > budget:
            break
        options = LocalisationOptions(DRIFT, RATE, NOISE, HEADING_NOISE, seed + number)
        one = LocalisedWalk(robot, path, start, goal, options)
        try:
            record = one.run(120.0 + start.distance_to(goal) * 3.0 / _WORST_SPEED)
        finally:
            one.close()
        records.append(record)
        console.print(
            f'{number + 1}/{len(pairs)} {path.stem}: {record.reason}; '
            f'{1e3 * record.position_error:.0f} mm and {math.degrees(record.heading_error):.1f} '
            f'degrees off in the map, odometry {1e3 * record.odometry_error:.0f} mm; '
            f'{record.duration:.0f} s simulated, {record.plans} plans',
            highlight=False,
        )
    return records


def walk_over_topics(
    console: Console, pairs: list[tuple[Path, Pose2D, Pose2D]], seed: int
) -> list[WalkResult]:
    """Walk with the nodes as processes; arguments as of :func:`measure_drift`."""
    results = []
    for number, (path, start, goal) in enumerate(pairs):
        options = WalkOptions(
            map_file=path,
            start=start,
            goal=goal,
            robot=_ROBOT,
            seed=seed + number,
            odom_drift=DRIFT,
            localiser_rate=RATE,
        )
        result = walk(options).result()
        results.append(result)
        outcome = 'arrived' if result.arrived else f'did not arrive: {result.problem}'
        console.print(
            f'over topics {number + 1}/{len(pairs)} {path.stem}: {outcome}, '
            f'{1e3 * (result.position_error or math.nan):.0f} mm off in the map',
            highlight=False,
        )
    return results


def bars_of(records: list[LocalisedRecord], over_topics: list[WalkResult]) -> list[Criterion]:
    """Work out the bars of walks without and with topics."""
    errors = [record.position_error for record in records]
    bars = [
        at_least(
            'walks that arrived',
            sum(record.has_arrived for record in records),
            f'of {len(records)}',
            len(records),
        ),
        at_most('largest final position error in the map', max(errors), 'm', 0.05),
        at_most(
            'largest final heading error',
            math.degrees(max(record.heading_error for record in records)),
            'deg',
            5.0,
        ),
        at_most('walks with contacts', sum(bool(record.contacts) for record in records), '', 0),
        figure('mean final position error in the map', sum(errors) / len(errors), 'm'),
        figure(
            'largest error of the pose on the way',
            max(record.largest_pose_error for record in records),
            'm',
        ),
        figure(
            'largest error of odometry at the end',
            max(record.odometry_error for record in records),
            'm',
        ),
    ]
    if over_topics:
        worst = [result.position_error for result in over_topics]
        bars += [
            at_least(
                'walks over topics that arrived',
                sum(result.arrived for result in over_topics),
                f'of {len(over_topics)}',
                len(over_topics),
            ),
            at_most(
                'largest final position error over topics',
                None if None in worst else max(e for e in worst if e is not None),
                'm',
                0.05,
            ),
        ]
    return bars
