"""Whatever happens to trajectories on their way, sound joints are sound; failed ones are named."""

from __future__ import annotations

import contextlib
import math
from collections import deque
from dataclasses import replace

import numpy as np
import pytest

from quad_common.errors import TrajectoryError
from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_gait.faults.command_tracker import CommandTracker
from quad_gait.faults.joint_fault_detector import JointFaultDetector
from quad_gait.faults.joint_path import JointPath

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
STEP = 0.02
CYCLE = 0.6
STOP = 0.4
AHEAD = 0.25


def on_the_way(times: np.ndarray, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return positions and velocities of legs that swing to and fro, each (m, 12)."""
    rate = 2.0 * math.pi / CYCLE
    turned = rate * times[:, None] + phases
    grown = np.clip(times[:, None], 0.0, 1.0)
    size = 0.25 * grown**2 * (3.0 - 2.0 * grown)
    speed = 0.25 * 6.0 * grown * (1.0 - grown)
    return (
        POSTURE + size * np.sin(turned),
        size * rate * np.cos(turned) + speed * np.sin(turned),
    )


def piece(begin: float, end: float, phases: np.ndarray, stamp: float) -> JointTrajectory:
    """Return a part of that motion, with a stop after it."""
    times = np.append(np.arange(begin, end - 1e-9, STEP), end)
    positions, velocities = on_the_way(times, phases)
    stop = positions[-1] + 0.3 * STOP * velocities[-1]
    return JointTrajectory(
        ROBOT.joint_names,
        stamp,
        np.append(times, end + STOP) - (stamp or begin - 0.06),
        np.vstack([positions, stop]),
        np.vstack([velocities, np.zeros(12)]),
    )


class Robot:
    """Twelve drives with a lag, behind a network that keeps trajectories waiting or loses them."""

    def __init__(self, seed: int, lateness: float = 0.0, lost: float = 0.0, stamped: bool = True):
        self.rng = np.random.default_rng(seed)
        self.phases = self.rng.uniform(0.0, 2.0 * math.pi, 12)
        self.lateness, self.lost, self.stamped = lateness, lost, stamped
        self.watch = JointFaultDetector(ROBOT)
        self.executor = TrajectoryExecutor(ROBOT.joint_names, POSTURE)
        self.joints = POSTURE.copy()
        self.bias = self.rng.uniform(-0.02, 0.02, 12)
        self.lag = self.rng.uniform(0.002, 0.01, 12)
        self.time = 0.0
        self.under_way: deque[tuple[float, JointTrajectory]] = deque()
        self.commanded = POSTURE

    def give(self, trajectory: JointTrajectory) -> None:
        self.watch.expect(trajectory, self.time)
        if self.rng.random() < self.lost:
            return
        late = self.rng.uniform(0.0, self.lateness) if self.rng.random() < 0.4 else 0.0
        arrival = self.time + late
        if self.under_way:
            arrival = max(arrival, self.under_way[-1][0])
        self.under_way.append((arrival, trajectory))

    def advance(self) -> None:
        """Let a step of time pass."""
        for _ in range(4):
            while self.under_way and self.under_way[0][0] <= self.time:
                with contextlib.suppress(TrajectoryError):
                    self.executor.accept(self.under_way.popleft()[1], self.time)
            self.time += STEP / 4.0
            self.commanded, _ = self.executor.command(self.time)
            fraction = 1.0 - np.exp(-STEP / 4.0 / self.lag)
            self.joints = self.joints + fraction * (self.commanded - self.joints)

    def walk(self, seconds: float, spoil=lambda time, joints: (joints, np.full(12, 20.0))):
        """Walk, and return the first fault."""
        given = 0
        while self.time < seconds:
            if self.time >= 0.5 + given * CYCLE:
                begin = max(self.time - 0.5, given * CYCLE)
                stamp = self.time + (0.3 if given == 0 else AHEAD) if self.stamped else 0.0
                trajectory = piece(begin, (given + 1) * CYCLE + AHEAD, self.phases, 0.0)
                if self.stamped:
                    trajectory = JointTrajectory(
                        trajectory.joint_names,
                        stamp,
                        trajectory.times - trajectory.times[0],
                        trajectory.positions,
                        trajectory.velocities,
                    )
                self.give(trajectory)
                given += 1
            self.advance()
            noisy = self.joints + self.bias + self.rng.normal(0.0, 0.003, 12)
            measured, efforts = spoil(self.time, noisy)
            fault = self.watch.update(self.time, measured, efforts)
            if fault is not None:
                return fault
        return None


@pytest.mark.parametrize('seed', range(4))
@pytest.mark.parametrize('stamped', [True, False])
def test_a_sound_robot_on_a_quiet_machine_is_sound_and_follows(seed, stamped):
    robot = Robot(seed, stamped=stamped)
    assert robot.walk(12.0) is None
    assert robot.watch.unfollowed < 0.2
    assert robot.watch.late < 0.2


@pytest.mark.sweep(kept=8)
@pytest.mark.parametrize('seed', range(8))
@pytest.mark.parametrize('stamped', [True, False])
@pytest.mark.parametrize('lost', [0.0, 0.3])
def test_trajectories_that_come_late_or_never_are_no_faults(seed, stamped, lost):
    robot = Robot(seed, lateness=2.0, lost=lost, stamped=stamped)
    assert robot.walk(12.0) is None
    if stamped:
        # Without a stamp nobody is late.
        assert robot.watch.late > 0.5


@pytest.mark.sweep(kept=8)
@pytest.mark.parametrize('seed', range(6))
@pytest.mark.parametrize('stamped', [True, False])
@pytest.mark.parametrize('lateness', [0.0, 0.5])
def test_joints_that_need_next_to_no_torque_are_sound(seed, stamped, lateness):
    robot = Robot(seed, lateness=lateness, lost=0.1 if lateness else 0.0, stamped=stamped)
    bearing = robot.rng.random(12) < 0.3

    def as_drives_tell(time, joints):
        # A position drive pulls by how far it is off; encoders' errors it does not know.
        pull = ROBOT.effort.reshape(-1) * (robot.commanded - robot.joints) / 0.35
        return joints, np.where(bearing, 20.0, 0.2 * pull)

    assert robot.walk(12.0, as_drives_tell) is None


@pytest.mark.parametrize('arrival', np.arange(1.02, 1.6, 0.035))
def test_joints_that_join_a_swing_while_they_are_not_measured_are_sound(arrival):
    # Two joints of one leg, one after the other: so one of them is off where the instant of the
    # arrival is not known well.
    times = np.linspace(0.0, 1.0, 51)
    turn = 2.0 * math.pi * times
    size = np.eye(12)[[0, 2]]
    late = JointTrajectory(
        ROBOT.joint_names,
        1.0,
        times,
        POSTURE + 0.75 * np.stack([np.sin(turn), 1.0 - np.cos(turn)], axis=1) @ size,
        1.5 * math.pi * np.stack([np.cos(turn), np.sin(turn)], axis=1) @ size,
    )
    limits = replace(JointLimits.of(ROBOT), velocity=np.full(12, 8.0))
    executor = TrajectoryExecutor(ROBOT.joint_names, POSTURE, limits)
    tracker = CommandTracker()
    tracker.hold(0.5, POSTURE)
    tracker.add(JointPath(late, 0.8, 0.07, 0.01))
    assert tracker.explain(0.99, POSTURE) is not None
    executor.accept(late, arrival)
    for time in arrival + np.array([0.12, 0.18, 0.24, 0.3]):
        found = tracker.explain(time, executor.command(time)[0])
        assert found is not None
        assert not found.off.any()


@pytest.mark.parametrize('seed', range(4))
def test_measurements_that_come_late_are_no_faults(seed):
    robot = Robot(seed)
    rng = np.random.default_rng(seed)
    update = robot.watch.update
    until = 0.0

    def now_and_then(time, joints, efforts):
        nonlocal until
        if time < until:
            return None
        if rng.random() < 0.05:
            until = time + rng.uniform(0.0, 0.5)
        return update(time, joints, efforts)

    robot.watch.update = now_and_then
    assert robot.walk(12.0) is None


@pytest.mark.parametrize('joint', range(0, 12, 3))
@pytest.mark.parametrize('stamped', [True, False])
def test_a_stuck_joint_is_named_within_a_cycle(joint, stamped):
    robot = Robot(joint, stamped=stamped)
    began = 3.1
    kept = []

    def stuck(time, joints):
        if time > began:
            kept.append(joints[joint])
            joints[joint] = kept[0]
        return joints, np.full(12, 20.0)

    fault = robot.walk(8.0, stuck)
    assert (fault.joint, fault.kind) == (joint, 'stuck')
    assert fault.time - began < CYCLE


@pytest.mark.parametrize('joint', range(0, 12, 3))
@pytest.mark.parametrize('stamped', [True, False])
def test_a_joint_that_gives_way_is_named_within_a_fifth_of_a_second(joint, stamped):
    robot = Robot(joint, stamped=stamped)
    began = 3.1

    def free(time, joints):
        efforts = np.full(12, 20.0)
        if time > began:
            # It falls as a leg of 0.2 m under g.
            joints[joint] += 0.5 * 49.0 * (time - began) ** 2
            efforts[joint] = 0.0
        return joints, efforts

    fault = robot.walk(8.0, free)
    assert (fault.joint, fault.is_slack) == (joint, True)
    assert fault.time - began < 0.2


@pytest.mark.parametrize('seed', range(8))
def test_among_late_trajectories_no_other_joint_is_named_than_the_stuck_one(seed):
    robot = Robot(seed, lateness=0.5, stamped=bool(seed % 2))
    joint = int(robot.rng.integers(12))
    kept = []

    def stuck(time, joints):
        if time > 3.0:
            kept.append(joints[joint])
            joints[joint] = kept[0]
        return joints, np.full(12, 20.0)

    fault = robot.walk(15.0, stuck)
    assert fault.joint == joint


@pytest.mark.parametrize('stamped', [True, False])
def test_joints_that_nobody_moves_are_sound_but_do_not_follow(stamped):
    robot = Robot(1, lost=1.0, stamped=stamped)
    assert robot.walk(8.0) is None
    assert robot.watch.unfollowed > 3.0


def test_joints_that_follow_again_are_followed_again():
    robot = Robot(2, lost=1.0)
    assert robot.walk(6.0) is None
    assert robot.watch.unfollowed > 3.0
    robot.lost = 0.0
    given = robot.time
    position, _ = robot.executor.command(given)
    ahead = piece(given - 0.5, given + 3.0, robot.phases, 0.0)
    moved = position + (ahead.positions - ahead.positions[0])
    robot.give(
        JointTrajectory(
            ahead.joint_names, given + 0.1, ahead.times - ahead.times[0], moved, ahead.velocities
        )
    )
    while robot.time < given + 2.0:
        robot.advance()
        assert robot.watch.update(robot.time, robot.joints, np.full(12, 20.0)) is None
    assert robot.watch.unfollowed == 0.0


@pytest.mark.sweep(kept=12)
@pytest.mark.parametrize('seed', range(12))
@pytest.mark.parametrize('has_torque', [True, False])
@pytest.mark.parametrize('stamp', [0.5, 0.0])
def test_joints_that_are_all_held_in_a_slow_motion_are_sound(seed, has_torque, stamp):
    # As a switch does that stops all drives while the robot stands up.
    rng = np.random.default_rng(seed)
    watch = JointFaultDetector(ROBOT)
    executor = TrajectoryExecutor(ROBOT.joint_names, POSTURE)
    times = np.arange(0.1, 4.01, 0.02)
    turn = rng.uniform(-0.3, 0.3, 12)
    share = (times / times[-1])[:, None]
    motion = JointTrajectory(
        ROBOT.joint_names,
        stamp,
        times,
        POSTURE + turn * share**2 * (3.0 - 2.0 * share),
        turn * 6.0 * share * (1.0 - share) / times[-1],
    )
    held_from = rng.uniform(1.0, 2.5)
    efforts = rng.uniform(0.1, 0.5, 12) * ROBOT.effort.reshape(-1)
    if not has_torque:
        efforts[rng.random(12) < 0.5] = 0.0
    # It has stood for a while, on a trajectory that is void by now.
    watch.update(0.0, POSTURE, efforts)
    watch.expect(motion, 0.2)
    executor.accept(motion, 0.2)
    joints = POSTURE
    for time in np.arange(0.2, 8.0, STEP):
        if time < held_from:
            joints, _ = executor.command(time)
        measured = joints + rng.normal(0.0, 0.0005, 12)
        assert watch.update(time, measured, efforts) is None
    assert watch.unfollowed > 1.0
