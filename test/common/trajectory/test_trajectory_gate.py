"""No trajectory passes the gate that leaves the limits at any instant."""

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline

from quad_common.errors import CommandJumps, CommandOutsideLimits
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_common.trajectory.trajectory_executor import TrajectoryExecutor
from quad_common.trajectory.trajectory_gate import (
    CONTROL_PERIOD,
    OVERSHOOT,
    VELOCITY_TOLERANCE,
    JointLimits,
    check_command,
    joining_time,
)

NAMES = ('a', 'b', 'c')
LIMITS = JointLimits(
    NAMES, np.array([-1.0, -0.5, 0.0]), np.array([1.0, 0.5, 2.0]), np.array([3.0, 6.0, 2.0])
)
MIDDLE = (LIMITS.lower + LIMITS.upper) / 2.0
STILL = np.zeros(3)


def trajectory(positions, velocities=None, times=None, stamp=10.0):
    positions = np.atleast_2d(positions)
    if velocities is None:
        velocities = np.zeros_like(positions)
    if times is None:
        times = np.arange(len(positions)) * 1.0
    return JointTrajectory(NAMES, stamp, times, positions, np.atleast_2d(velocities))


def is_within(spline, velocity, times):
    """Whether a motion keeps the limits at many instants."""
    positions, velocities = spline(times), velocity(times)
    most = (1.0 + VELOCITY_TOLERANCE) * LIMITS.velocity
    return bool(
        np.all(positions >= LIMITS.lower - OVERSHOOT - 1e-6)
        and np.all(positions <= LIMITS.upper + OVERSHOOT + 1e-6)
        and np.all(np.abs(velocities) <= most + 1e-6)
    )


def test_the_gate_lets_through_exactly_what_keeps_the_limits_at_every_instant():
    rng = np.random.default_rng(0)
    passed = refused = 0
    while passed < 300 or refused < 300:
        points = int(rng.integers(2, 5))
        span = rng.uniform(0.3, 1.1)
        positions = MIDDLE + span * rng.uniform(-1.0, 1.0, (points, 3)) * (LIMITS.upper - MIDDLE)
        velocities = rng.normal(size=(points, 3)) * 0.3
        times = np.concatenate([[0.0], np.cumsum(rng.uniform(0.3, 1.2, points - 1))])
        spline = CubicHermiteSpline(times, positions, velocities)
        dense = np.linspace(0.0, times[-1], 2001)
        at_points = np.all(np.abs(velocities) <= LIMITS.velocity) and np.all(
            (positions >= LIMITS.lower) & (positions <= LIMITS.upper)
        )
        keeps = is_within(spline, spline.derivative(), dense) and at_points
        try:
            LIMITS.check(times, positions, velocities)
        except CommandOutsideLimits:
            refused += 1
            # Only what many instants miss by a hair may be refused all the same.
            slack = JointLimits(
                NAMES, LIMITS.lower + 1e-4, LIMITS.upper - 1e-4, LIMITS.velocity * (1.0 - 1e-4)
            )
            with pytest.raises(CommandOutsideLimits):
                slack.check(times, positions, velocities)
            if keeps:
                peak = np.abs(spline.derivative()(dense)) / LIMITS.velocity
                near = np.minimum(spline(dense) - LIMITS.lower, LIMITS.upper - spline(dense)).min()
                assert peak.max() > 1.0 + VELOCITY_TOLERANCE - 1e-3 or near < 1e-3 - OVERSHOOT
        else:
            passed += 1
            assert keeps


@pytest.mark.parametrize('value', [1e308, -1e308, 7.85, np.nan])
def test_a_position_that_no_joint_has_is_refused_with_the_joint_and_its_range(value):
    positions = np.tile(MIDDLE, (3, 1))
    positions[1, 1] = value
    with pytest.raises(CommandOutsideLimits) as refusal:
        LIMITS.check(np.arange(3.0), positions, np.zeros_like(positions))
    assert refusal.value.joint == 'b'
    assert refusal.value.quantity == 'position'
    assert refusal.value.limits == pytest.approx((-0.5, 0.5), abs=1e-5)


def test_a_first_point_must_be_reached_in_its_time_from_the_last_command():
    there = MIDDLE + [0.9, 0.0, 0.0]
    check_command(LIMITS, trajectory(there, stamp=11.0), 10.0, MIDDLE, STILL)
    with pytest.raises(CommandOutsideLimits, match='joint a would be commanded a velocity'):
        check_command(LIMITS, trajectory(there, stamp=10.1), 10.0, MIDDLE, STILL)


