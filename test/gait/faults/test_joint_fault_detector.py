"""A joint that does not answer is noticed, and a sound one that lags is not."""

import math

import numpy as np
import pytest

from quad_common.robot_files.robot_file import load_robot
from quad_common.trajectory.joint_trajectory import JointTrajectory
from quad_gait.cycle.body_motion import minimum_jerk
from quad_gait.faults.joint_fault_detector import JointFaultDetector

ROBOT = load_robot('titan_viii')
POSTURE = ROBOT.initial_joint_angles.reshape(-1)
JOINTS = range(12)
PERIOD = 0.02
LOADED = np.full(12, 20.0)


def swaying(stamp=0.5, seconds=4.0, size=0.4, about=POSTURE):
    """All joints to and fro, each with a time of its own."""
    times = np.linspace(0.0, seconds, round(seconds / 0.02) + 1)
    lag = np.linspace(0.0, 1.0, 12)
    rate = 2.0 * math.pi / seconds
    turned = rate * times[:, None] + lag
    return JointTrajectory(
        ROBOT.joint_names,
        stamp,
        times,
        about + size * (np.sin(turned) - np.sin(lag)),
        size * rate * np.cos(turned),
    )


def path_of(trajectory):
    """Return positions by time, as an executor that heard it in time would have them."""

    def at(time):
        t = np.clip(time - trajectory.stamp, 0.0, trajectory.times[-1])
        return np.array([np.interp(t, trajectory.times, p) for p in trajectory.positions.T])

    return at


def watch_for(seconds, measured, watch, efforts=LOADED, start=0.5):
    """Hand measurements to a watch; return the first fault."""
    for time in np.arange(start, start + seconds, PERIOD):
        given = efforts(time) if callable(efforts) else efforts
        fault = watch.update(time, measured(time), given)
        if fault is not None:
            return fault
    return None


@pytest.fixture
def watch():
    watch = JointFaultDetector(ROBOT)
    watch.expect(swaying(), 0.2)
    return watch


@pytest.mark.parametrize('delay', [0.0, 0.03, 0.06])
def test_a_sound_robot_that_lags_a_little_is_sound(watch, delay):
    path = path_of(swaying())
    rng = np.random.default_rng(1)
    noise = 0.02
    fault = watch_for(5.0, lambda t: path(t - delay) + rng.uniform(-noise, noise, 12), watch)
    assert fault is None


def test_a_robot_that_hears_its_trajectory_late_is_sound(watch):
    old, new = path_of(swaying()), swaying(2.0, about=path_of(swaying())(2.0))
    path = path_of(new)
    assert watch_for(1.5, old, watch) is None
    watch.expect(new, 2.0)
    heard = 2.6
    fault = watch_for(3.0, lambda t: old(t) if t < heard else path(t), watch, start=2.0)
    assert fault is None


def test_a_robot_that_hears_nothing_at_all_is_no_robot_with_a_failed_joint(watch):
    assert watch_for(5.0, lambda t: POSTURE, watch) is None


def test_without_a_trajectory_nothing_is_expected():
    watch = JointFaultDetector(ROBOT)
    assert watch_for(2.0, lambda t: POSTURE + t, watch) is None


def test_joints_that_are_not_measured_for_a_while_have_not_failed(watch):
    path = path_of(swaying())
    for time in np.arange(0.5, 4.0, 0.4):
        assert watch.update(time, path(time), LOADED) is None
        for _ in range(10):
            # The same message again and again.
            assert watch.update(time, path(time), LOADED) is None


def test_a_robot_that_is_put_somewhere_else_has_not_failed(watch):
    path = path_of(swaying())
    assert watch_for(1.2, path, watch) is None
    assert watch_for(2.0, lambda t: POSTURE, watch, start=1.7) is None


