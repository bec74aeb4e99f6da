"""
Part of ``quadwalk bench faults``: what the joints are commanded, whatever trajectories come.

Motions at random, sound and spoiled, cut short, stamped for the past or the future, reach a
simulator one upon another, some of them through the last gate as well. At every step its commands
must stay within the joints' range and speed, and be what the gate remembers to have commanded.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from rich.console import Console

from quad_common.errors import TrajectoryError
from quad_common.planar_pose import Pose2D
from quad_common.robot.robot import Robot
from quad_common.robot_files.robot_file import available_robots, load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_gate import OVERSHOOT, VELOCITY_TOLERANCE, JointLimits
from quad_gait.faults.command_gate import CommandGate
from quad_lab.attacks.walks.motions import sound_motions, spoiled
from quad_lab.tools.criterion import Criterion, at_most, figure
from quad_sim.engines.kinematic_simulator import KinematicSimulator
from quad_sim.simulation import Simulation

Array = NDArray[np.float64]

_TRAJECTORIES, _QUICK_TRAJECTORIES = 40_000, 800

_IN_A_ROW = 25
"""Number of trajectories that one robot gets upon another."""

_WAITS = (0.005, 0.05, 0.3, 1.0)
"""Longest times until the next one comes, as in a balanced trot, or in a walk by cycles [s]."""

_ROUNDING = 1e-4
"""Difference between two commands that is no jump, as for the executor [rad]."""


@dataclass
class _ExecutionOutcome:
    """What the joints were commanded."""

    accepted: int = 0
    refused: int = 0
    late: int = 0
    out_of_range: list[str] = field(default_factory=list)
    too_fast: list[str] = field(default_factory=list)
    unlike_the_gate: list[str] = field(default_factory=list)


def attack_execution(
    console: Console, quick: bool, seed: int
) -> tuple[list[Criterion], dict[str, object]]:
    """Send trajectories upon one another; return bars, and the first wrong commands."""
    rng = np.random.default_rng(seed)
    robots = [load_robot(name) for name in available_robots()]
    count = _QUICK_TRAJECTORIES if quick else _TRAJECTORIES
    outcome = _ExecutionOutcome()
    for robot in robots:
        motions = sound_motions(robot, rng)
        for number in range(count // len(robots) // _IN_A_ROW):
            _send_in_a_row(robot, motions, rng, outcome, is_gated=number % 2 == 1)
        console.print(f'{robot.name}: {outcome.accepted} executed and {outcome.refused} refused')
    wrong = (*outcome.out_of_range, *outcome.too_fast, *outcome.unlike_the_gate)
    for text in wrong[:10]:
        console.print(text, highlight=False, markup=False)
    bars = [
        figure('trajectories executed', outcome.accepted, ''),
        figure('of which late', outcome.late, ''),
        figure('refused', outcome.refused, ''),
        at_most('commands out of range', len(outcome.out_of_range), '', 0),
        at_most('commands too fast', len(outcome.too_fast), '', 0),
        at_most('commands that the gate does not know', len(outcome.unlike_the_gate), '', 0),
    ]
    return bars, {'wrong': list(wrong[:10])}


def _send_in_a_row(
    robot: Robot,
    motions: list[JointTrajectory],
    rng: np.random.Generator,
    outcome: _ExecutionOutcome,
    is_gated: bool,
) -> None:
    """Let one robot execute trajectories, each for a while."""
    simulation = Simulation(KinematicSimulator(robot), robot, Pose2D(0.0, 0.0, 0.0))
    limits = JointLimits.of(robot)
    gate = CommandGate(robot) if is_gated else None
    command = simulation.commanded
    for _ in range(_IN_A_ROW):
        trajectory = _arriving(motions, limits, simulation.time, rng)
        try:
            with np.errstate(all='ignore'):
                if gate is not None:
                    trajectory = gate.admit(trajectory, simulation.time, simulation.commanded)
                late = simulation.late_trajectories
                simulation.accept(trajectory)
            outcome.accepted += 1
            outcome.late += simulation.late_trajectories - late
        except TrajectoryError:
            outcome.refused += 1
        wait = float(rng.choice(_WAITS)) * rng.uniform(0.3, 1.0)
        end = simulation.time + wait
        while simulation.time < end:
            last = command
            simulation.step()
            command = simulation.commanded
            known = command if gate is None else gate.command(simulation.time, command)[0]
            _judge(simulation, limits, last, command, known, outcome)


def _arriving(
    motions: list[JointTrajectory], limits: JointLimits, now: float, rng: np.random.Generator
) -> JointTrajectory:
    """Return a motion, spoiled or sound, whole or its rest, with any stamp."""
    trajectory = motions[rng.integers(len(motions))]
    if rng.random() < 0.4:
        trajectory = spoiled(trajectory, limits, rng)
    first = int(rng.integers(len(trajectory.times) - 1)) if rng.random() < 0.5 else 0
    lead = float(rng.choice([0.0, 0.02, 0.2, 0.8]))
    stamp = 0.0 if rng.random() < 0.1 else max(1e-3, now + rng.uniform(-0.6, 0.4))
    return replace(
        trajectory,
        stamp=float(stamp),
        times=trajectory.times[first:] - trajectory.times[first] + lead,
        positions=trajectory.positions[first:],
        velocities=trajectory.velocities[first:],
    )


def _judge(
    simulation: Simulation,
    limits: JointLimits,
    last: Array,
    command: Array,
    known: Array,
    outcome: _ExecutionOutcome,
) -> None:
    """Compare the command of a step with limits, the last step's, and what the gate knows."""
    robot = simulation.robot
    beyond = np.maximum(limits.lower - command, command - limits.upper)
    if not np.all(beyond <= OVERSHOOT + _ROUNDING):
        outcome.out_of_range.append(f'{robot.name}: {np.max(beyond):.3g} rad out of range')
    furthest, moved = limits.velocity * simulation.time_step, np.abs(command - last)
    if not np.all(moved <= (1.0 + VELOCITY_TOLERANCE) * furthest + _ROUNDING):
        speed = np.max(moved / furthest)
        outcome.too_fast.append(f'{robot.name}: {speed:.3g} of the largest speed')
    apart = np.max(np.abs(known - command))
    if not apart <= _ROUNDING:
        outcome.unlike_the_gate.append(f'{robot.name}: {apart:.3g} rad from what passed the gate')