def test_a_trajectory_that_runs_already_must_not_make_a_command_jump():
    runs = trajectory([MIDDLE, MIDDLE + 0.3], stamp=9.5)
    now = runs.positions_at(np.array([10.0]))[0]
    check_command(LIMITS, runs, 10.0, now, STILL)
    off = now + [0.0, 1.01 * CONTROL_PERIOD * LIMITS.velocity[1], 0.0]
    with pytest.raises(CommandJumps, match='joint b would jump by -0'):
        check_command(LIMITS, runs, 10.0, off, STILL)


def test_joints_come_to_rest_in_the_joining_time_without_exceeding_their_velocity():
    rng = np.random.default_rng(1)
    for _ in range(200):
        position, target = rng.uniform(LIMITS.lower, LIMITS.upper, (2, 3))
        velocity = rng.uniform(-0.8, 0.8, 3) * LIMITS.velocity
        duration = joining_time(LIMITS, position, velocity, target)
        spline = CubicHermiteSpline([0.0, duration], [position, target], [velocity, STILL])
        speed = np.abs(spline.derivative()(np.linspace(0.0, duration, 200)))
        assert np.all(speed <= LIMITS.velocity * (1.0 + 1e-9))


def follow(executor, start, end):
    times = np.arange(start, end, 0.002)
    commands = [executor.command(time) for time in times]
    return times, np.array([c[0] for c in commands]), np.array([c[1] for c in commands])


@pytest.mark.parametrize('lateness', [0.05, 0.4, 0.9])
def test_joints_are_led_to_a_late_trajectory_within_their_velocity(lateness):
    rng = np.random.default_rng(int(100 * lateness))
    for _ in range(20):
        ends = rng.uniform(LIMITS.lower, LIMITS.upper, (3, 3)) * 0.5
        late = trajectory(ends, times=np.array([0.0, 1.0, 4.0]), stamp=10.0)
        executor = TrajectoryExecutor(NAMES, MIDDLE, LIMITS)
        now = 10.0 + lateness
        assert not executor.accept(late, now)
        _, positions, velocities = follow(executor, now, 15.0)
        assert positions[0] == pytest.approx(MIDDLE)
        assert np.all(np.abs(np.diff(positions, axis=0)) <= 1.3 * LIMITS.velocity * 0.002)
        assert np.allclose(np.gradient(positions, 0.002, axis=0)[2:-2], velocities[2:-2], atol=0.1)
        assert positions[-1] == pytest.approx(ends[-1])


def test_a_first_point_that_is_too_near_in_time_is_reached_later_and_not_by_a_jump():
    executor = TrajectoryExecutor(NAMES, MIDDLE, LIMITS)
    there = MIDDLE + [0.8, 0.0, 0.0]
    assert not executor.accept(trajectory(there, stamp=10.02), 10.0)
    _, positions, velocities = follow(executor, 10.0, 12.0)
    assert np.abs(velocities).max() <= 1.01 * LIMITS.velocity[0]
    assert positions[-1] == pytest.approx(there)


def test_a_trajectory_without_a_time_of_its_own_begins_when_it_can_be_reached():
    executor = TrajectoryExecutor(NAMES, MIDDLE, LIMITS)
    there = MIDDLE + [0.8, 0.0, 0.0]
    sudden = trajectory([there, there - 0.1], times=np.array([0.02, 1.0]), stamp=0.0)
    assert not executor.accept(sudden, 10.0)
    _, positions, velocities = follow(executor, 10.0, 13.0)
    assert np.abs(velocities[:, 0]).max() <= 1.01 * LIMITS.velocity[0]
    assert positions[-1] == pytest.approx(there - 0.1)
    # Its own path is the same, a while later.
    reached = int(np.argmin(np.abs(positions[:, 0] - there[0])))
    assert positions[reached] == pytest.approx(there, abs=1e-4)


def test_what_the_gate_lets_through_is_executed_in_its_time():
    # Joints that turn fast are braked within the time to the first point: their velocity halfway
    # is beyond the limit by a Bezier point, but at no instant.
    command, velocity = np.array([0.0, 0.43, 1.0]), np.array([0.0, -5.3, 0.0])
    first = np.array([0.0, 0.157, 1.0])
    goes_on = JointTrajectory(
        NAMES,
        0.0,
        np.array([0.06, 0.08, 0.4]),
        np.array([first, first + [0.0, 0.04, 0.0], first + [0.0, 0.2, 0.0]]),
        np.array([[0.0, -1.48, 0.0], [0.0, 1.0, 0.0], STILL]),
    )
    executor = TrajectoryExecutor(NAMES, command, LIMITS)
    before = JointTrajectory(
        NAMES, 10.0, np.array([0.0, 0.5]), np.array([command, command]), np.array([velocity, STILL])
    )
    executor.accept(before, 10.0)
    check_command(LIMITS, goes_on, 10.0, *executor.command(10.0))
    assert executor.accept(goes_on, 10.0)
    assert executor.command(10.06)[0] == pytest.approx(first, abs=1e-9)


