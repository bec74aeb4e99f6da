"""
Part of ``quadwalk bench faults``: the gait falls silent at any instant of a walk.

What was given out last ends at rest: whenever nothing more comes, the robot is to stand on
four feet.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from rich.console import Console

from quad_common.errors import QuadError
from quad_common.planar_pose import Twist2D
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_gait.cycle.gait import load_gait
from quad_lab.closed_loop.closed_loop import ClosedLoop
from quad_lab.closed_loop.controllers import controller_for
from quad_lab.tools.criterion import Criterion, at_least, at_most
from quad_lab.tools.workers import worker_pool

_GAITS = ('crawl', 'wave', 'trot', 'walk')

_WALKS, _QUICK_WALKS = 240, 4
"""Number of walks, each with one instant."""

_STAND, _LATEST = 0.5, 8.0
"""Time before the walk begins, and in which the gait falls silent [s]."""

_CYCLES, _SETTLING = 2.5, 2.0
"""Number of cycles in which the robot is to have come to rest, and time to settle after [s]."""

_STILL = 0.1
"""Speed below which a joint rests [rad/s]."""

_LEVEL = 0.03
"""Fraction of the hips' height by which standing feet are higher than the lowest, at most."""


@dataclass(frozen=True)
class SilencedWalk:
    """What became of a robot whose gait fell silent."""

    robot: str
    gait: str
    instant: float
    """Time of the silence [s]."""
    has_fallen: bool
    """Whether it fell."""
    rests: bool
    """Whether all its joints rest."""
    stands: bool
    """Whether all four feet are on the ground."""

    @property
    def is_safe(self) -> bool:
        """Whether it stands still on four feet."""
        return self.rests and self.stands and not self.has_fallen


def attack_by_silence(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Let gaits fall silent; return bars, and the walks that did not end well."""
    count = _QUICK_WALKS if quick else _WALKS
    walks: list[SilencedWalk] = []
    with worker_pool() as pool:
        for walk in pool.map(_silenced, [(seed, k) for k in range(count)]):
            walks.append(walk)
            if not walk.is_safe:
                console.print(f'{walk}')
    console.print(f'{len(walks)} walks fell silent')
    bars = [
        at_least(f'stands on four feet, of {count}', sum(w.is_safe for w in walks), '', count),
        at_most('falls', sum(w.has_fallen for w in walks), '', 0),
    ]
    return bars, {'unsafe': [asdict(walk) for walk in walks if not walk.is_safe]}


def _silenced(key: tuple[int, int]) -> SilencedWalk:
    """Walk somewhere at random, and fall silent at a random instant."""
    rng = np.random.default_rng(key)
    robot = load_robot(str(rng.choice(available_robots())))
    gait = load_gait(str(rng.choice(_GAITS)), robot)
    controller = controller_for(robot, gait)
    walk = ClosedLoop(robot, controller)
    try:
        walk.run(_STAND)
        fastest = robot.largest_stride / gait.cycle_period
        velocity = rng.uniform(-1.0, 1.0, 3) * fastest * [1.0, 0.5, 2.0]
        instant = float(rng.uniform(0.0, _LATEST))
        walked = 0.0
        while walked < instant:
            # Steering must go on, or the robot would stop by itself.
            controller.set_twist(Twist2D(*(float(v) for v in velocity)))
            walk.run(min(0.5, instant - walked))
            walked += 0.5
        silence = _CYCLES * gait.cycle_period + _SETTLING
        for _ in range(round(silence / walk.simulation.time_step)):
            walk.simulation.step()
            # Falls are noted when they are seen.
            seen = walk.simulation.observe()
            if seen.has_fallen:
                break
        feet = robot.foot_positions(seen.joint_positions.reshape(4, 3))[:, 2]
        return SilencedWalk(
            robot.name,
            gait.name,
            instant,
            walk.simulation.has_fallen,
            bool(np.abs(seen.joint_velocities).max() < _STILL),
            bool(np.ptp(feet) < _LEVEL * robot.hip_height),
        )
    except QuadError:
        return SilencedWalk(robot.name, gait.name, float('nan'), False, False, False)
    finally:
        walk.close()