@pytest.mark.parametrize('joint', JOINTS)
def test_a_stuck_joint_is_named(watch, joint):
    path = path_of(swaying())

    def measured(time):
        positions = path(time)
        if time > 1.0:
            positions[joint] = path(1.0)[joint]
        return positions

    fault = watch_for(2.0, measured, watch)
    assert fault.name == ROBOT.joint_names[joint]
    assert (fault.joint, fault.leg, fault.kind) == (joint, joint // 3, 'stuck')
    off = abs(fault.commanded - path(1.0)[joint])
    assert 0.03 < off < 0.2
    words = f'{fault.name} of leg {fault.name[:2]} does not move'
    assert words in str(fault)
    assert f'{off:.2f} rad from its command, with 20 N m' in str(fault)


@pytest.mark.parametrize('joint', JOINTS)
def test_a_free_joint_under_load_is_named_within_a_tenth_of_a_second_of_giving_way(watch, joint):
    path = path_of(swaying())
    began = 1.0

    def measured(time):
        positions = path(time)
        if time > began:
            # It falls as a leg of 0.2 m under g.
            positions[joint] += 0.5 * 49.0 * (time - began) ** 2
        return positions

    def efforts(time):
        return np.where((np.arange(12) == joint) & (time > began), 0.0, LOADED)

    fault = watch_for(2.0, measured, watch, efforts)
    assert (fault.name, fault.kind, fault.is_slack) == (ROBOT.joint_names[joint], 'free', True)
    assert fault.time - began < 0.13
    assert 'does not hold' in str(fault)
    assert 'carries no torque' in str(fault)


def test_an_overloaded_motor_has_not_failed(watch):
    path = path_of(swaying())
    efforts = LOADED.copy()
    efforts[4] = 100.0

    def measured(time):
        positions = path(time)
        positions[4] -= 0.3 * min(1.0, max(0.0, time - 1.0))
        return positions

    assert watch_for(3.0, measured, watch, efforts) is None
    assert watch_for(3.0, measured, watch, None, start=3.5).joint == 4


def test_when_the_clock_is_set_back_the_watch_begins_anew(watch):
    path = path_of(swaying())
    assert watch_for(2.0, path, watch) is None
    assert watch.update(0.1, POSTURE + 1.0, LOADED) is None
    assert watch_for(2.0, lambda t: POSTURE + 0.2, watch, start=0.12) is None


def off_by(offset, joints, path, since=1.0):
    """Joints that are off their commands from a time on."""

    def measured(time):
        positions = path(time)
        if time > since:
            positions[joints] += offset
        return positions

    return measured


def without_torque(joints, since=1.0, torque=2.0):
    def efforts(time):
        given = LOADED.copy()
        if time > since:
            given[joints] = torque
        return given

    return efforts


@pytest.mark.parametrize('joint', JOINTS)
def test_a_joint_that_is_a_little_off_and_does_not_pull_is_named(watch, joint):
    path = path_of(swaying())
    measured = off_by(0.05, [joint], path)
    assert watch_for(1.4, measured, watch) is None
    watch.forget()
    watch.expect(swaying(), 0.2)
    fault = watch_for(2.0, measured, watch, without_torque([joint]))
    assert (fault.joint, fault.is_slack) == (joint, True)
    assert fault.time - 1.0 < 0.2


@pytest.mark.parametrize('joint', JOINTS)
def test_a_joint_that_need_not_pull_is_sound_where_it_was_sent(watch, joint):
    path = path_of(swaying())
    measured = off_by(0.02, [joint], path)
    assert watch_for(4.0, measured, watch, without_torque([joint])) is None


@pytest.mark.parametrize('joint', JOINTS)
def test_a_joint_that_follows_its_leg_without_torque_is_said_not_to_be_driven(joint):
    watch = JointFaultDetector(ROBOT)
    slowly = swaying(size=0.06)
    watch.expect(slowly, 0.2)
    measured = off_by(0.02, [joint], path_of(slowly))
    fault = watch_for(4.0, measured, watch, without_torque([joint], torque=0.0))
    assert (fault.joint, fault.kind, fault.is_slack) == (joint, 'undriven', True)
    assert f'{fault.name} of leg {fault.name[:2]} is not driven: it is at' in str(fault)


def test_two_joints_that_are_a_little_off_and_do_not_pull_hide_no_third_one(watch):
    path = path_of(swaying())
    little = off_by(0.05, [1, 8], path)

    def measured(time):
        positions = little(time)
        if time > 1.0:
            positions[4] += 0.2
        return positions

    assert watch_for(2.0, measured, watch, without_torque([1, 8])).joint == 4


@pytest.mark.parametrize('received_after', [0.0, 0.3])
def test_a_joint_that_is_jammed_in_a_small_swing_is_named_while_the_robot_rests(received_after):
    # It begins on arrival, and no joint turns by more than sound ones may be off twice.
    watch = JointFaultDetector(ROBOT)
    times = np.arange(0.06, 0.5, 0.02)
    fraction, rate = minimum_jerk(0.06, times[-1], times)
    travel = np.where(np.arange(12) % 3 == 2, 0.13, 0.1)
    swing = JointTrajectory(
        ROBOT.joint_names, 0.0, times, POSTURE + fraction[:, None] * travel, rate[:, None] * travel
    )

    def measured(time):
        since = time - 0.5 - received_after
        positions = swing.positions_at(np.clip([since], times[0], times[-1]))[0]
        positions[0] = POSTURE[0]
        return positions

    barely = np.full(12, 0.5)
    watch.update(0.48, POSTURE, barely)
    watch.expect(swing, 0.5)
    fault = watch_for(2.0, measured, watch, barely)
    assert fault is not None
    assert (fault.joint, fault.kind) == (0, 'stuck')