def random_motion(rng, stamp, lead):
    """Points through the joints' ranges at which none is too fast, from a lead on [s]."""
    points = int(rng.integers(2, 5))
    positions = rng.uniform(LIMITS.lower, LIMITS.upper, (points, 3))
    velocities = rng.uniform(-0.9, 0.9, (points, 3)) * LIMITS.velocity
    velocities[-1] = 0.0
    times = lead + np.concatenate([[0.0], np.cumsum(rng.uniform(0.1, 1.0, points - 1))])
    return JointTrajectory(NAMES, stamp, times, positions, velocities)


def is_sound(motion):
    try:
        LIMITS.check(motion.times, motion.positions, motion.velocities)
    except CommandOutsideLimits:
        return False
    return True


@pytest.mark.parametrize('kind', ['on arrival', 'too near', 'late', 'far ahead'])
def test_whenever_a_trajectory_comes_commands_stay_within_the_joints_range(kind):
    rng = np.random.default_rng(len(kind))
    done, slack = 0, OVERSHOOT + 1e-5
    while done < 40:
        runs = random_motion(rng, 10.0, 0.0)
        if not is_sound(runs):
            continue
        now = 10.0 + float(rng.uniform(0.0, runs.times[-1]))
        executor = TrajectoryExecutor(NAMES, runs.positions[0], LIMITS)
        executor.accept(runs, 10.0)
        lead = float(rng.uniform(0.01, 0.1))
        stamp = {
            'on arrival': 0.0,
            'too near': now,
            'late': now - 3.0 * lead,
            'far ahead': now + 10.0 * lead,
        }[kind]
        other = random_motion(rng, stamp, lead)
        if not is_sound(other):
            continue
        done += 1
        executor.accept(other, now)
        _, positions, _ = follow(executor, now, now + 6.0)
        assert np.all(positions >= LIMITS.lower - slack)
        assert np.all(positions <= LIMITS.upper + slack)
        assert positions[-1] == pytest.approx(other.positions[-1], abs=1e-6)


def test_fast_joints_come_to_rest_before_they_join_a_trajectory_that_begins_later():
    command, velocity = np.array([-0.9, 0.0, 1.0]), np.array([0.0, -5.0, 0.0])
    before = JointTrajectory(
        NAMES, 10.0, np.array([0.0, 0.5]), np.array([command, command]), np.array([velocity, STILL])
    )
    there = np.array([0.9, -0.1, 1.0])
    for lead in (0.06, 0.3):
        executor = TrajectoryExecutor(NAMES, command, LIMITS)
        executor.accept(before, 10.0)
        # Joint a needs long: meanwhile b must not go on far beyond where it is wanted.
        assert not executor.accept(trajectory(there, times=np.array([lead]), stamp=0.0), 10.0)
        _, positions, velocities = follow(executor, 10.0, 13.0)
        assert positions[:, 1].min() >= -0.12
        assert np.all(np.abs(velocities) <= (1.0 + VELOCITY_TOLERANCE) * LIMITS.velocity)
        assert positions[-1] == pytest.approx(there)


def test_what_goes_on_with_a_late_trajectory_lets_the_difference_fade_out_as_it_was():
    executor = TrajectoryExecutor(NAMES, MIDDLE, LIMITS)
    late = trajectory([MIDDLE + 0.3, MIDDLE + 0.1], times=np.array([0.0, 3.0]), stamp=10.0)
    assert not executor.accept(late, 10.5)
    before = executor.command(10.55)[0]
    assert executor.accept(late, 10.55)
    assert executor.command(10.55)[0] == pytest.approx(before)


def test_a_trajectory_that_starts_a_rounding_error_later_is_not_taken_to_leap():
    now = 0.24
    later = float(np.nextafter(now, 1.0))
    off = MIDDLE + 1e-12
    check_command(LIMITS, trajectory(MIDDLE, stamp=later), now, off, 0.5 * LIMITS.velocity)
