"""Joints that cannot be in time come as near as they can, and what follows knows of it."""

import math

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.trajectory_gate import JointLimits
from quad_gait.balance.balance_options import BalanceOptions
from quad_gait.balance.balanced_motion import BalancedMotion
from quad_gait.balance.body_estimate import BodyEstimate
from quad_gait.balance.foot_laws import Pace, leveled, tilted_back
from quad_gait.balance.joint_motion import (
    JointMotion,
    JointMotionPlanner,
    Limits,
    is_within,
    keep_up,
)
from quad_gait.behaviours.gait_choice import balanced_gait
from quad_gait.cycle.gait import load_gait

ROBOT = load_robot('genibo')
FASTEST = 0.9 * ROBOT.velocity
LIMITS = Limits(ROBOT.lower, ROBOT.upper, FASTEST)


def followed(wanted, first, speed, times):
    """Return positions and velocities of joints that begin at a place with a velocity."""
    positions, speeds = np.concatenate([first[None], wanted]), np.zeros((len(wanted) + 1, 4, 3))
    speeds[0] = speed
    keep_up(positions, speeds, times, 1, LIMITS)
    return positions, speeds


@pytest.mark.parametrize('seed', range(30))
def test_whatever_is_wanted_no_joint_leaves_its_range_or_its_speed(seed):
    rng = np.random.default_rng(seed)
    limits = JointLimits.of(ROBOT)
    times = np.concatenate([[0.0], np.cumsum(rng.choice([0.02, 0.04], 12))])
    inner = 0.02
    for trial in range(20):
        wanted = rng.uniform(ROBOT.lower + inner, ROBOT.upper - inner, (12, 4, 3))
        if trial % 2:
            # To the ends of ranges, where they have to brake.
            ends = np.where(
                rng.uniform(size=(4, 3)) < 0.5, ROBOT.lower + inner, ROBOT.upper - inner
            )
            wanted = np.repeat(ends[None], 12, axis=0)
        # Slow and fast wishes, from any speed that keeps the ranges.
        first = rng.uniform(ROBOT.lower + inner, ROBOT.upper - inner)
        wanted = first + rng.choice([0.02, 0.2, 1.0]) * (wanted - first)
        room = 3.0 * np.minimum(first - ROBOT.lower, ROBOT.upper - first) / times[1]
        speed = rng.uniform(-1.0, 1.0, (4, 3)) * np.minimum(FASTEST, room)
        positions, speeds = followed(wanted, first, speed, times)
        limits.check(times, positions.reshape(-1, 12), speeds.reshape(-1, 12))


@pytest.mark.parametrize('seed', range(10))
def test_what_is_within_limits_at_a_glance_passes_the_last_gate(seed):
    rng = np.random.default_rng(seed)
    gate = JointLimits.of(ROBOT)
    own = Limits(ROBOT.lower, ROBOT.upper, np.array(np.broadcast_to(ROBOT.velocity, (4, 3))))
    middle, half = (ROBOT.upper + ROBOT.lower) / 2.0, (ROBOT.upper - ROBOT.lower) / 2.0
    answers = []
    for _ in range(200):
        times = np.cumsum(rng.choice([0.02, 0.04], 6))
        size, pace = rng.choice([0.2, 0.9, 1.01]), rng.choice([0.05, 0.3, 0.6])
        steps = np.cumsum(0.02 * pace * own.fastest * rng.normal(size=(6, 4, 3)), axis=0)
        positions = middle + size * half * rng.uniform(-1.0, 1.0, (4, 3)) + 0.5 * steps
        speeds = pace * own.fastest * rng.uniform(-1.0, 1.0, (6, 4, 3))
        first = int(rng.integers(0, 3))
        answers.append(is_within(positions, speeds, times, first, own))
        if answers[-1]:
            gate.check(
                times[first:],
                positions[first:].reshape(-1, 12),
                speeds[first:].reshape(-1, 12),
            )
    assert 10 < sum(answers) < 190


