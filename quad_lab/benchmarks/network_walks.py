"""
Walks whose simulator is on another host, behind a network that delays packets and loses some.
"""

from __future__ import annotations

import math
import os
from concurrent.futures import as_completed
from dataclasses import asdict, dataclass
from pathlib import Path

from rich.console import Console

from quad_common.errors import QuadError
from quad_common.network.transport import PROFILES, QOS_FROM_PROFILES
from quad_common.planar_pose import Pose2D
from quad_common.resources import sample_map, share_directory
from quad_common.robot_files.robot_file import load_robot
from quad_lab.closed_loop.random_goals import GoalDrawer
from quad_lab.tools.criterion import Criterion, at_least, at_most, figure
from quad_lab.tools.impaired_link import (
    ImpairedLink,
    Impairment,
    NoImpairedLink,
    check_possible,
    on_host,
)
from quad_lab.tools.workers import worker_pool

WALKS, QUICK_WALKS = 20, 1

_AT_ONCE = 4
"""Walks that two processors bear beside one another, in real time."""

_IMPAIRMENT = Impairment(delay=0.02, loss=0.01)

LEAD_TIME = 0.6
"""Of the gait [s]: some trials of a packet, 0.1 s each."""

_NEAREST, _FARTHEST, _QUICK_FARTHEST = 0.2, 0.5, 0.25
"""Distance of goals from the start [m]: walks in real time are to be short."""

_START = Pose2D(2.0, 2.0, 0.0)


@dataclass(frozen=True)
class NetworkWalk:
    """What became of a walk."""

    seed: int
    """Seed of the sensors' noise and of what was lost."""
    arrived: bool
    """Whether the robot got to its goal."""
    late: int
    """Number of trajectories that came after their first point was due."""
    factor: float
    """Simulated over real time: less than 1 where the processors are busy."""
    packets: int
    """Number of packets of IP that were sent, both ways."""
    lost: int
    """Number of those that were lost."""
    problem: str
    """Why it did not arrive; empty if it did."""


def network_bars(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """
    Walk with the simulator on one host, and gait, planner and observer on another.

    Parameters
    ----------
    console : Console
        Where progress goes.
    quick : bool
        A single walk.
    seed : int
        Of the first walk.

    Returns
    -------
    tuple
        The bars, and every walk for JSON.
    """
    count = QUICK_WALKS if quick else WALKS
    try:
        check_possible()
    except NoImpairedLink as error:
        console.print(f'network: not measured: {error}', highlight=False)
        return _bars([], count), {}
    map_file = sample_map()
    goals = GoalDrawer(load_robot('titan_viii'), map_file, seed)
    farthest = _QUICK_FARTHEST if quick else _FARTHEST
    walks: list[NetworkWalk] = []
    with worker_pool(min(_AT_ONCE, count)) as pool:
        waiting = [
            pool.submit(_walk, map_file, goals.draw(_START, _NEAREST, farthest), seed + number)
            for number in range(count)
        ]
        for done in as_completed(waiting):
            walks.append(done.result())
            console.print(_line(walks[-1]), highlight=False)
    walks.sort(key=lambda walk: walk.seed)
    return _bars(walks, count), {'network': [asdict(walk) for walk in walks]}


def _walk(map_file: Path, goal: Pose2D, seed: int) -> NetworkWalk:
    """Walk once, in a worker process."""
    # It needs rclpy, which is asked for nowhere else here.
    from quad_lab.topic_walk.walk import WalkOptions, walk

    os.environ[PROFILES] = str(share_directory() / 'config' / 'fastdds_network.xml')
    os.environ[QOS_FROM_PROFILES] = '1'
    with ImpairedLink(f'quadwalk-{os.getpid()}', _IMPAIRMENT, seed) as link:
        try:
            with on_host(link.hosts[1]):
                options = WalkOptions(
                    map_file, _START, goal, seed=seed, real_time_factor=1.0,
                    lead_time=LEAD_TIME, hosts={'sim_node': link.hosts[0]},
                )  # fmt: skip
                result = walk(options).result()
        except QuadError as error:
            return NetworkWalk(seed, False, 0, math.nan, link.packets, link.lost, str(error))
    factor = result.real_time_factor
    return NetworkWalk(
        seed, result.arrived, result.late_trajectories, math.nan if factor is None else factor,
        link.packets, link.lost, result.problem,
    )  # fmt: skip


def _line(walk: NetworkWalk) -> str:
    end = 'arrived' if walk.arrived else f'DID NOT ARRIVE: {walk.problem}'
    return (
        f'network {walk.seed}: {end}; {walk.late} trajectories late; {walk.lost} of '
        f'{walk.packets} packets lost; {walk.factor:.2f} times real time'
    )


def _bars(walks: list[NetworkWalk], count: int) -> list[Criterion]:
    """Make the bars; without walks nothing could be measured."""
    arrived = sum(walk.arrived for walk in walks) if walks else None
    late = sum(walk.late for walk in walks) if walks else None
    lost = sum(w.lost for w in walks) / sum(w.packets for w in walks) if walks else None
    pace = min(walk.factor for walk in walks) if walks else None
    return [
        at_least(
            'walks that arrive over a network with 20 ms and 1 %', arrived, f'of {count}', count
        ),
        at_most('trajectories that come late there', late, '', 0),
        figure('packets lost there', lost, ''),
        figure('slowest walk there', pace, 'x real time'),
    ]
