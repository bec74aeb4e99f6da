"""
Motions at random for the attacks on what the joints are commanded: sound ones, and spoiled ones.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from quad_common.errors import GaitError
from quad_common.robot.robot import Robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.cycle.posture import posture_trajectory

_MOTIONS = 60
"""Number of sound motions of each robot from which cases are made."""


def sound_motions(robot: Robot, rng: np.random.Generator) -> list[JointTrajectory]:
    """Return cycles in all directions, and motions between postures."""
    motions: list[JointTrajectory] = []
    lower, upper = robot.lower, robot.upper
    while len(motions) < _MOTIONS:
        if rng.random() < 0.3:
            start, end = rng.uniform(lower, upper, (2, *lower.shape))
            motions.append(posture_trajectory(robot, start.reshape(-1), end, 10.0, 1.0, 0.02))
            continue
        gait = load_gait(str(rng.choice(['crawl', 'crab', 'wave', 'trot', 'walk', 'turn'])), robot)
        motion = rng.uniform(-0.5, 0.5, 3) * robot.largest_stride * [1.0, 0.5, 2.0]
        try:
            cycle = generate_cycle(robot, gait, BodyMotion(*(float(v) for v in motion)))
        except GaitError:
            continue
        motions.append(cycle.trajectory(robot, 10.0))
    return motions


def spoiled(
    base: JointTrajectory, limits: JointLimits, rng: np.random.Generator
) -> JointTrajectory:
    """Change a motion in one of many ways, or not at all."""
    positions, velocities, times = base.positions.copy(), base.velocities.copy(), base.times
    row, joint = rng.integers(len(times)), rng.integers(positions.shape[1])
    kind = rng.integers(7)
    if kind == 1:
        positions[row, joint] += rng.choice([0.02, 0.5, 7.85, 1e30, -1e308])
    elif kind == 2:
        velocities[row, joint] *= rng.choice([1.5, 30.0, 1e300])
    elif kind == 3:
        times = times * rng.uniform(0.2, 1.0)
    elif kind == 4:
        span = limits.upper[joint] - limits.lower[joint]
        positions[:, joint] += rng.uniform(-0.6, 0.6) * span
    elif kind == 5:
        velocities = rng.normal(size=velocities.shape) * limits.velocity * rng.choice([0.05, 0.5])
    elif kind == 6:
        kept = np.sort(rng.choice(len(times), max(2, len(times) // 8), replace=False))
        positions, velocities, times = positions[kept], velocities[kept], times[kept]
    return replace(base, positions=positions, velocities=velocities, times=times)