def test_numbers_that_are_not_finite_are_not_within_limits():
    positions = np.repeat(ROBOT.initial_joint_angles[None], 3, axis=0)
    speeds, times = np.zeros((3, 4, 3)), 0.02 * np.arange(3)
    assert is_within(positions, speeds, times, 0, LIMITS)
    for values in (positions, speeds):
        spoiled = values.copy()
        spoiled[2, 1, 2] = np.nan
        both = (spoiled, speeds) if values is positions else (positions, spoiled)
        assert not is_within(*both, times, 0, LIMITS)


def test_what_is_possible_is_reached_and_each_joint_for_itself():
    first = ROBOT.initial_joint_angles
    times = 0.02 * np.arange(13)
    wanted = np.repeat(first[None], 12, axis=0)
    # One joint is to leap; another one goes where it is to go, as if nothing were.
    wanted[:, 1, 1] += 0.5
    wanted[:, 1, 0] += np.minimum(0.05 * np.arange(1, 13), 0.2)
    positions, _ = followed(wanted, first, 0.0, times)
    assert positions[1:, 1, 0] == pytest.approx(wanted[:, 1, 0], abs=1e-9)
    assert np.array_equal(positions[1:, [0, 2, 3]], wanted[:, [0, 2, 3]])
    leap = positions[:, 1, 1] - first[1, 1]
    assert leap[-1] == pytest.approx(0.5)
    # From rest two thirds of its speed in the first interval, then nearly all of it.
    assert leap[1] == pytest.approx(0.02 * FASTEST[1, 1] * 2.0 / 3.0)
    assert (np.diff(leap)[1:3] > 0.85 * 0.02 * FASTEST[1, 1]).all()


def test_what_the_joints_can_do_is_not_touched():
    planner = JointMotionPlanner(ROBOT, 0.95)
    at_rest = ROBOT.initial_joint_angles[None]
    given = JointMotion(np.array([0.0]), at_rest, np.zeros((1, 4, 3)))
    times = 0.02 * np.arange(1, 8)
    feet = np.repeat(ROBOT.neutral_feet[None], 7, axis=0)
    feet[:, :, 0] += 0.004 * np.sin(20.0 * times)[:, None]
    motion = planner.go_on(given, feet, times)
    assert not motion.is_slowed
    assert ROBOT.foot_positions(motion.positions[1:]) == pytest.approx(feet, abs=1e-9)
    feet[:, :, 1] += 0.04
    assert planner.go_on(given, feet, times).is_slowed


def test_places_in_a_tilted_body_are_leveled_as_they_were_tilted():
    rng = np.random.default_rng(2)
    roll, pitch = rng.uniform(-0.6, 0.6, (2, 5, 4))
    level = rng.uniform(-0.3, 0.3, (5, 4, 3))
    tilted = np.array(
        [
            [tilted_back(*level[k, leg], roll[k, leg], pitch[k, leg]) for leg in range(4)]
            for k in range(5)
        ]
    )
    x, y = leveled(tilted, roll, pitch)
    assert x == pytest.approx(level[..., 0])
    assert y == pytest.approx(level[..., 1])


def test_a_plan_goes_on_from_where_slowed_joints_have_the_feet():
    gait = balanced_gait(load_gait('trot', ROBOT), BalanceOptions())
    motion = BalancedMotion(ROBOT, gait, BalanceOptions(), 0.0, ROBOT.initial_joint_angles)
    # Pushed to its left at nearly sqrt(g h), and turning over: no joint is fast enough.
    body = BodyEstimate((0.0, 0.9), 0.0, -0.25, 0.0, -3.0, 0.0)
    apart = []
    for k in range(25):
        time = 0.02 * k
        trajectory = motion.update(time, body, Pace(0.0, 0.0, 0.0))
        if trajectory is None or k < 10:
            continue
        knots = [round((trajectory.stamp + t) / 0.02) for t in trajectory.times]
        for plan, knot in zip(motion._knots[1:], range(motion._first + 1, motion._first + 99)):
            joints = trajectory.positions[knots.index(knot)].reshape(4, 3)
            feet = ROBOT.foot_positions(joints)
            for foot, there in zip(plan.feet, feet):
                x, y = leveled(there, np.array(foot.roll), np.array(foot.pitch))
                apart.append(math.hypot(foot.x - x, foot.y - y))
    assert len(apart) > 300
    assert max(apart) < 1e-6
