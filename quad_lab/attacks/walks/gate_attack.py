"""
Part of ``quadwalk bench faults``: the last gate against motions at random.

Cycles of every robot and gait, postures, and both spoiled in many ways are shown to the gate;
what it says is compared with the motion itself, looked at at many instants.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from quad_common.errors import TrajectoryError
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
from quad_lab.attacks.walks.motions import sound_motions, spoiled
from quad_lab.tools.criterion import Criterion, at_most, figure

Array = NDArray[np.float64]

_CASES, _QUICK_CASES = 100_000, 2_000

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
        limits, bases = JointLimits.of(robot), sound_motions(robot, rng)
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


def _try(
    limits: JointLimits, base: JointTrajectory, rng: np.random.Generator, outcome: _GateOutcome
) -> None:
    """Spoil a motion or not, and compare what the gate says with what is true."""
    trajectory = spoiled(base, limits, rng)
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
