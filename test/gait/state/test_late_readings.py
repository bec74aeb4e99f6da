"""Readings that come too late, or too seldom, to keep the balance by are said to be."""

import numpy as np
import pytest

from quad_common.planar_pose import Pose2D
from quad_common.robot_files.robot_file import load_robot
from quad_gait.state.measurement import ImuMotion
from quad_gait.state.sensor_inputs import JointReadings, SensorInputs

POSTURE = load_robot('titan_viii').initial_joint_angles.reshape(-1)
STILL = np.zeros(12)
LEVEL = np.array([0.0, 0.0, 0.0, 1.0])
ORIGIN = Pose2D(0.0, 0.0, 0.0)
MOTION = ImuMotion(np.zeros(3), None)


class Stream:
    """Readings each so often, so late, and some not at all."""

    def __init__(self, period=0.01, delay=0.0, gaps=lambda time: False):
        self.period, self.delay, self.gaps = period, delay, gaps
        self.last = -1.0

    def due(self, time):
        """Return the stamp of a reading that comes now; None for none."""
        stamp = time - self.delay
        if stamp < self.last + self.period - 1e-6 or self.gaps(stamp):
            return None
        self.last = stamp
        return stamp


def late_after(
    seconds=4.0, imu=None, joints=None, odometry=None, inputs=None, begin=0.0, posture=POSTURE
):
    """Let time go on; return what is said to be late at the end, and the inputs."""
    inputs = inputs or SensorInputs(load_robot('titan_viii'))
    imu, joints, odometry = imu or Stream(), joints or Stream(), odometry or Stream()
    said, every = '', set()
    for time in begin + 0.01 * np.arange(round(seconds / 0.01)):
        stamp = imu.due(time)
        if stamp is not None:
            inputs.take_imu(stamp, LEVEL, 0.0, MOTION)
        stamp = joints.due(time)
        if stamp is not None:
            inputs.take_joints(JointReadings(posture, STILL, None, stamp))
        stamp = odometry.due(time)
        if stamp is not None:
            said = inputs.take_odometry(stamp, ORIGIN, LEVEL).late
            every.add(said)
    # What changes is published at once.
    assert len(every) <= 3
    return said, inputs


@pytest.mark.parametrize('period', [0.01, 0.02, 0.05])
def test_sensors_at_20_hz_and_more_are_prompt(period):
    assert not late_after(imu=Stream(period), joints=Stream(period))[0]


@pytest.mark.parametrize('period', [0.01, 0.02, 0.03])
def test_odometry_at_33_hz_and_more_is_prompt(period):
    assert not late_after(odometry=Stream(period))[0]


@pytest.mark.parametrize(
    ('streams', 'words'),
    [
        ({'imu': Stream(0.1)}, "the imu's readings are older than 0.06 s"),
        ({'imu': Stream(delay=0.15)}, "the imu's readings are older"),
        ({'imu': Stream(gaps=lambda time: time % 0.3 < 0.15)}, "the imu's readings are older"),
        ({'joints': Stream(0.1)}, 'joint states are older than 0.06 s'),
        ({'joints': Stream(delay=0.1)}, 'joint states are older'),
        ({'odometry': Stream(0.05)}, "odometry's readings are older than 0.03 s"),
        ({'odometry': Stream(0.04)}, "odometry's readings are older"),
        ({'odometry': Stream(delay=0.1)}, "odometry's readings are older"),
    ],
    ids=lambda value: '',
)
def test_what_comes_too_seldom_or_too_late_is_named_and_forgiven(streams, words):
    said, inputs = late_after(**streams)
    assert said.startswith(words)
    assert said.endswith('% of the time')
    assert not late_after(inputs=inputs, begin=4.2)[0]


def test_a_single_gap_does_not_count():
    for name in ('imu', 'joints', 'odometry'):
        gap = Stream(gaps=lambda time: 3.8 < time < 3.9)
        assert not late_after(**{name: gap})[0]


@pytest.mark.parametrize('period', [0.08, 0.1])
@pytest.mark.parametrize('name', ['imu', 'joints'])
def test_readings_that_come_with_the_odometry_are_old_before_the_next_ones(name, period):
    # At the odometry they are never as old as just before the next one.
    seldom = {name: Stream(period), 'odometry': Stream(0.02)}
    assert 'are older than 0.06 s' in late_after(**seldom)[0]


@pytest.mark.parametrize('name', ['imu', 'joints'])
def test_a_robot_that_tips_faster_needs_newer_readings(name):
    # With readings every 0.06 s cuhk's trot tilts by 30 degrees; TITAN-VIII's does not.
    for robot, is_late in (('cuhk', True), ('titan_viii', False)):
        loaded = load_robot(robot)
        posture, inputs = loaded.initial_joint_angles.reshape(-1), SensorInputs(loaded)
        said = late_after(**{name: Stream(0.06)}, inputs=inputs, posture=posture)[0]
        assert bool(said) == is_late
        assert not said or 'older than 0.038 s' in said


def travel_problem(delays, began=100.0, clock=0.0):
    """Let odometry and sensors travel for so long, every 0.02 s; return what is late at the end."""
    inputs, said = SensorInputs(load_robot('titan_viii')), ''
    for number, delay in enumerate(delays):
        stamp = began + 0.02 * number
        inputs.take_imu(stamp, LEVEL, 0.0, MOTION)
        inputs.take_joints(JointReadings(POSTURE, STILL, None, stamp))
        said = inputs.take_odometry(stamp, ORIGIN, LEVEL, stamp + delay + clock).late
    return said


@pytest.mark.parametrize('clock', [0.0, -3.0, 2.5])
def test_what_comes_late_all_together_is_noticed_by_the_clock_whatever_that_shows(clock):
    sound, late = [0.01] * 100, [0.16] * 25
    assert not travel_problem(sound, clock=clock)
    said = travel_problem(sound + late, clock=clock)
    assert said.startswith("odometry's readings are older than 0.06 s")
    assert not travel_problem(sound + late + [0.01] * 150, clock=clock)
    assert not travel_problem(sound + [0.16], clock=clock)


def test_a_clock_that_runs_apart_or_is_another_one_tells_nothing():
    # Two quartz clocks run apart by 50 millionths, for an hour.
    assert not travel_problem([1e-6 * k for k in range(180_000)])
    assert not travel_problem([0.16 * (k > 100) for k in range(125)], clock=1.7e9)


def test_a_few_readings_that_seem_to_have_come_before_they_were_sent_count_for_nothing():
    # One whose stamp is of the future, or a clock that is not there yet.
    sound = [0.01] * 100
    assert not travel_problem([-5.0] + sound)
    assert not travel_problem(sound + [-5.0] + sound)
    assert travel_problem([-5.0] + sound + [0.16] * 25)
