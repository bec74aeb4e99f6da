"""
Part of ``quadwalk bench faults``: the last gate against motions at random.

Cycles of every robot and gait, postures, and both spoiled in many ways are shown to the gate;
what it says is compared with the motion itself, looked at at many instants.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from quad_common.errors import GaitError, TrajectoryError
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_gate import (
    CONTROL_PERIOD,
    OVERSHOOT,
    POSITION_TOLERANCE,
    VELOCITY_TOLERANCE,
    JointLimits,
    check_command,
)
from quad_gait.cycle.body_motion import BodyMotion
from quad_gait.cycle.gait import load_gait
from quad_gait.cycle.gait_generator import generate_cycle
from quad_gait.cycle.posture import posture_trajectory
from quad_lab.tools.criterion import Criterion, at_most, figure

Array = NDArray[np.float64]

_CASES, _QUICK_CASES = 100_000, 2_000

_BASES = 60
"""Number of sound motions of each robot from which cases are made."""

_INSTANTS = 24
"""Number of instants between two points at which the motion is looked at: fewer miss the peaks of
velocity by more than is clear."""

_CLEAR = 1e-3
"""Fraction of a limit by which a motion is beyond it for sure, or within."""


@dataclass
class _GateOutcome:
    """What the gate said."""

    passed: int = 0
    refused: int = 0
    wrongly_passed: list[str] = field(default_factory=list)
    wrongly_refused: list[str] = field(default_factory=list)
    seconds: float = 0.0


def attack_gate(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Show motions to the gate; return bars, and the first wrong answers."""
    rng = np.random.default_rng(seed)
    robots = [load_robot(name) for name in available_robots()]
    count = _QUICK_CASES if quick else _CASES
    outcome = _GateOutcome()
    for robot in robots:
        limits, bases = JointLimits.of(robot), _sound_motions(robot, rng)
        for _ in range(count // len(robots)):
            _try(limits, bases[rng.integers(len(bases))], rng, outcome)
        console.print(f'{robot.name}: {outcome.passed} passed and {outcome.refused} refused')
    for text in (*outcome.wrongly_passed[:10], *outcome.wrongly_refused[:10]):
        console.print(text, highlight=False, markup=False)
    number = outcome.passed + outcome.refused
    bars = [
        figure('motions', number, ''),
        figure('of which refused', outcome.refused, ''),
        at_most('passed though beyond the limits', len(outcome.wrongly_passed), '', 0),
        at_most('refused though within', len(outcome.wrongly_refused), '', 0),
        at_most('mean time of a check', 1e3 * outcome.seconds / number, 'ms', 0.1),
    ]
    return bars, {
        'wrongly_passed': outcome.wrongly_passed[:10],
        'wrongly_refused': outcome.wrongly_refused[:10],
    }


def _sound_motions(robot: Robot, rng: np.random.Generator) -> list[JointTrajectory]:
    """Return cycles in all directions, and motions between postures."""
    motions: list[JointTrajectory] = []
    lower, upper = robot.lower, robot.upper
    while len(motions) < _BASES:
        if rng.random() < 0.3:
            start, end = rng.uniform(lower, upper, (2, *lower.shape))
            motions.append(posture_trajectory(robot, start.reshape(-1), end, 10.0, 1.0, 0.02))
            continue
        gait = load_gait(str(rng.choice(['crawl', 'crab', 'wave', 'trot', 'turn'])), robot)
        motion = rng.uniform(-0.5, 0.5, 3) * robot.largest_stride * [1.0, 0.5, 2.0]
        try:
            cycle = generate_cycle(robot, gait, BodyMotion(*(float(v) for v in motion)))
        except GaitError:
            continue
        motions.append(cycle.trajectory(robot, 10.0))
    return motions


def _try(
    limits: JointLimits, base: JointTrajectory, rng: np.random.Generator, outcome: _GateOutcome
) -> None:
    """Spoil a motion or not, and compare what the gate says with what is true."""
    trajectory = _spoiled(base, limits, rng)
    now = trajectory.stamp + float(rng.uniform(-0.5, 0.3))
    with np.errstate(all='ignore'):
        command = trajectory.positions_at(np.array([now]))[0]
    if rng.random() < 0.3:
        command = limits.clip(command + rng.normal(size=len(command)) * rng.choice([1e-3, 0.3]))
    still = np.zeros_like(command)
    began = time.process_time()
    try:
        check_command(limits, trajectory, now, command, still)
        refusal = ''
    except TrajectoryError as error:
        refusal = str(error)
    outcome.seconds += time.process_time() - began
    outcome.refused += bool(refusal)
    outcome.passed += not refusal
    beyond = _beyond(limits, trajectory, now, command)
    if not refusal and beyond > _CLEAR:
        outcome.wrongly_passed.append(f'beyond by {beyond:.3g} of a limit at {now:.3f} s')
    if refusal and beyond < -_CLEAR:
        outcome.wrongly_refused.append(f'within by {-beyond:.3g} of a limit, but: {refusal}')


def _spoiled(
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


def _beyond(limits: JointLimits, trajectory: JointTrajectory, now: float, command: Array) -> float:
    """Return by what fraction of a limit a motion is beyond it at worst; negative if within."""
    first = trajectory.stamp + float(trajectory.times[0])
    times = trajectory.times
    positions, velocities = trajectory.positions, trajectory.velocities
    worst = [-np.inf]
    if first > now:
        times = np.concatenate([[now - trajectory.stamp], times])
        positions = np.vstack([command, positions])
        velocities = np.vstack([np.zeros_like(command), velocities])
    else:
        with np.errstate(all='ignore'):
            here = trajectory.positions_at(np.array([now]))[0]
        step = np.abs(here - command) / (limits.velocity * CONTROL_PERIOD)
        worst.append(float(step.max()) - 1.0)
    with np.errstate(all='ignore'):
        h = np.diff(times)[:, None]
        a, b = positions[:-1], positions[1:]
        u, v = velocities[:-1] * h, velocities[1:] * h
        for s in np.linspace(0.0, 1.0, _INSTANTS + 1):
            c, d = 3.0 * (b - a) - 2.0 * u - v, u + v - 2.0 * (b - a)
            place = a + s * (u + s * (c + s * d))
            rate = (u + s * (2.0 * c + 3.0 * s * d)) / h
            tolerance = VELOCITY_TOLERANCE if 0.0 < s < 1.0 else 0.0
            most = limits.velocity * (1.0 + tolerance)
            span = limits.upper - limits.lower
            overshoot = OVERSHOOT if 0.0 < s < 1.0 else POSITION_TOLERANCE
            off = np.maximum(limits.lower - place, place - limits.upper) - overshoot
            excess = np.maximum(off / span, np.abs(rate) / most - 1.0)
            worst.append(float(np.nan_to_num(excess, nan=np.inf).max()))
    return max(worst)
